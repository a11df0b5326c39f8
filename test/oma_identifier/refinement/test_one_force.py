"""What the force moves itself turns shapes: they are right, or nobody vouches for them."""

from dataclasses import replace

import numpy as np
import pytest

from modal_core.mode import Mode
from oma_identifier.likelihood import accelerance, BandData, BandIndex, BandModel
from oma_identifier.refinement.adopt import is_alike
from oma_identifier.refinement.direct_motion import in_step, moves_with_force
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
        data = BandData(frequency, periodogram, np.full(n, 8.0), 0.0, 1.0)
        noise = 0.09 + np.abs(moved) ** 2
        model = BandModel(
            np.array([10.0]),
            np.array([0.01]),
            shape[:, None] + 0j,
            np.eye(1) + 0j,
            noise,
            n_free=1,
            one_noise=False,
            reference_hz=10.0,
        )
        found += moves_with_force(data, model, BandIndex(0))
    assert found == noticed


@pytest.mark.parametrize(('coherence', 'same'), [(0.0, False), (0.7, False), (0.95, True)])
def test_one_force_of_a_mode_and_one_that_was_added_is_noticed(coherence, same):
    power = np.array([2.0, 0.5, 3.0])
    force = np.diag(power).astype(complex)
    cross = np.sqrt(coherence * power[0] * power[2]) * np.exp(0.6j)
    force[0, 2], force[2, 0] = cross, cross.conj()
    model = BandModel(
        np.array([10.0, 11.0, 14.0]),
        np.full(3, 0.01),
        np.eye(4)[:, :3] + 0j,
        force,
        np.ones(4),
        n_free=3,
        one_noise=False,
        reference_hz=10.0,
    )
    added = [BandIndex(2)]
    assert in_step(model, BandIndex(0), added) is same
    assert not in_step(model, BandIndex(1), added)
    assert not in_step(model, BandIndex(2), added), 'with itself'
    assert not in_step(model, BandIndex(0), [])


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
