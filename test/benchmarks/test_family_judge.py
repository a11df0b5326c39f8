"""The judge of random families: fair pairing, honest counting."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.families.family import FAMILIES
from benchmarks.families.judge import asked_for, judge
from benchmarks.families.kept_records import keep, worse_than_kept, wrong_in
from benchmarks.families.matching import match
from benchmarks.families.record import Record
from benchmarks.families.rows import COLUMNS, rows_of
from benchmarks.families.store import Store
from benchmarks.families.tally import rate, Tally
from benchmarks.identifier.plant import Plant
from modal_core.mode import Mode
from modal_core.numbers.indicators import normalise

RATE_HZ = 50.0


def record_of(hz: list[float], zeta: float = 0.01, duration_s: float = 100.0) -> Record:
    """Return a record of modes alike in strength, without its samples."""
    rng = np.random.default_rng(3)
    n = len(hz)
    plant = Plant(np.array(hz), np.full(n, zeta), rng.standard_normal((5, n)) + 0j, np.eye(n) + 0j)
    return Record(
        family='plain',
        seed=1,
        plant=plant,
        acceleration=np.zeros((int(duration_s * 50.0), 5)),
        rate_hz=50.0,
        share=np.full(n, 0.5),
        lines_hz=(),
        drift=0.0,
        noise=0.0,
        noise_std=np.full(5, 1e-6),
        n_forces=1,
        forces='any',
        gain=np.ones(n),
        steady=1.0,
    )


def truth(record: Record, deviations: float = 0.0) -> list[Mode]:
    """Return the true modes, off by deviations of what is said of them."""
    plant = record.plant
    modes = []
    for hz, zeta, shape in zip(
        plant.frequency_hz, plant.damping_ratio, plant.shapes.T, strict=True
    ):
        std = 1e-4 * np.ones(5) * (1 + 1j)
        modes.append(
            Mode(
                hz * (1.0 + 1e-3 * deviations),
                zeta * (1.0 + 1e-2 * deviations),
                normalise(shape),
                frequency_std_hz=1e-3 * hz,
                damping_ratio_std=1e-2 * zeta,
                shape_std=std,
                mac_loss=1e-4,
                mac_loss_std=1e-4,
            )
        )
    return modes


def test_the_truth_is_found_and_inside():
    record = record_of([2.0, 5.0, 9.0])
    verdict = judge(truth(record, 1.9), (), record)
    assert verdict.asked == verdict.found
    assert sum(verdict.found) == 3
    assert verdict.n_false == verdict.n_sure_and_wrong == 0
    assert verdict.inside == [[True, True]] * 3
    assert all(held == n for held, n in verdict.shapes)
    assert judge(truth(record, 2.1), (), record).inside == [[False, False]] * 3


def test_what_is_missing_made_up_or_taken_for_a_line_is_counted():
    record = record_of([2.0, 5.0, 9.0])
    modes = truth(record)
    extra = replace(modes[0], frequency_hz=7.0)
    verdict = judge([modes[0], extra], [replace(modes[2], harmonic=True)], record)
    assert sum(verdict.found) == 1
    assert verdict.n_false == 1
    assert sum(verdict.modes_as_lines) == 1
    assert verdict.n_false_lines == 1
    twice = judge([*modes, modes[1]], (), record)
    assert sum(twice.found) == 3
    assert twice.n_false == 1


def test_a_line_reported_as_a_mode_is_no_mode():
    record = replace(record_of([2.0, 5.0]), lines_hz=(8.0,))
    modes = truth(record)
    line = replace(modes[0], frequency_hz=8.001)
    verdict = judge([*modes, line], (), record)
    assert (verdict.n_lines_as_modes, verdict.n_false) == (1, 0)
    assert judge(modes, [line], record).n_false_lines == 0


def test_another_pole_or_another_shape_is_another_mode():
    record = record_of([2.0, 5.0])
    modes = truth(record)
    other = np.random.default_rng(1).standard_normal(5) + 0j
    for wrong in (
        replace(modes[0], damping_ratio=0.12),
        replace(modes[0], shape=other - modes[0].shape * (modes[0].shape.conj() @ other)),
        replace(modes[0], frequency_hz=2.2),
    ):
        assert match([wrong], record).true_of[0] == -1


def test_close_modes_are_paired_by_their_shapes():
    record = record_of([5.0, 5.05], duration_s=1000.0)
    first, second = truth(record)
    swapped = [replace(first, frequency_hz=5.03), replace(second, frequency_hz=5.02)]
    assert list(match(swapped, record).true_of) == [0, 1]


def test_what_no_record_tells_apart_counts_once():
    """Two modes nearer than a line of the record: one found is enough, two are not false."""
    record = record_of([5.0, 5.002])
    modes = truth(record)
    assert not match(modes, record).alone.any()
    for found in (modes, modes[:1]):
        verdict = judge(found, (), record)
        assert (sum(verdict.asked), sum(verdict.found), verdict.n_false) == (1, 1, 0)
        assert not verdict.inside
    mixed = normalise(modes[0].shape + 1.5 * modes[1].shape)
    assert judge([replace(modes[0], shape=mixed)], (), record).n_false == 0
    assert match(modes, record_of([5.0, 5.4])).alone.all()


def test_a_shape_that_is_wrong_and_sure_is_named():
    record = record_of([2.0, 5.0])
    mode, other = truth(record)
    mixed = replace(mode, shape=mode.shape + 0.7 * other.shape)
    verdict = judge([mixed, other], (), record)
    assert verdict.n_sure_and_wrong == 1
    assert any('wrong and sure' in note for note in verdict.notes)


def test_only_modes_in_the_band_that_carry_the_response_are_asked_for():
    record = replace(record_of([0.1, 2.0, 5.0, 22.0]), share=np.array([0.5, 0.5, 0.005, 0.5]))
    assert list(asked_for(record)) == [False, True, False, False]


def test_standard_errors_are_those_of_many_series():
    """Records with as many modes, each found or not with chances of its own."""
    rng = np.random.default_rng(11)
    values, errors = [], []
    for _ in range(300):
        n = rng.integers(1, 10, 40)
        found = rng.binomial(n, rng.beta(4.0, 1.0, 40))
        each = rate(found, n)
        values.append(each.value)
        errors.append(each.error)
    assert np.mean(errors) == pytest.approx(np.std(values), rel=0.15)


def test_records_are_held_against_themselves(tmp_path):
    """Rounding makes some better and some worse; ten worse and none better are no chance."""
    kept = tmp_path / 'kept.json'
    before = {'light': {str(seed): 1 for seed in range(20)}}
    keep(before, kept)
    mixed = {str(seed): 1 + (seed % 4 == 0) - (seed % 4 == 2) for seed in range(20)}
    harm = {str(seed): 1 + (seed < 10) for seed in range(20)}
    new = {str(seed): 9 for seed in range(20, 40)}
    assert worse_than_kept({'light': {**mixed, **new}}, kept) == ''
    said = worse_than_kept({'light': harm, 'other': new}, kept)
    assert said.startswith('of 20 records 10 changed, worse are light 0, light 1')


def test_a_row_of_the_table_tells_what_was_counted():
    record = record_of([2.0, 5.0, 9.0])
    tally = Tally(
        [
            judge(truth(record, 1.0), (), record),
            judge(truth(record)[:2], (), replace(record, seed=2)),
        ]
    )
    assert tally.recall(2).value == pytest.approx(
        1.0 - 1.0 / sum(v.asked[2] for v in tally.verdicts)
    )
    assert wrong_in(tally.verdicts)['plain'] == {'1': 0, '2': 1}
    assert tally.inside(0).value == 1.0
    assert tally.found_more(Tally(tally.verdicts[::-1])).value == 0.0
    rows = rows_of(FAMILIES['plain'], {'ours': tally, 'other': Tally(tally.verdicts[1:])})
    assert [len(row) for row in rows] == [len(COLUMNS)] * 2
    assert [row[1] for row in rows] == ['ours', 'other']
    # Six values inside are no sign of deviations that are too large.
    assert rows[0][-1] == 'nothing'


def test_verdicts_on_the_peer_are_kept_until_a_program_changes(tmp_path, monkeypatch):
    record = record_of([2.0, 5.0])
    verdict = judge(truth(record), (), record)
    path = tmp_path / 'peer.jsonl'
    Store(path).keep([('other', verdict)])
    # NaN stands where there is no bound.
    assert repr(Store(path).known('plain', 1)) == repr({'other': verdict})
    assert Store(path).known('plain', 2) == {}
    monkeypatch.setattr('benchmarks.families.store.definition', lambda _: 'changed')
    assert Store(path).known('plain', 1) == {}
