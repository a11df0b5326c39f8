"""Laws of an oscillator at four levels of white force, from what the identifier finds of it."""

import math

import numpy as np
import pytest

import autonomous_modal_analysis as ama
from autonomous_modal_analysis.compared.mode_courses import mode_courses
from autonomous_modal_analysis.compared.mode_levels import mode_levels
from oma_identifier.compare import compare_modes
from oma_identifier.levels import Law, level_law, ModeRecord, motions_at_levels

pytest.importorskip('numba')
from test.support.cubic_chain import LEVELS as CHAIN_LEVELS
from test.support.cubic_chain import random_chain
from test.support.cubic_chain import RATE_HZ as CHAIN_RATE_HZ
from test.support.cubic_oscillator import accelerations

RATE_HZ = 100.0
LEVELS = (1 / 8, 1 / 4, 1 / 2, 1.0)
LARGEST_M = 1e-3
OWN, BESIDE = np.array([1.0, 0.6, -0.3, 0.1]), np.array([0.3, -0.7, 0.8, 1.0])


class Case:
    """An oscillator and a linear one beside it, at four levels.

    Shares are what each cubic term and friction adds at the largest level were it linear.
    """

    def __init__(self, seed, duration_s, stiffer=0.0, damped=0.0, friction=0.0):
        rng = np.random.default_rng(seed)
        self.hz, self.zeta = 8.0 * math.exp(rng.uniform(-0.3, 0.5)), rng.uniform(0.01, 0.03)
        self.k1 = (2.0 * math.pi * self.hz) ** 2
        self.c1 = 4.0 * math.pi * self.zeta * self.hz
        self.k3 = stiffer * self.k1 / (3.0 * LARGEST_M**2)
        self.c3 = damped * self.c1 / (3.0 * LARGEST_M**2 * self.k1)
        force = LARGEST_M * math.sqrt(2.0 * self.c1 * self.k1)
        dry = friction * self.c1 * LARGEST_M * math.sqrt(self.k1)
        law = (self.k1, self.k3, self.c1, self.c3, dry)
        records = []
        for level in LEVELS:
            linear = (5.3 * self.k1, 0.0, 2.3 * self.c1, 0.0, 0.0)
            own = accelerations(law, level * force, duration_s, RATE_HZ, rng)
            beside = accelerations(linear, 3.0 * level * force, duration_s, RATE_HZ, rng)
            rows = np.outer(own, OWN) + np.outer(beside, BESIDE)
            rows += 0.02 * rows.std() * rng.standard_normal(rows.shape)
            found = ama.identify(rows, sample_rate_hz=RATE_HZ)
            mode = min(found.modes, key=lambda each: abs(each.frequency_hz - self.hz))
            records.append(ModeRecord(found.found.parts, mode, list(found.modes), 0))
        self.motions = motions_at_levels(records)
        self.law = level_law(self.motions)


@pytest.mark.slow
@pytest.mark.parametrize('seed', [7600, 7601])
def test_cubic_stiffness_and_damping_are_found(seed):
    case = Case(seed, 1200.0, stiffer=0.06, damped=1.5)
    law = case.law
    told = (law.mode.cubic_stiffness, law.mode.cubic_damping)
    print(f'seed {seed}: {told[0] / case.k3:.3f}, {told[1] / case.c3:.3f}')
    assert Law.CUBIC in law.stiffness.laws and law.damping.laws == (Law.CUBIC,)
    # The mode beside might have a part, which widens the deviations of the mode's own terms.
    assert abs(told[0] - case.k3) < 3.0 * law.cubic_stiffness_std
    assert abs(told[1] - case.c3) < 3.0 * law.cubic_damping_std
    k, c = law.stiffness.cubic, law.damping.cubic
    assert abs(k.slope - case.k3) < min(3.0 * k.slope_std, 0.1 * case.k3)
    assert abs(c.slope - case.c3) < 3.0 * c.slope_std < case.c3
    assert abs(law.mode.frequency_hz - case.hz) < 3.0 * law.frequency_std_hz
    assert abs(law.mode.damping_ratio - case.zeta) < 3.0 * law.damping_ratio_std


