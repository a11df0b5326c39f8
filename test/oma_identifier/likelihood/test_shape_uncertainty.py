"""Uncertainty of mode shapes: honest in every channel, and in the MAC it makes to be expected."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import hilbert

from benchmarks.identifier.plant import chain_plant, Plant, simulate
from modal_core.channel import Channel
from modal_core.mode import Mode, ModeSet
from modal_core.numbers.indicators import mac
from modal_core.samples import Samples
from oma_identifier.compare.comparison import compare_modes
from oma_identifier.compare.expected_mac import expected_mac
from oma_identifier.identify import identify_samples
from oma_identifier.likelihood.shape_scatter import MacLoss
from oma_identifier.refinement.adopt import adopt_refined
from oma_identifier.tracking.tracking import closeness_of, ModeTracker

DURATION_S, RATE_HZ = 40.0, 128.0
N_RUNS, FIRST_SEED = 30, 5100


def plant(n_channels: int) -> Plant:
    """Two modes that overlap and, beside their band, one below and two above."""
    generator = np.random.default_rng(51)
    participation = generator.standard_normal((5, 3))
    return Plant(
        frequency_hz=np.array([7.0, 14.0, 14.8, 26.0, 40.0]),
        damping_ratio=np.array([0.02, 0.02, 0.015, 0.012, 0.015]),
        shapes=generator.standard_normal((n_channels, 5)),
        participation=participation / np.linalg.norm(participation, axis=1, keepdims=True),
    )


def identified(known: Plant, seed: int) -> ModeSet:
    """Return modes refined from starts that are off by what a subspace method errs."""
    generator = np.random.default_rng(seed)
    samples = simulate(known, generator, DURATION_S, RATE_HZ)
    starts = tuple(
        Mode(
            hz * (1.0 + 0.002 * generator.standard_normal()),
            zeta * (1.0 + 0.1 * generator.standard_normal()),
            (shape + 0.03 * generator.standard_normal(len(shape))).astype(complex),
            frequency_std_hz=0.003 * hz,
            damping_ratio_std=0.2 * zeta,
        )
        for hz, zeta, shape in zip(
            known.frequency_hz, known.damping_ratio, known.shapes.T, strict=True
        )
    )
    none = ModeSet((), samples.channel_names)
    return adopt_refined(samples, replace(none, modes=starts), none).modes


@pytest.fixture(scope='module', params=[14, pytest.param(42, marks=pytest.mark.slow)])
def runs(request) -> tuple[Plant, list[ModeSet]]:
    known = plant(request.param)
    return known, [identified(known, FIRST_SEED + run) for run in range(N_RUNS)]


@pytest.mark.slow
def test_the_truth_is_within_two_standard_deviations_in_every_channel(runs):
    known, found = runs
    inside = []
    for modes in found:
        for mode, shape in zip(modes, known.shapes.T, strict=True):
            if mode.shape_std is None:
                continue
            largest = int(np.argmax(np.abs(mode.shape)))
            assert mode.shape_std[largest] == 0.0
            others = np.arange(len(shape)) != largest
            step, std = (mode.shape - shape / shape[largest])[others], mode.shape_std[others]
            inside.append([np.abs(step.real) < 2.0 * std.real, np.abs(step.imag) < 2.0 * std.imag])
    assert len(inside) > 0.85 * 5 * N_RUNS
    share = np.mean(inside, axis=(0, 2))
    # Entries of one shape err together: as if some 300 values each, 95 % ± 1.3 %.
    assert np.all((share > 0.92) & (share < 0.98)), f'seeds from {FIRST_SEED}: {share}'


def test_the_mac_with_the_truth_is_as_expected(runs):
    known, found = runs
    ratio = []
    for index in range(5):
        modes = [each.modes[index] for each in found if np.isfinite(each.modes[index].mac_loss)]
        loss = [1.0 - mac(mode.shape, known.shapes[:, index])[0, 0] for mode in modes]
        ratio.append(np.mean(loss) / np.mean([mode.mac_loss for mode in modes]))
    # Each mean of 30 is known to some 12 %.
    assert 0.85 < np.mean(ratio) < 1.15, f'seeds from {FIRST_SEED}: {ratio}'


def test_two_estimates_of_one_mode_are_as_alike_as_expected(runs):
    _, found = runs
    lost, expected, below = [], [], 0
    for first, second in zip(found[::2], found[1::2], strict=True):
        comparison = compare_modes(first, second)
        assert len(comparison.changes) == 5
        below += sum(change.is_shape_changed for change in comparison.changes)
        lost.append([1.0 - change.mac for change in comparison.changes])
        expected.append([1.0 - change.expected_mac.mean for change in comparison.changes])
    known = np.isfinite(expected)
    assert known.mean() > 0.8
    ratio = np.sum(lost, axis=0, where=known) / np.sum(expected, axis=0, where=known)
    assert 0.8 < np.mean(ratio) < 1.2, f'seeds from {FIRST_SEED}: {ratio}'
    assert below <= 1, f'seeds from {FIRST_SEED}: {below} of 75 beyond three standard deviations'


def complex_record(known: Plant, shapes: np.ndarray, seed: int) -> Samples:
    """Return responses in complex shapes: the analytic motion of every mode times its shape."""
    generator = np.random.default_rng(seed)
    alone = replace(known, shapes=np.eye(len(known.frequency_hz)))
    motion = hilbert(simulate(alone, generator, 60.0, 512.0, noise=0.0).acceleration, axis=0)
    response = (motion @ shapes.T).real
    response += 0.05 * response.std(axis=0) * generator.standard_normal(response.shape)
    return Samples(response, 512.0, tuple(Channel(f'c{row}') for row in range(len(shapes))))


@pytest.mark.slow
def test_shapes_that_are_not_real_are_refined_with_many_channels_too():
    known = chain_plant(42)
    size = np.sqrt(np.mean(known.shapes**2, axis=0))
    generator = np.random.default_rng(53)
    shapes = known.shapes + 0.1j * size * generator.standard_normal(known.shapes.shape)
    n_modes, inside = 0, []
    for seed in range(5300, 5303):
        modes = identify_samples(complex_record(known, shapes, seed)).modes
        n_modes += len(modes)
        for mode in modes:
            if mode.shape_std is None:
                continue
            truth = shapes[:, np.argmin(np.abs(known.frequency_hz - mode.frequency_hz))]
            largest = int(np.argmax(np.abs(mode.shape)))
            step = np.delete(mode.shape - truth / truth[largest], largest)
            std = np.delete(mode.shape_std, largest)
            inside.append([np.abs(step.real) < 2.0 * std.real, np.abs(step.imag) < 2.0 * std.imag])
    assert n_modes == 36
    assert len(inside) >= 32, f'seeds from 5300: {len(inside)} of 36 modes refined'
    share = np.mean(inside, axis=(0, 2))
    assert np.all((share > 0.9) & (share < 0.99)), f'seeds from 5300: {share}'


def test_a_changed_shape_is_told_from_scatter():
    known = plant(14)
    shapes = known.shapes.copy()
    shapes[3, 4] += 0.5
    first = identified(known, 5200)
    second = identified(replace(known, shapes=shapes), 5201)
    changed = [change.is_shape_changed for change in compare_modes(first, second).changes]
    assert changed == [False, False, False, False, True]


def test_quantile_and_mean_are_those_of_gaussian_errors():
    generator = np.random.default_rng(52)
    shape = generator.standard_normal(8) + 0j
    scatter = 0.02 * (generator.standard_normal((8, 5)) + 1j * generator.standard_normal((8, 5)))
    loss = MacLoss.of(shape, scatter)
    mode = Mode(10.0, 0.01, shape, mac_loss=loss.mean, mac_loss_std=loss.std)
    expected = expected_mac(mode, mode)
    drawn = shape + generator.standard_normal((2, 20000, 5)) @ scatter.T
    alike = np.abs(np.sum(drawn[0].conj() * drawn[1], axis=1)) ** 2
    alike /= np.prod(np.sum(np.abs(drawn) ** 2, axis=2), axis=0)
    assert 1.0 - expected.mean == pytest.approx(np.mean(1.0 - alike), rel=0.1)
    # 27 of 20,000 are expected below; the gamma distribution is an approximation there.
    assert 5 <= np.count_nonzero(alike < expected.least) <= 80


def test_unknown_uncertainty_expects_nothing():
    mode = Mode(10.0, 0.01, np.ones(3, dtype=complex))
    assert np.isnan(expected_mac(mode, mode).least)
    (change,) = compare_modes(
        ModeSet((mode,), ('a', 'b', 'c')), ModeSet((mode,), ('a', 'b', 'c'))
    ).changes
    assert not change.is_shape_changed


def test_a_shape_that_is_hardly_determined_costs_a_track_less():
    tracker, names = ModeTracker(), ('a', 'b', 'c')
    first = Mode(10.0, 0.01, np.array([1.0, 0.5, 0.2 + 0j]), 0.02)
    tracker.update(ModeSet((first,), names))
    turned = replace(first, shape=np.array([1.0, -0.9, 0.6 + 0j]))
    vague = replace(turned, mac_loss=0.3, mac_loss_std=0.3)
    sure = replace(turned, mac_loss=1e-4, mac_loss_std=1e-4)
    cost = [
        closeness_of(tracker.tracks[0], each, None, names).cost for each in (vague, sure, turned)
    ]
    assert cost[0] < 0.2 * cost[1]
    assert cost[1] == pytest.approx(cost[2], rel=0.01)
