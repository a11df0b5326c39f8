"""Modes so damped that their bells lie in each other, in quiet records: all there, none twice."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.identifier.plant import Plant, simulate
from benchmarks.identifier.scatter import match
from modal_core.samples import Samples
from oma_identifier.identify import identify_samples
from oma_identifier.likelihood import BandData, BandModel, fit_band
from oma_identifier.refinement.acceptance import Outcome
from oma_identifier.refinement.refinement import refine
from test.support.plant_modes import modes_of

RATE_HZ, DURATION_S = 100.0, 120.0
SEEDS = range(40, 46)


def record(seed: int) -> tuple[Plant, Samples]:
    """A mode alone, and a pair of which the broader one lies around the other."""
    generator = np.random.default_rng(seed)
    plant = Plant(
        frequency_hz=np.array([11.0, 20.7, 21.6]),
        damping_ratio=np.array([0.10, 0.095, 0.055]),
        shapes=generator.standard_normal((6, 3)),
        participation=generator.standard_normal((3, 3)),
    )
    return plant, simulate(plant, generator, DURATION_S, RATE_HZ, noise=0.001)


@pytest.fixture(scope='module')
def records() -> list[tuple[Plant, Samples]]:
    return [record(seed) for seed in SEEDS]


def test_modes_whose_bells_lie_in_each_other_are_found_and_refined(
    records: list[tuple[Plant, Samples]],
) -> None:
    n_refined = 0
    for plant, samples in records:
        found = identify_samples(samples).modes
        values, left = match(found, plant)
        assert np.isfinite(values[0]).all(), SEEDS
        assert not left, SEEDS
        n_refined += sum(mode.shape_std is not None for mode in found)
    assert n_refined >= 3 * len(SEEDS) - 1, f'seeds {SEEDS}: {n_refined}'


def test_the_likelihood_finds_a_broad_mode_that_nobody_lists(
    records: list[tuple[Plant, Samples]],
) -> None:
    refined = [refine(samples, modes_of(plant, samples, [0, 2])) for plant, samples in records]
    near = [abs(mode.frequency_hz - 20.7) < 0.3 for each in refined for mode in each.added]
    assert all(near), SEEDS
    assert len(near) >= len(SEEDS) - 2, SEEDS


def test_a_broad_mode_listed_twice_is_dropped_once_in_a_quiet_record(
    records: list[tuple[Plant, Samples]],
) -> None:
    for plant, samples in records:
        modes = modes_of(plant, samples, [0, 1, 2])
        again = replace(modes.modes[1], frequency_hz=20.1, damping_ratio=0.07)
        outcomes = refine(samples, replace(modes, modes=(*modes.modes, again))).outcomes
        assert {outcomes[0], outcomes[2]} == {Outcome.REFINED}, SEEDS
        assert set(outcomes[1::2]) == {Outcome.REFINED, Outcome.SUPERFLUOUS}, SEEDS


def test_what_a_band_does_not_tell_is_not_certain() -> None:
    """Two modes of one shape and next to one pole: which of them has which is open."""
    generator = np.random.default_rng(50)
    count, shape = 40, np.array([1.0, 0.0, 0.0]) + 0j
    white = generator.standard_normal((count, 3, 2)) @ np.array([1.0, 1j])
    lines = np.linspace(9.0, 11.0, count)
    periodogram = np.einsum('kc,kd->kcd', white, white.conj())
    data = BandData(lines, periodogram, np.ones(count))
    twins = BandModel(
        np.array([10.0, 10.001]),
        np.full(2, 0.02),
        np.column_stack([shape, shape]),
        np.eye(2, dtype=complex),
        np.ones(3),
        n_free=2,
        reference_hz=10.0,
    )
    found = fit_band(data, twins, max_steps=0)
    assert np.all(found.frequency_std > 1.0)
    assert np.all(found.damping_ratio_std > 1.0)
