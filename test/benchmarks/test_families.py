"""Random families of structures: exact responses, fair pairing, honest counting."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lsim, resample

from benchmarks.families.bound import bound, local_bound
from benchmarks.families.family import FAMILIES
from benchmarks.families.judge import asked_for, judge
from benchmarks.families.matching import match
from benchmarks.families.record import draw, Record
from benchmarks.families.response import in_time, modal_accelerations
from benchmarks.families.rows import COLUMNS, rows_of
from benchmarks.families.store import Store
from benchmarks.families.structure import coupled, Modal
from benchmarks.families.tally import rate, regressions, Tally
from benchmarks.plant import Plant
from benchmarks.scatter import law
from modal_core.indicators import normalise
from modal_core.mode import Mode

RATE_HZ = 50.0


def structure(rng: np.random.Generator) -> Modal:
    omega = 2.0 * np.pi * np.array([2.0, 5.0, 5.3, 14.0])
    damping = coupled(rng, np.diag(2.0 * np.array([0.02, 0.05, 0.03, 0.08]) * omega), 0.7)
    return Modal(omega, damping, rng.standard_normal((3, 4)), rng.standard_normal((4, 2)))


def integrated(modal: Modal, force: np.ndarray, finer: int) -> np.ndarray:
    """Integrate the equations of second order over three periods of forces; return the last."""
    n = len(modal.omega)
    stiffness = np.diag(modal.omega**2)
    state = np.block([[np.zeros((n, n)), np.eye(n)], [-stiffness, -modal.damping]])
    inputs = np.vstack([np.zeros_like(modal.forces), modal.forces])
    output = modal.shapes @ state[n:]
    fine = np.tile(resample(force, finer * len(force)), (3, 1))
    time = np.arange(len(fine)) / (finer * RATE_HZ)
    system = (state, inputs, output, modal.shapes @ modal.forces)
    return lsim(system, fine, time)[1][-finer * len(force) :: finer]


def test_responses_are_those_of_an_integration_in_small_steps():
    rng = np.random.default_rng(5)
    modal = structure(rng)
    force = rng.standard_normal((1501, 2))
    plant = modal.plant()
    found = sum(
        2.0 * np.real(np.outer(in_time(each, 1501), plant.shapes[:, mode]))
        for mode, each in enumerate(modal_accelerations(plant, force, RATE_HZ, 0.5))
    )
    truth = integrated(modal, force, 40)
    assert np.abs(found - truth).max() < 2e-3 * np.abs(truth).max()


def test_a_drifting_response_is_the_same_in_its_own_time():
    """A mode whose time runs evenly does not drift; one that runs faster is read off later."""
    rng = np.random.default_rng(6)
    plant = structure(rng).plant()
    force = rng.standard_normal((2000, 2))
    spectrum = next(modal_accelerations(plant, force, RATE_HZ, 0.45))
    still = in_time(spectrum, 1000)
    assert np.allclose(in_time(spectrum, 1000, np.arange(1000.0)), still, atol=1e-5)
    fast = in_time(spectrum, 1000, 2.0 * np.arange(499.0))
    assert np.allclose(fast, still[:998:2], atol=1e-5)


@pytest.mark.parametrize('name', FAMILIES)
def test_a_record_is_determined_by_family_and_seed(name):
    family = replace(FAMILIES[name], duration_s=(15.0, 20.0))
    first, again = (draw(family, 7) for _ in range(2))
    assert np.array_equal(first.acceleration, again.acceleration)
    assert not np.array_equal(first.acceleration[:9], draw(family, 8).acceleration[:9])
    assert np.isfinite(first.acceleration).all()
    n_samples, n_channels = first.acceleration.shape
    assert family.n_channels[0] <= n_channels <= family.n_channels[1]
    assert family.n_modes[0] <= len(first.share) <= family.n_modes[1]
    assert family.n_lines[0] <= len(first.lines_hz) <= family.n_lines[1]
    assert n_samples * n_channels <= 2_500_000


def test_the_response_of_a_record_peaks_at_its_modes():
    """Welch's spectrum of a light structure has 90 % of its power where the modes are."""
    record = draw(FAMILIES['light'], 1)
    power = np.abs(np.fft.rfft(record.acceleration, axis=0)) ** 2
    hz = np.fft.rfftfreq(len(record.acceleration), 1.0 / record.rate_hz)
    plant = record.plant
    width = np.maximum(3.0 * plant.damping_ratio * plant.frequency_hz, 2.0 / record.duration_s)
    near = (np.abs(hz[:, None] - plant.frequency_hz) < width).any(axis=1)
    share = (power[near].sum(axis=0) / power.sum(axis=0)).mean()
    assert abs(share - record.share.sum()) < 0.1
    assert share > 0.7


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
    assert verdict.asked == verdict.found == [0, 0, 2] or verdict.asked == verdict.found
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


