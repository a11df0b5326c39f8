"""A structure that is shaken through its base: accelerations over ground are not those over it."""

import math

import numpy as np
import pytest
from scipy.signal import cont2discrete, dlsim, firwin, resample_poly

from modal_core.channel import Channel
from modal_core.mode import Mode
from modal_core.samples import Samples
from oma_identifier.levels import Law, level_law, ModeRecord, motions_at_levels

HZ, RATE_HZ, STEPS, DURATION_S = 10.0, 100.0, 8, 300.0
LOW_PASS = firwin(481, 0.9 / STEPS, window=('kaiser', 9.0))


def motion(seed, zeta, through_base):
    """Return the motion of an oscillator, its steps exact for a force constant within each."""
    omega = 2.0 * math.pi * HZ
    a = np.array([[0.0, 1.0], [-(omega**2), -2.0 * zeta * omega]])
    b = np.array([[0.0], [-1.0 if through_base else 1.0]])
    # Over ground what pulls at the mass accelerates it, and a base that moves does not.
    d = np.array([[0.0 if through_base else 1.0]])
    system = cont2discrete((a, b, a[1:], d), 1.0 / RATE_HZ / STEPS)
    white = np.random.default_rng(seed).standard_normal(round(DURATION_S * RATE_HZ) * STEPS)
    fine = dlsim(system, white)[1]
    rows = resample_poly(fine, 1, STEPS, axis=0, window=LOW_PASS)
    samples = Samples(rows, RATE_HZ, (Channel('x', unit='m/s^2'),))
    mode = Mode(HZ, zeta, np.ones(1, dtype=complex))
    return motions_at_levels([ModeRecord((samples,), mode, [mode], 0)])[0]


@pytest.mark.slow
@pytest.mark.parametrize('through_base', [False, True])
@pytest.mark.parametrize('zeta', [0.02, 0.04])
def test_moments_and_widths_are_those_of_the_mode_whatever_drives_it(zeta, through_base):
    """Over ground stiffness had been 1.5 and 6.8 % low, half-widths 6 and 30 % large."""
    motions = [motion(seed, zeta, through_base) for seed in range(12)]
    stiffness = np.array([each.stiffness for each in motions]) / (2.0 * math.pi * HZ) ** 2
    allowed = np.array([np.hypot(each.stiffness_std / each.stiffness, each.colour_std)
                        for each in motions])  # fmt: skip
    width = np.array([each.half_width_hz() for each in motions]) / (zeta * HZ)
    alone = np.array([each.amplitude_half_width_hz() for each in motions]) / (zeta * HZ)
    said = f'seeds 0 to 11: {stiffness.mean():.4f}, {width[:, 0].mean():.3f}, {alone.mean(0)}'
    print(said)
    assert abs(stiffness.mean() - 1.0) < 3.0 * np.median(allowed) / math.sqrt(12.0), said
    assert np.sum(np.abs(stiffness - 1.0) < 2.0 * allowed) >= 10, said
    assert abs(width[:, 0].mean() - 1.0) < 3.0 * np.median(width[:, 1]) / math.sqrt(12.0), said
    assert abs(alone[:, 0].mean() - 1.0) < 3.0 * np.median(alone[:, 1]) / math.sqrt(12.0), said


def cubic_law(seed, stiffer, through_base):
    """Return the law of an oscillator whose cubic spring adds a share at the largest level.

    The identified modes are the equivalent linear ones.
    """
    oscillator = pytest.importorskip('test.support.cubic_oscillator')
    zeta, k1, force_m = 0.01, (2.0 * math.pi * HZ) ** 2, 1e-3
    largest_m2 = (8.0 * force_m) ** 2 / (4.0 * zeta * k1**1.5)
    k3 = stiffer * k1 / (3.0 * largest_m2)
    records = []
    for level in (1, 2, 4, 8):
        law = (k1, k3, 2.0 * zeta * math.sqrt(k1), 0.0, 0.0)
        rng = np.random.default_rng([seed, level])
        rows = oscillator.accelerations(
            law, level * force_m, DURATION_S, RATE_HZ, rng, through_base
        )[:, None]
        samples = Samples(rows, RATE_HZ, (Channel('x', unit='m/s^2'),))
        # E[q⁴] / E[q²] = 3 E[q²] of a motion about as large as the linear one.
        square = largest_m2 * (level / 8.0) ** 2
        hz = math.sqrt(k1 + 3.0 * k3 * square / (1.0 + 3.0 * k3 * square / k1)) / (2.0 * math.pi)
        mode = Mode(
            hz, zeta * HZ / hz, np.ones(1, dtype=complex),
            frequency_std_hz=hz * math.sqrt(zeta / (2.0 * math.pi * hz * DURATION_S)),
            damping_ratio_std=zeta / math.sqrt(2.0 * math.pi * zeta * HZ * DURATION_S),
        )  # fmt: skip
        records.append(ModeRecord((samples,), mode, [mode], 0))
    found = level_law(motions_at_levels(records))
    return found.mode.cubic_stiffness / k3, found.stiffness.laws


@pytest.mark.slow
@pytest.mark.parametrize('stiffer', [0.05, 0.15, 0.3])
def test_cubic_stiffness_is_the_same_through_the_base(stiffer):
    """It had been 4 % low, and no cubic law where the peak leaves its place."""
    pairs = [[cubic_law(seed, stiffer, base) for base in (False, True)] for seed in range(4)]
    ratio = np.array([[of[0] for of in pair] for pair in pairs])
    said = f'seeds 0 to 3: under a force and through the base {np.round(ratio, 3).tolist()}'
    print(said, [[of[1] for of in pair] for pair in pairs])
    assert all(Law.CUBIC in of[1] for pair in pairs for of in pair), said
    assert np.abs(ratio[:, 1] - ratio[:, 0]).mean() < 0.025, said
