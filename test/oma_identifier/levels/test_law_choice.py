"""Which law levels are told to follow, of stiffness drawn from a law with its deviation.

No record is made: the motion of a level is a Gaussian envelope, and its stiffness what the law has
there plus noise.  Damping is constant.
"""

from collections import Counter
import math

import numpy as np
from numpy.typing import NDArray
import pytest
from scipy.signal import lfilter
from scipy.special import erfc

from oma_identifier.levels import Law, level_law, ModalMotion

HZ, RATE_HZ, HALF_WIDTH_HZ, RELATIVE_STD = 10.0, 3.2, 0.2, 1e-3
STIFFNESS = (2.0 * math.pi * HZ) ** 2
LARGEST_M = 1e-3


def motion(rng, displacement_m, stiffness, n=400) -> ModalMotion:
    """Return a level."""
    decay = math.exp(-2.0 * math.pi * HALF_WIDTH_HZ / RATE_HZ)
    white: NDArray[np.complex128] = rng.standard_normal(n) + 1j * rng.standard_normal(n)
    envelope = lfilter([1.0], [1.0, -decay], white)
    envelope *= displacement_m * math.sqrt(2.0 / np.mean(np.abs(envelope) ** 2))
    velocity_m_s = displacement_m * 2.0 * math.pi * HZ
    std = RELATIVE_STD * stiffness
    seen = stiffness + std * rng.standard_normal()
    hz = math.sqrt(seen) / (2.0 * math.pi)
    return ModalMotion(
        displacement_m, velocity_m_s, 3.0 * displacement_m**2, 3.0 * velocity_m_s**2, 3e-3,
        seen, std, 0.0, (envelope,), RATE_HZ, HZ, 0.0,
        frequency_hz=hz, frequency_std_hz=0.5 * RELATIVE_STD * hz, damping_ratio=0.02,
    )  # fmt: skip


def told(seed, levels, added):
    """Return the law of levels up to the largest, ``added`` of what is measured in it."""
    rng = np.random.default_rng(seed)
    over = np.geomspace(1.0 / 8.0, 1.0, levels)
    return level_law(
        [motion(rng, each * LARGEST_M, STIFFNESS * (1.0 + added(each))) for each in over]
    )


ADDED = {
    Law.CONSTANT: lambda each: 0.0,
    Law.CUBIC: lambda each: 0.1 * each**2,
    Law.PLAY: lambda each: 0.3 * erfc(0.6 / math.sqrt(2.0) / each),
    Law.FRICTION: lambda each: -0.3 * erfc(0.15 / math.sqrt(2.0) / each),
}


@pytest.mark.parametrize('levels', [3, 5])
@pytest.mark.parametrize('law', ADDED)
def test_the_law_that_holds_is_left_and_what_is_without_motion_within_its_deviation(law, levels):
    """Of twelve draws eleven at least."""
    found = [told(seed, levels, ADDED[law]) for seed in range(79300, 79312)]
    said = Counter(each.stiffness.words for each in found)
    print(f'seeds 79300 to 79311, {levels} levels: {said}')
    assert sum(law in each.stiffness.laws for each in found) >= 11, said
    off = [(each.mode.frequency_hz - HZ) / each.frequency_std_hz for each in found]
    assert np.sum(np.abs(off) < 2.0) >= 10, np.round(off, 1)


def test_three_levels_do_not_tell_a_cubic_law_from_play_and_more_do():
    few = told(79320, 3, ADDED[Law.CUBIC]).stiffness
    assert set(few.laws) == {Law.CUBIC, Law.PLAY}
    assert 0.5 / 8.0 * LARGEST_M <= few.another_level <= 2.0 * LARGEST_M
    assert told(79320, 6, ADDED[Law.CUBIC]).stiffness.laws == (Law.CUBIC,)


def test_no_law_is_named_that_the_levels_do_not_follow():
    """Up and down again."""
    found = told(79330, 5, lambda each: 0.1 * math.sin(9.0 * each))
    assert found.stiffness.laws == (Law.OTHER,)
    assert math.isnan(found.cubic_stiffness_std)
