"""Merging set-ups: who is who, what they have in common, one shape over all points."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from modal_core.channel import Channel
from modal_core.mode import Mode, ModeSet
from modal_core.numbers.indicators import mac, normalise
from modal_core.samples import Samples
from oma_identifier.compare import merge_modes
from oma_identifier.compare.common_values import common_values
from oma_identifier.likelihood import MacLoss, normalised_std

SEED = 20
REFERENCES = 3


def estimate(rng, frequency_hz, damping_ratio, shape, noise):
    """Return a mode as an identification states it, with errors as large as it states."""
    deviation = 1e-3 * frequency_hz, 0.1 * damping_ratio
    size = noise * np.linalg.norm(shape) / np.sqrt(len(shape))
    scatter = size * np.concatenate([np.eye(len(shape)), 1j * np.eye(len(shape))], axis=1)
    noisy = shape * np.exp(6j * rng.random()) + scatter @ rng.normal(size=2 * len(shape))
    loss = MacLoss.of(noisy, scatter)
    return Mode(
        frequency_hz + deviation[0] * rng.normal(),
        damping_ratio + deviation[1] * rng.normal(),
        normalise(noisy),
        *deviation,
        shape_std=normalised_std(noisy, scatter),
        mac_loss=loss.mean,
        mac_loss_std=loss.std,
    )


def drawn(rng, n_setups, seen=0.7, scatter=0.0, n_roving=3):
    """Return set-ups of a random structure, its shapes and which mode is which."""
    frequency = np.sort(rng.uniform(2.0, 40.0, rng.integers(2, 12)))
    frequency[1] = frequency[0] * 1.006
    shapes = rng.normal(size=(REFERENCES + n_setups * n_roving, len(frequency)))
    setups, members = [], []
    for k in range(n_setups):
        own = np.r_[:REFERENCES, REFERENCES + k * n_roving + np.arange(n_roving)]
        which = np.flatnonzero(rng.random(len(frequency)) < seen)
        here = frequency * (1.0 + scatter * (rng.normal() + 0.3 * rng.normal(size=len(frequency))))
        modes = [estimate(rng, here[m], 0.02, shapes[own, m], 0.03) for m in which]
        order = np.argsort([mode.frequency_hz for mode in modes])
        names = tuple(f'p{point}' for point in own)
        setups.append(ModeSet(tuple(modes[i] for i in order), names))
        members.append([int(which[i]) for i in order])
    return setups, shapes, members


@pytest.mark.parametrize(('n_setups', 'scatter'), [(2, 0.0), (4, 0.003), (15, 0.0), (15, 0.003)])
def test_modes_that_some_set_ups_missed_stay_without_their_points(n_setups, scatter):
    rng = np.random.default_rng([SEED, n_setups])
    for _ in range(3):
        setups, shapes, members = drawn(rng, n_setups, scatter=scatter)
        merged = merge_modes(setups)
        who = {
            m: tuple(k for k in range(n_setups) if m in members[k]) for m in range(shapes.shape[1])
        }
        who = {m: seen for m, seen in who.items() if seen}
        assert sorted(merged.seen_in) == sorted(who.values()), f'seed {SEED}'
        names = merged.modes.channel_names
        for mode, seen in zip(merged.modes, merged.seen_in, strict=True):
            known = [name for name, entry in zip(names, mode.shape, strict=True) if entry == entry]
            assert set(known) == {name for k in seen for name in setups[k].channel_names}
            rows, own = [int(name[1:]) for name in known], mode.shape[np.isfinite(mode.shape)]
            true = max((m for m in who if who[m] == seen), key=lambda m: mac(own, shapes[rows, m]))
            loss = 1.0 - mac(own, shapes[rows, true]).item()
            assert loss < mode.mac_loss + 6.0 * mode.mac_loss_std, f'seed {SEED}'


def test_deviations_of_a_merged_shape_are_what_it_scatters_by():
    rng, errors = np.random.default_rng(SEED + 1), []
    for _ in range(40):
        setups, shapes, _ = drawn(rng, 4, seen=1.0)
        merged = merge_modes(setups)
        for mode, shape in zip(merged.modes, shapes.T, strict=True):
            truth = normalise(shape / shape[np.argmax(np.abs(mode.shape))])
            error, std = mode.shape - truth, mode.shape_std
            known = (std.real > 0.0) & (mac(mode.shape, shape).item() > 0.9)
            errors += list((error.real / np.where(known, std.real, 1.0))[known])
    # Points share the errors of references and of the largest entry: some tens are independent.
    assert 0.92 < np.mean(np.abs(errors) < 2.0) < 0.98, f'seed {SEED + 1}, {len(errors)} entries'


def test_a_frequency_between_two_modes_of_one_reference_is_left_out():
    def setup(name, *frequencies_hz):
        shape = np.array([1.0, 0.5 + 0j])
        modes = (Mode(f, 0.01, shape, 0.002 * f, 0.001) for f in frequencies_hz)
        return ModeSet(tuple(modes), ('reference', name))

    # Shifted by half their distance: nothing tells which the single mode of the last set-up is.
    merged = merge_modes([setup('a', 10.0, 10.2), setup('b', 10.0, 10.2), setup('c', 10.1)])
    assert merged.seen_in == ((0, 1), (0, 1))
    assert np.isnan(merged.modes.shapes[-1]).all()


@pytest.mark.parametrize('n_setups', [3, 15])
@pytest.mark.parametrize('scatter', [0.0, 0.5, 5.0])
def test_two_sigma_of_common_values_cover_with_and_without_scatter(n_setups, scatter):
    rng, inside = np.random.default_rng([SEED, n_setups, int(10 * scatter)]), []
    for _ in range(25):
        stated = 1e-3 * np.exp(0.4 * rng.normal(size=(6, 1))) * np.ones((6, n_setups))
        error = stated * rng.normal(size=stated.shape)
        error += 1e-3 * scatter * (rng.normal(size=n_setups) + 0.5 * rng.normal(size=stated.shape))
        error[rng.random(stated.shape) < 0.2] = np.nan
        found = common_values(error, np.where(np.isnan(error), np.nan, stated), 0.1)
        inside += list((np.abs(found.value) < 2.0 * found.std)[np.isfinite(found.value)])
    # A shift that all modes share makes one independent answer of each of the 25.
    assert np.mean(inside) > 0.955 - 3.0 * np.sqrt(0.045 / 25), f'seed {SEED}'
    assert n_setups < 15 or np.median(found.std) < 3.0 * 1e-3 * np.hypot(1.0, scatter) / 15**0.5


def roving(rng, n_setups, present):
    """Return the samples of set-ups, (frequencies, damping ratios, shapes) and their modes.

    Two modes, 5 and 5.4 Hz; the second is stated of the set-ups present alone.
    """
    frequency, damping, rate_hz = (5.0, 5.4), (0.002, 0.003), 50.0
    shapes = rng.normal(size=(2 + 2 * n_setups, 2))
    samples, setups = [], []
    for k in range(n_setups):
        rows = [0, 1, 2 + 2 * k, 3 + 2 * k]
        data = 0.3 * rng.normal(size=(6000, 4))
        for f, d, shape in zip(frequency, damping, shapes[rows].T, strict=True):
            pole = np.exp(2 * np.pi * f * (-d + 1j * np.sqrt(1 - d**2)) / rate_hz)
            motion = lfilter([1.0], [1.0, -2 * pole.real, abs(pole) ** 2], rng.normal(size=6000))
            data += np.outer(motion / motion.std(), shape)
        names = tuple(f'p{row}' for row in rows)
        samples.append(Samples(data, rate_hz, tuple(Channel(name) for name in names)))
        shown = (0, 1) if k in present else (0,)
        modes = tuple(
            estimate(rng, frequency[m], damping[m], shapes[rows, m], 0.01) for m in shown
        )
        setups.append(ModeSet(modes, names))
    return samples, setups, shapes


def test_a_mode_is_read_out_of_set_ups_that_do_not_show_it():
    rng, errors, n_read = np.random.default_rng(SEED + 2), [], 0
    for _ in range(6):
        samples, setups, shapes = roving(rng, 4, present=(0, 1))
        merged = merge_modes(setups, lambda k, own=samples: own[k])
        assert merged.seen_in == ((0, 1, 2, 3), (0, 1)), f'seed {SEED + 2}'
        n_read += len(merged.read_in[1])
        mode, truth = merged.modes.modes[1], shapes[:, 1]
        known = np.isfinite(mode.shape)
        assert mac(mode.shape[known], truth[known]).item() > 0.99, f'seed {SEED + 2}'
        error = mode.shape - truth / truth[np.nanargmax(np.abs(mode.shape))]
        known &= (np.arange(len(known)) >= 6) & (mode.shape_std.real > 0.0)
        errors += list(error.real[known] / mode.shape_std.real[known])
    assert n_read >= 9, f'seed {SEED + 2}: {n_read} of 12'
    assert np.mean(np.abs(errors) < 2.0) > 0.8, f'seed {SEED + 2}: {np.round(errors, 1)}'


def test_a_mode_that_a_set_up_does_not_hold_is_not_read_out_of_it():
    rng = np.random.default_rng(SEED + 3)
    for _ in range(5):
        samples, setups, _ = roving(rng, 3, present=(0, 1))
        noise = rng.normal(size=samples[2].acceleration.shape)
        quiet = {2: replace(samples[2], acceleration=noise)}
        merged = merge_modes(setups, lambda k, quiet=quiet: quiet.get(k))
        assert merged.read_in == ((), ()), f'seed {SEED + 3}'
        assert np.isnan(merged.modes.modes[1].shape[-2:]).all(), f'seed {SEED + 3}'


def test_set_ups_without_modes_and_modes_without_deviations_are_merged_as_far_as_they_go():
    nothing = ModeSet((), ('a', 'c'))
    assert len(merge_modes([nothing, ModeSet((), ('a', 'b'))]).modes) == 0
    one = ModeSet((Mode(5.0, 0.01, np.array([1.0, 0.5 + 0j])),), ('a', 'b'))
    merged = merge_modes([one, nothing])
    mode = merged.modes.modes[0]
    assert merged.seen_in == ((0,),) and np.isnan(mode.shape).tolist() == [False, False, True]
    assert mode.frequency_hz == 5.0 and np.isnan(mode.frequency_std_hz) and mode.shape_std is None


def test_light_modes_whose_damping_nobody_knows_are_merged_by_frequency_and_shape():
    """Damping of a few cycles scatters by its own size, and is stated without deviation."""
    rng = np.random.default_rng(SEED)
    shape = rng.normal(size=REFERENCES)
    setups = []
    for ratio in (0.001, 0.006, 0.0008):
        light = replace(estimate(rng, 5.0, ratio, shape, 0.03), damping_ratio_std=np.nan)
        others = [estimate(rng, hz, 0.02, rng.normal(size=REFERENCES), 0.03) for hz in (3.0, 8.0)]
        modes = (others[0], light, others[1])
        setups.append(ModeSet(modes, tuple(f'p{point}' for point in range(REFERENCES))))
    merged = merge_modes(setups)
    near = [
        seen
        for mode, seen in zip(merged.modes, merged.seen_in, strict=True)
        if abs(mode.frequency_hz - 5.0) < 0.1
    ]
    assert near == [(0, 1, 2)], f'seed {SEED}: {near}'