def test_only_what_is_worse_beyond_chance_is_a_regression():
    before = {'runs': 60, 'asked': 600, 'missed': 6, 'false': 6}
    now = {'runs': 12, 'asked': 120, 'missed': 3, 'false': 3}
    assert regressions(now, before) == []
    assert len(regressions({**now, 'missed': 12, 'false': 9}, before)) == 2


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
    assert tally.counts()['missed'] == 1
    assert tally.inside(0).value == 1.0
    assert tally.found_more(Tally(tally.verdicts[::-1])).value == 0.0
    rows = rows_of(FAMILIES['plain'], {'ours': tally, 'other': Tally(tally.verdicts[1:])})
    assert [len(row) for row in rows] == [len(COLUMNS)] * 2
    assert [row[1] for row in rows] == ['ours', 'other']


def test_the_bound_of_a_mode_alone_is_the_law():
    """And more than that for a weak mode far below the noise."""
    rng = np.random.default_rng(2)
    omega = 2.0 * np.pi * np.array([4.0, 13.0])
    shapes = rng.standard_normal((3, 2))
    plant = Modal(omega, np.diag(0.02 * omega), shapes, np.diag([3.0, 0.1])).plant()
    found = bound(plant, np.full(3, 1e-3), 50.0, 600.0) / law(plant, 600.0)
    assert np.allclose(found, 1.0, atol=0.05)
    noisy = bound(plant, np.full(3, 10.0), 50.0, 600.0) / law(plant, 600.0)
    assert (noisy[:, 1] > 2.0).all()
    assert (noisy[:, 0] < noisy[:, 1]).all()


def test_what_the_bound_is_at_least_is_near_it_and_not_above():
    """Two pairs and a mode alone in four channels, three forces, noise above the response."""
    rng = np.random.default_rng(9)
    omega = 2.0 * np.pi * np.array([3.0, 3.05, 7.0, 12.0, 12.3])
    shapes, forces = rng.standard_normal((4, 5)), rng.standard_normal((5, 2))
    plant = Modal(omega, np.diag(0.04 * omega), shapes, forces).plant()
    noise = rng.uniform(2.0, 8.0, 4)
    exact, least = (each(plant, noise, 50.0, 300.0) for each in (bound, local_bound))
    assert (exact / law(plant, 300.0) > 1.5).any()
    assert (least < 1.1 * exact).all()
    assert (least > 0.6 * exact).all()


def test_one_channel_tells_close_modes_worse_than_three():
    rng = np.random.default_rng(4)
    omega = 2.0 * np.pi * np.array([9.0, 9.1])
    shapes, forces = rng.standard_normal((3, 2)), rng.standard_normal((2, 2))
    one, three = (
        bound(
            Modal(omega, np.diag(0.02 * omega), shapes[:n], forces).plant(),
            np.full(n, 1e-3),
            40.0,
            300.0,
        )
        for n in (1, 3)
    )
    assert (one > 2.0 * three).all()


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
