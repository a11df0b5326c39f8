"""Modes of a record beside the means of its windows."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.families.drawing import draw
from benchmarks.families.family import FAMILIES
from benchmarks.families.ours import ours
from modal_core.mode import Mode, ModeSet
from oma_identifier.record.window_means import WindowMeans
from oma_identifier.record.with_means import with_means, without_mixtures
from oma_identifier.selection import Identified, no_poles

SEED, N_CHANNELS, N_WINDOWS = 15, 12, 12
NAMES = tuple(f'ch{i + 1}' for i in range(N_CHANNELS))


def mode(hz, ratio, shape, mode_id=0):
    return Mode(
        frequency_hz=hz,
        damping_ratio=ratio,
        shape=np.asarray(shape / np.abs(shape).max(), dtype=complex),
        frequency_std_hz=2e-3,
        damping_ratio_std=1e-3,
        id=mode_id,
    )


def mean_of(hz, ratio, shapes):
    """Return the mean of windows that list one mode at these frequencies."""
    means = WindowMeans()
    for each_hz, shape in zip(hz, shapes, strict=True):
        means.add(ModeSet((mode(each_hz, ratio, shape, 7),), NAMES), 1.0)
    (mean,) = means.means()
    assert mean.varies
    return mean


@pytest.fixture
def shapes():
    return np.linalg.qr(np.random.default_rng(SEED).standard_normal((N_CHANNELS, 3)))[0]


def test_windows_that_list_one_of_two_overlapping_modes_in_turn_make_no_third(shapes):
    record = ModeSet((mode(1.35, 0.05, shapes[:, 0]), mode(1.40, 0.05, shapes[:, 1])), NAMES)
    mixed = shapes[:, 0] + shapes[:, 1]
    turns = mean_of(np.tile([1.36, 1.39], N_WINDOWS // 2), 0.05, [mixed] * N_WINDOWS)
    assert not any(turns.is_image(each) for each in record)
    assert without_mixtures([turns], record) == []


@pytest.mark.parametrize('hz', [1.38, 2.2])
def test_windows_that_show_a_drifting_mode_of_its_own_do(shapes, hz):
    """Within the bells of two others, whose shapes are not its own, or beside them."""
    record = ModeSet((mode(1.35, 0.05, shapes[:, 0]), mode(1.40, 0.05, shapes[:, 1])), NAMES)
    path_hz = hz * np.linspace(0.99, 1.01, N_WINDOWS)
    drifting = mean_of(path_hz, 0.001, [shapes[:, 2]] * N_WINDOWS)
    assert without_mixtures([drifting], record) == [drifting]


def test_crowded_modes_that_hold_still_are_not_said_to_vary():
    """The record as one lists them; with a mixture of two there is a false one that varies."""
    verdict = ours(draw(FAMILIES['heavy'], 310018))
    assert verdict.n_false == 0, verdict.notes
    assert not any('modes_vary' in note for note in verdict.notes), verdict.notes


def test_windows_too_short_for_a_sharp_mode_beside_a_broad_one_do_not_move_it(shapes):
    """A mode that moved by 1 % would be that broad in the record as one."""
    sharp = mode(1.1284, 5e-5, shapes[:, 0])
    record = ModeSet((sharp, mode(1.10, 0.04, shapes[:, 1])), NAMES)
    smeared = mean_of(np.tile([1.116, 1.14], N_WINDOWS // 2), 0.042, [shapes[:, 0]] * N_WINDOWS)
    assert smeared.is_image(sharp)
    assert without_mixtures([smeared], record) == []


def test_windows_that_take_one_of_two_broad_modes_for_the_other_do_not_move_it(shapes):
    """What moves by 0.65 % and has 1.2 % of damping has a bell of 1.7 % in the record as one."""
    record = mode(3.02, 0.0213, shapes[:, 0])
    hz = 3.02 * np.linspace(0.989, 1.011, N_WINDOWS)
    mixed = mean_of(hz, 0.0124, [shapes[:, 0]] * N_WINDOWS)
    assert mixed.is_image(record)
    assert without_mixtures([mixed], ModeSet((record,), NAMES)) == []
    unsure = replace(record, damping_ratio_std=2.5e-3)
    assert without_mixtures([mixed], ModeSet((unsure,), NAMES)) == [mixed]


def test_a_mode_whose_track_breaks_in_two_stands_once(shapes):
    modes = ModeSet((mode(4.0, 0.02, shapes[:, 0]),), NAMES)
    record = Identified(modes, ModeSet((), NAMES), no_poles(N_CHANNELS))
    early = mean_of(4.0 * np.linspace(0.98, 1.0, N_WINDOWS), 0.015, [shapes[:, 0]] * N_WINDOWS)
    late = mean_of(4.0 * np.linspace(1.0, 1.01, N_WINDOWS), 0.015, [shapes[:, 0]] * N_WINDOWS)
    for means in ([early, late], [late, early]):
        (only,) = with_means(record, means).modes
        assert only.frequency_std_hz == pytest.approx(4.0 * early.between, rel=0.1)


def test_windows_that_smear_a_drifting_mode_do_not_tell_its_damping(shapes):
    record = mode(4.0, 0.002, shapes[:, 0])
    wide = mean_of(4.0 * np.linspace(0.99, 1.01, N_WINDOWS), 0.007, [shapes[:, 0]] * N_WINDOWS)
    widened = wide.widen(record, ModeSet((record,), NAMES))
    assert widened.damping_ratio == record.damping_ratio
    assert np.isnan(widened.damping_ratio_std)
    assert widened.frequency_std_hz > 0.01


def test_windows_that_mix_a_drifting_mode_with_its_neighbour_do_not_tell_its_damping(shapes):
    record = mode(4.0, 0.012, shapes[:, 0])
    drifts = mean_of(4.0 * np.linspace(0.99, 1.01, N_WINDOWS), 0.01, [shapes[:, 0]] * N_WINDOWS)
    alone = drifts.widen(record, ModeSet((record,), NAMES))
    assert alone.damping_ratio == pytest.approx(0.01)
    assert alone.damping_ratio_std > 0.0
    beside = mode(4.05, 0.005, shapes[:, 1])
    mixed = drifts.widen(record, ModeSet((record, beside), NAMES))
    assert mixed.damping_ratio == pytest.approx(0.01)
    assert np.isnan(mixed.damping_ratio_std)


def test_windows_that_show_a_mode_a_little_broader_by_chance_leave_its_damping(shapes):
    record = mode(4.0, 0.012, shapes[:, 0])
    wide = mean_of(4.0 * np.linspace(0.99, 1.01, N_WINDOWS), 0.0121, [shapes[:, 0]] * N_WINDOWS)
    widened = wide.widen(record, ModeSet((record,), NAMES))
    assert widened.damping_ratio == record.damping_ratio
    assert widened.damping_ratio_std == record.damping_ratio_std


def test_a_sharp_mode_beside_a_broad_one_keeps_the_damping_of_the_record():
    """Its windows had 4.2 ± 0.6 % for 0.04 %."""
    verdict = ours(draw(FAMILIES['complex'], 884001))
    assert verdict.n_false == 0, verdict.notes
    assert not any('modes_vary' in note for note in verdict.notes), verdict.notes