@pytest.mark.slow
def test_deviations_are_those_of_the_scatter():
    """Eight oscillators of 300 s, cubic in both."""
    off = []
    for seed in range(7200, 7208):
        case = Case(seed, 300.0, stiffer=0.1, damped=1.0)
        law = case.law
        off.append((law.mode.cubic_stiffness - case.k3) / law.cubic_stiffness_std)
        off.append((law.mode.cubic_damping - case.c3) / law.cubic_damping_std)
    known = np.array([each for each in off if math.isfinite(each)])
    rms = math.sqrt(np.mean(known**2))
    print(f'seeds 7200 to 7207: {len(known)} values, rms {rms:.2f}, largest {known.max():.1f}')
    assert len(known) >= 12
    # χ² of 12 degrees of freedom lies within these in 99 of 100 cases.
    assert 0.5 < rms < 1.54
    assert np.abs(known).max() < 3.5


@pytest.mark.slow
def test_a_linear_mode_changes_with_no_level_and_friction_is_no_cubic_term():
    linear = Case(7300, 600.0).law
    assert linear.stiffness.is_constant and linear.damping.is_constant
    assert abs(linear.mode.cubic_stiffness) < 3.0 * linear.cubic_stiffness_std
    dry = Case(7301, 600.0, friction=0.12).law
    assert dry.damping.laws == (Law.FRICTION,), dry.damping.words


@pytest.mark.slow
@pytest.mark.parametrize('seed', [7801, 7812, 7820])
def test_linear_damping_of_a_chain_with_few_springs_has_no_law(seed):
    """Of modes of each the width had been told to be cubic damping, or another law."""
    chain = random_chain(seed)
    results = [
        ama.identify(chain.accelerations(level, 300.0), sample_rate_hz=CHAIN_RATE_HZ, window_s=300)
        for level in CHAIN_LEVELS
    ]
    changes = [compare_modes(results[0].modes, each.modes) for each in results[1:]]
    laws = [each.law for each in mode_levels(results, mode_courses(results[0].modes, changes))]
    told = [law for law in laws if law is not None]
    said = [(law.mode.frequency_hz, law.damping.words) for law in told]
    assert len(told) >= 2, f'seed {seed}: {said}'
    words = {law.damping.words for law in told}
    assert words <= {Law.CONSTANT, Law.UNKNOWN}, f'seed {seed}: {said}'
    assert any(law.by_amplitude for law in told), f'seed {seed}: {said}'
    for law in (each for each in told if math.isfinite(each.damping_ratio_std)):
        nearest = np.argmin(np.abs(chain.frequency_hz - law.mode.frequency_hz))
        off = (law.mode.damping_ratio - chain.damping_ratio[nearest]) / law.damping_ratio_std
        assert abs(off) < 3.5, f'seed {seed}: {said}, {off:.1f}'


@pytest.mark.slow
def test_stiffness_that_bends_the_peak_beyond_its_width_leaves_damping_without_deviation():
    law = Case(7302, 300.0, stiffer=0.6).law
    assert Law.CUBIC in law.stiffness.laws
    assert math.isnan(law.cubic_damping_std)


def test_motion_is_that_of_the_oscillator_and_noise_has_none():
    """Seed 7400: displacement and velocity in root mean square, beside a known answer."""
    case = Case(7400, 120.0)
    for level, motion in zip(LEVELS, case.motions, strict=True):
        expected = level * LARGEST_M
        assert motion.displacement_m == pytest.approx(expected, rel=0.3)
        assert motion.velocity_m_s / motion.displacement_m == pytest.approx(
            2.0 * math.pi * motion.frequency_hz, rel=0.01
        )
        assert motion.square_m2 == pytest.approx(3.0 * motion.displacement_m**2, rel=0.25)
