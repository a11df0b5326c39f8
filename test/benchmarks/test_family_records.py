"""Records of random families: exact responses, and what they tell at best."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lsim, resample

from benchmarks.families.bound import bound, local_bound
from benchmarks.families.drawing import draw
from benchmarks.families.family import FAMILIES
from benchmarks.families.motion import draw_motion, one_axis
from benchmarks.families.response import in_time, modal_accelerations
from benchmarks.families.structure import coupled, Modal
from benchmarks.identifier.scatter import law

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


@pytest.mark.parametrize('seed', range(6))
def test_the_acceleration_of_a_moving_axis_is_that_of_its_angle(seed):
    angle, acceleration = one_axis(np.random.default_rng(seed), 20_000, 100.0, 0.5)
    differences = np.diff(angle, 2) * 100.0**2
    assert np.abs(differences - acceleration[1:-1]).max() < 0.02 * np.abs(acceleration).max()
    assert np.ptp(angle) > 0.1


def test_motion_is_slower_than_the_lowest_mode():
    """A thousandth of its power lies above, and its level is the one drawn."""
    rng = np.random.default_rng(1)
    motion = draw_motion(rng, (20_000, 5), 100.0, 2.0, (3.0, 3.0))
    assert motion.std(axis=0).mean() == pytest.approx(3.0)
    power = np.abs(np.fft.rfft(motion, axis=0)) ** 2
    hz = np.fft.rfftfreq(20_000, 0.01)
    assert power[hz > 2.0].sum() < 1e-3 * power[1:].sum()


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
