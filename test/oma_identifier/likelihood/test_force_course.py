"""Forces that grow or burst tell less than steady ones: deviations say so."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from modal_core.channel import Channel
from modal_core.mode import Mode, ModeSet
from modal_core.samples import Samples
from oma_identifier.likelihood import ForceCourse
from oma_identifier.refinement.acceptance import TAKEN
from oma_identifier.refinement.refinement import refine
from oma_identifier.refinement.refining import GivenIndex, Record, Refining
from oma_identifier.refinement.stages import fit_groups

RATE_HZ, DURATION_S = 64.0, 100.0
FREQUENCY_HZ, DAMPING = np.array([6.0, 13.0]), np.array([0.02, 0.015])
SHAPES = np.array([[1.0, 0.6], [0.7, -1.0], [0.4, 0.8]])
N_RUNS = 60


def bursts(n_samples: int) -> np.ndarray:
    """Return a force that is strong for a tenth of the time and steady otherwise."""
    share = np.arange(n_samples) / n_samples
    places = (0.2, 0.55, 0.8)
    return 0.05 + sum(np.exp(-0.5 * ((share - place) / 0.02) ** 2) for place in places)


def record(seed: int, envelope: np.ndarray) -> Samples:
    """Return the responses of two modes to forces of such strength."""
    generator = np.random.default_rng(seed)
    omega = 2 * np.pi * FREQUENCY_HZ
    pole = np.exp(omega * (-DAMPING + 1j * np.sqrt(1 - DAMPING**2)) / RATE_HZ)
    forces = envelope * generator.standard_normal((2, len(envelope)))
    modal = [
        lfilter([1.0, -2.0, 1.0], [1.0, -2.0 * p.real, abs(p) ** 2], force)
        for p, force in zip(pole, forces, strict=True)
    ]
    clean = SHAPES @ np.array(modal)
    noise = 0.01 * clean.std() * generator.standard_normal(clean.shape)
    channels = tuple(Channel(f'ch{number}') for number in range(3))
    return Samples((clean + noise).T, RATE_HZ, channels)


START = ModeSet(
    tuple(
        Mode(f, z, SHAPES[:, place].astype(complex))
        for place, (f, z) in enumerate(zip(FREQUENCY_HZ, DAMPING, strict=True))
    ),
    ('ch0', 'ch1', 'ch2'),
)


def surprises(envelope: np.ndarray, seeds: range) -> np.ndarray:
    """Return the errors of frequencies and damping ratios over their deviations."""
    found = []
    for seed in seeds:
        result = refine(record(seed, envelope), START)
        for mode, outcome, f, z in zip(
            result.modes, result.outcomes, FREQUENCY_HZ, DAMPING, strict=True
        ):
            if outcome in TAKEN:
                found.append((mode.frequency_hz - f) / mode.frequency_std_hz)
                found.append((mode.damping_ratio - z) / mode.damping_ratio_std)
    return np.array(found)


@pytest.mark.slow
@pytest.mark.parametrize('kind', ['bursts', 'growth', 'steady'])
def test_deviations_hold_whatever_the_course_of_the_forces(kind):
    n_samples = int(RATE_HZ * DURATION_S)
    envelope = {
        'bursts': bursts(n_samples),
        'growth': np.exp(np.linspace(0.0, 3.0, n_samples)),
        'steady': np.ones(n_samples),
    }[kind]
    errors = surprises(envelope, range(N_RUNS))
    assert len(errors) > 3.5 * N_RUNS, 'refinement was turned down'
    inside = np.mean(np.abs(errors) < 2.0)
    # 240 values: two standard errors of 0.95 are 0.03.
    assert 0.92 < inside < 0.985, f'{kind}: {inside:.3f}'


@pytest.mark.parametrize('lost', [(0,), (0, 1)])
def test_a_force_whose_power_came_out_below_zero_tells_nothing_of_its_course(lost):
    samples = record(0, bursts(int(RATE_HZ * DURATION_S)))
    begun = Record.of(samples, START, None, (), None)
    first, second = fit_groups(Refining.begin(begun, [GivenIndex(0), GivenIndex(1)])).fits
    force = first.fit.model.force.copy()
    for mode in lost:
        force[mode, :] = force[:, mode] = 0.0
        force[mode, mode] = -1e-3
    model = replace(first.fit.model, force=force)
    without = replace(first, fit=replace(first.fit, model=model))
    with np.errstate(over='raise', invalid='raise', divide='raise'):
        course = ForceCourse.of(begun.spectra, [without, second])
    alone = ForceCourse.of(begun.spectra, [second])
    assert alone.widening(0.2) > 1.2
    assert course.widening(0.2) == pytest.approx(alone.widening(0.2))
