"""A refinement starts from the last window where the structure is the same, and only there."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from benchmarks.identifier.plant import Plant, simulate
from modal_core.mode import Mode, ModeSet
from modal_core.numbers.indicators import mac
from modal_core.samples import Samples
from oma_identifier.likelihood.continued import continued
from oma_identifier.likelihood.group_fits import fit_group, unit, updated
from oma_identifier.likelihood.line_spectra import spectra_of, usable_lines
from oma_identifier.likelihood.mode_groups import group_modes, StartModes
from oma_identifier.refinement import band_fitter
from oma_identifier.refinement.acceptance import Outcome
from oma_identifier.refinement.adopt import Refiner
from oma_identifier.refinement.refinement import refine, Refinement
from oma_identifier.refinement.warm_start import WarmStart

RATE_HZ, WINDOW_S = 128.0, 60.0
SEEDS = range(640, 646)
N_CHANNELS = 14
MANY, FEW = range(N_CHANNELS), range(5)


def plant(shift: float = 1.0) -> Plant:
    generator = np.random.default_rng(11)
    return Plant(
        frequency_hz=shift * np.array([7.0, 16.0, 17.2, 40.0]),
        damping_ratio=np.array([0.02, 0.02, 0.025, 0.015]),
        shapes=generator.standard_normal((N_CHANNELS, 4)),
        participation=generator.standard_normal((4, 4)),
    )


def windows(seed: int, channels: range) -> tuple[Samples, Samples]:
    """Return two halves of one record."""
    rows = list(channels)
    own = replace(plant(), shapes=plant().shapes[rows])
    whole = simulate(own, np.random.default_rng(seed), 2.0 * WINDOW_S, RATE_HZ)
    half = round(WINDOW_S * RATE_HZ)
    return (
        replace(whole, acceleration=whole.acceleration[:half]),
        replace(whole, acceleration=whole.acceleration[half:]),
    )


def given(samples: Samples, seed: int, truth: Plant | None = None) -> ModeSet:
    """Return modes that scatter as those of a subspace method do."""
    truth, generator = truth or plant(), np.random.default_rng(seed)
    modes = []
    for index, frequency_hz in enumerate(truth.frequency_hz):
        ratio = float(truth.damping_ratio[index])
        law = float(np.sqrt(ratio / (2 * np.pi * frequency_hz * WINDOW_S)))
        shape = truth.shapes[: len(samples.channels), index]
        modes.append(
            Mode(
                frequency_hz=frequency_hz * (1 + 1.4 * law * generator.standard_normal()),
                frequency_std_hz=1.4 * law * frequency_hz,
                damping_ratio=ratio + 1.4 * law * generator.standard_normal(),
                damping_ratio_std=1.4 * law,
                shape=(shape + 0.03 * generator.standard_normal(len(shape))).astype(complex),
            )
        )
    return ModeSet(tuple(modes), samples.channel_names)


def left_by(result: Refinement) -> WarmStart:
    known = tuple(each for each in result.refined if each is not None)
    return WarmStart(result.channels, known)


@pytest.fixture
def n_fits(monkeypatch) -> list[int]:
    """Count the fits."""
    counter = [0]
    fit_group = band_fitter.fit_group

    def counted(*arguments):
        counter[0] += 1
        return fit_group(*arguments)

    monkeypatch.setattr(band_fitter, 'fit_group', counted)
    return counter


@pytest.mark.parametrize('channels', [MANY, FEW])
def test_one_pass_from_the_last_window_finds_what_two_find(channels, n_fits):
    steps, n_spared = [], 0
    for seed in SEEDS:
        first, second = windows(seed, channels)
        before = refine(first, given(first, seed))
        start, n_fits[0] = given(second, seed + 1), 0
        twice = refine(second, start)
        n_twice, n_fits[0] = n_fits[0], 0
        once = refine(second, start, warm_start=left_by(before))
        n_spared += 2 * n_fits[0] == n_twice
        for index, (one, other) in enumerate(zip(once.modes, twice.modes, strict=True)):
            if {once.outcomes[index], twice.outcomes[index]} != {Outcome.REFINED}:
                continue
            f_step = (one.frequency_hz - other.frequency_hz) / other.frequency_std_hz
            d_step = (one.damping_ratio - other.damping_ratio) / other.damping_ratio_std
            steps.append([f_step, d_step])
            assert one.frequency_std_hz == pytest.approx(other.frequency_std_hz, rel=0.1)
            truth = plant().shapes[list(channels), index]
            assert mac(one.shape, truth)[0, 0] > mac(other.shape, truth)[0, 0] - 0.02, seed
    # By chance one of 48 differences of both windows is beyond four standard deviations.
    assert n_spared >= len(SEEDS) - 1, f'seeds {SEEDS}: {n_spared}'
    assert len(steps) >= 4 * len(SEEDS) - 2, f'seeds {SEEDS}: {len(steps)}'
    # A third of a standard deviation, if it were all error, would add 5 % to the scatter.
    assert np.sqrt(np.mean(np.square(steps))) < 1.0 / 3.0, f'seeds {SEEDS}: {steps}'
    assert np.all(np.abs(np.mean(steps, axis=0)) < 0.15), f'seeds {SEEDS}: {steps}'


def test_a_structure_that_changed_is_refined_as_if_nothing_was_known():
    first, _ = windows(640, MANY)
    changed = plant(1.05)
    samples = simulate(changed, np.random.default_rng(641), WINDOW_S, RATE_HZ)
    before = refine(first, given(first, 640))
    start = given(samples, 642, changed)
    alone, after = refine(samples, start), refine(samples, start, warm_start=left_by(before))
    for one, other in zip(after.modes, alone.modes, strict=True):
        assert one.frequency_hz == other.frequency_hz
        assert one.damping_ratio == other.damping_ratio


def test_a_channel_that_dies_makes_the_window_start_afresh(n_fits):
    first, second = windows(643, MANY)
    before = refine(first, given(first, 643))
    rows = second.acceleration.copy()
    rows[:, 3] = 0.0
    dead = replace(second, acceleration=rows)
    n_fits[0] = 0
    refine(dead, given(dead, 644))
    alone, n_fits[0] = n_fits[0], 0
    refine(dead, given(dead, 644), warm_start=left_by(before))
    assert n_fits[0] == alone


def test_other_sensors_make_the_window_start_afresh(n_fits):
    """Twice the fits, wherever the first window left something to begin with."""
    n_twice = 0
    for seed in SEEDS:
        first, second = windows(seed, MANY)
        none = ModeSet((), first.channel_names)
        counts = []
        for renamed in (False, True):
            refiner = Refiner()
            refiner.adopt(first, given(first, seed), none)
            if renamed:
                other = tuple(replace(each, name=f'{each.name}_new') for each in second.channels)
                second = replace(second, channels=other)
            n_fits[0] = 0
            refiner.adopt(second, given(second, seed + 1), none)
            counts.append(n_fits[0])
        n_twice += counts[1] == 2 * counts[0]
        assert counts[1] in (counts[0], 2 * counts[0]), f'seed {seed}: {counts}'
    # A window that left a mode as it was given hands nothing on: two of these six.
    assert n_twice >= len(SEEDS) - 2, f'seeds {SEEDS}: {n_twice}'


def test_what_a_fit_left_of_a_shape_is_never_handed_on():
    first, _ = windows(645, MANY)
    before = refine(first, given(first, 645))
    known = before.refined[0]
    plain = plant().shapes[:, 0] + 0.3 * np.random.default_rng(646).standard_normal(N_CHANNELS)
    plain = (plain / np.linalg.norm(plain)).astype(complex)
    band = known.fit.band
    shape = known.shape_with(plain)
    assert not band.is_whole
    # Refined coordinates are the fit's, the part projected out is that of the new estimate.
    fitted = known.fit.fit.model.shapes[:, known.position]
    assert mac(band.project.T @ shape, fitted)[0, 0] == pytest.approx(1.0, abs=1e-9)
    out = band.projected_out(plain)
    assert np.linalg.norm(out) > 0.01
    assert mac(band.projected_out(shape), out)[0, 0] == pytest.approx(1.0, abs=1e-9)


@pytest.mark.parametrize('channels', [MANY, FEW])
def test_a_fit_that_is_continued_arrives_where_it_would_have_arrived(channels):
    n_steps = []
    index = {mode: mode for mode in range(4)}
    for seed in SEEDS:
        first, second = windows(seed, channels)
        alive = np.arange(len(channels))
        chosen = given(first, seed)
        start = StartModes(
            chosen.frequency_hz,
            chosen.damping_ratio,
            np.column_stack([unit(mode.shape) for mode in chosen]),
        )
        spectra = [spectra_of(samples, alive) for samples in (first, second)]
        usable = usable_lines(spectra[0], ())
        for group in group_modes(start, 0.0):
            before = fit_group(spectra[0], start, group, usable)
            if not before.fit.converged:
                continue
            now = updated(start, [before])
            begin = partial(continued, before=before, index=index)
            for own in spectra:
                alone = fit_group(own, now, group, usable)
                after = fit_group(own, now, group, usable, begin=begin)
                if own is spectra[0]:
                    n_steps.append([alone.fit.n_steps, after.fit.n_steps])
                if not (alone.fit.converged and after.fit.converged):
                    continue
                # The better the model, the better what the record's ends do is taken out: the
                # data are not quite the same.
                step = after.fit.model.frequency_hz / alone.fit.model.frequency_hz - 1.0
                small = np.abs(step[: len(group)]) < 0.3 * alone.fit.frequency_std
                better = alone.fit.value - after.fit.value > 0.01
                assert np.all(small) or better, (seed, group, step[: len(group)])
    total = np.sum(n_steps, axis=0)
    assert total[1] < 0.85 * total[0], f'seeds {SEEDS}: {n_steps}'


def test_a_fit_of_other_modes_is_not_continued():
    first, _ = windows(640, FEW)
    before = refine(first, given(first, 640)).refined[0]
    band = before.fit.band
    assert continued(band, before.fit, {mode: mode for mode in range(4)}) is not None
    assert continued(band, before.fit, {mode: mode for mode in range(3)}) is None
    assert continued(replace(band, included=band.included[:-1]), before.fit, {0: 0}) is None
    assert continued(band, None, {}) is None
