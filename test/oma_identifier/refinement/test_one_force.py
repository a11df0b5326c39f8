"""What the force moves itself turns shapes: they are right, or nobody vouches for them."""

from dataclasses import replace

import numpy as np
import pytest

from modal_core.mode import Mode
from oma_identifier.likelihood import accelerance, BandData, BandFit, BandIndex, BandModel
from oma_identifier.refinement.acceptance import differ
from oma_identifier.refinement.adopt import is_alike
from oma_identifier.refinement.direct_motion import in_step, moves_with_force, shares_force
from oma_identifier.refinement.told_apart import repeated


@pytest.mark.parametrize(('direct', 'noticed'), [(0.0, 0), (2.0, 20)])
def test_motion_in_step_with_the_force_is_noticed(direct, noticed):
    """Seeds 0 to 19: one mode, one force that moves the last two of six channels as well."""
    n, found = 40, 0
    frequency = np.linspace(9.0, 11.0, n)
    gain = accelerance(frequency, np.array([10.0]), np.array([0.01]))[:, 0]
    for seed in range(20):
        rng = np.random.default_rng(seed)
        shape = np.linalg.qr(rng.standard_normal((6, 1)))[0][:, 0]
        moved = direct * np.array([0.0, 0.0, 0.0, 0.0, 1.0, -1.0])
        draw = rng.standard_normal((2, n, 8, 7)) / np.sqrt(2.0)
        draw = draw[0] + 1j * draw[1]
        motion = (gain[:, None] * shape + moved)[:, None] * draw[:, :, :1] + 0.3 * draw[:, :, 1:]
        periodogram = np.einsum('kac,kad->kcd', motion, motion.conj()) / 8.0
        data = BandData(frequency, periodogram, np.full(n, 8.0))
        noise = 0.09 + np.abs(moved) ** 2
        model = BandModel(
            np.array([10.0]),
            np.array([0.01]),
            shape[:, None] + 0j,
            np.eye(1) + 0j,
            noise,
            n_free=1,
            reference_hz=10.0,
        )
        found += moves_with_force(data, model, BandIndex(0))
    assert found == noticed


def modes_of(frequency_hz: list[float], force: np.ndarray, n_free: int) -> BandModel:
    """Return modes damped by 1 %, each in a channel of its own, in four with unit noise."""
    n = len(frequency_hz)
    return BandModel(
        np.array(frequency_hz),
        np.full(n, 0.01),
        np.eye(4)[:, :n] + 0j,
        force,
        np.ones(4),
        n_free=n_free,
        reference_hz=10.0,
    )


@pytest.mark.parametrize(('coherence', 'same'), [(0.0, False), (0.7, False), (0.95, True)])
def test_one_force_of_a_mode_and_one_that_was_added_is_noticed(coherence, same):
    power = np.array([2.0, 0.5, 3.0])
    force = np.diag(power).astype(complex)
    cross = np.sqrt(coherence * power[0] * power[2]) * np.exp(0.6j)
    force[0, 2], force[2, 0] = cross, cross.conj()
    model = modes_of([10.0, 11.0, 14.0], force, n_free=3)
    added = [BandIndex(2)]
    assert in_step(model, BandIndex(0), added) is same
    assert not in_step(model, BandIndex(1), added)
    assert not in_step(model, BandIndex(2), added), 'with itself'
    assert not in_step(model, BandIndex(0), [])


@pytest.mark.parametrize(
    ('coherence', 'tail', 'shared'),
    [(0.0, 3.0, False), (0.7, 3.0, False), (0.95, 3.0, True), (0.95, 0.3, False)],
)
def test_one_force_of_a_mode_and_one_that_is_seen_beside_its_band(coherence, tail, shared):
    """A tail of 0.3 deviations of the noise is not seen."""
    frequency = np.linspace(9.0, 11.0, 20)
    data = BandData(frequency, np.zeros((20, 4, 4), dtype=complex), np.ones(20))
    # Far above the tail's own frequency it moves as its force does.
    power = np.array([2.0, tail**2])
    force = np.diag(power).astype(complex)
    force[0, 1] = force[1, 0] = np.sqrt(coherence * power.prod())
    model = modes_of([10.0, 0.1], force, n_free=1)
    assert shares_force(data, model, BandIndex(0)) is shared


@pytest.mark.parametrize(('steps', 'contradicts'), [((0.0, 2.5), False), ((3.5, 0.0), True)])
def test_a_fit_with_fewer_assumptions_contradicts_one_that_is_far_from_it(steps, contradicts):
    """Steps of frequency and damping in deviations of the difference: √(5² - 3²) = 4."""
    model = modes_of([10.0], np.eye(1) + 0j, n_free=1)
    std = np.array([3e-3])
    fit = BandFit(model, std, std, np.zeros((1, 4, 6)) + 0j, 0.1, True, 5, 1.0, 0.0)
    f, zeta = np.exp(4e-3 * np.array(steps))
    moved = replace(
        model, frequency_hz=10.0 * np.array([f]), damping_ratio=0.01 * np.array([zeta])
    )
    std = np.array([5e-3])
    wider = replace(fit, model=moved, frequency_std=std, damping_ratio_std=std)
    assert differ(fit, wider, BandIndex(0)) is contradicts


def mode(frequency_hz: float, ratio: float, shape: np.ndarray, mac_loss: float = np.nan) -> Mode:
    return Mode(frequency_hz, ratio, shape + 0j, frequency_std_hz=ratio, mac_loss=mac_loss)


def test_a_shape_that_turned_far_is_not_vouched_for():
    rng = np.random.default_rng(8)
    shape, across = np.linalg.qr(rng.standard_normal((12, 2)))[0].T
    plain = mode(9.0, 0.01, shape)
    for turn, mac_loss, alike in ((0.1, 1e-4, True), (0.4, 1e-4, False), (0.4, 0.05, True)):
        refined = mode(9.0, 0.01, np.cos(turn) * shape + np.sin(turn) * across, mac_loss)
        assert is_alike(plain, refined) is alike


def test_a_mode_is_reported_once():
    rng = np.random.default_rng(7)
    shape, other = rng.standard_normal((2, 12))
    narrow, wide = mode(15.88, 0.0185, shape), mode(16.31, 0.044, shape + 0.01)
    assert repeated([narrow, wide]) == {1}
    # Another shape, another place, or a likelihood that tells them apart.
    assert repeated([narrow, replace(wide, shape=other + 0j)]) == set()
    assert repeated([narrow, replace(wide, frequency_hz=18.0)]) == set()
    assert repeated([replace(narrow, mac_loss=1e-3), replace(wide, mac_loss=1e-3)]) == set()
    assert repeated([replace(wide, mac_loss=1e-3), narrow]) == {1}
    # Three channels say too little of a shape.
    few = [replace(each, shape=each.shape[:3]) for each in (narrow, wide)]
    assert repeated(few) == set()
