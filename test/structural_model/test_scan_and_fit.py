"""Many poses at once, moving poses, and fits that must find a known truth."""

import dataclasses

import numpy as np
import pytest

from modal_core.channel import Channel
from modal_core.errors import ModelError
from modal_core.units import ANGULAR_VELOCITY
from structural_model import load_robot
from structural_model.description import BaseSpec
from structural_model.equations import random_poses
from structural_model.fitting import FitProblem, FreeParameter, FrequencyFit, PoseTarget

SEED = 60


def test_scan_equals_pose_by_pose(shipped):
    model, layout = shipped
    q = random_poses(model.limits, 12, np.random.default_rng(SEED))
    channels = layout.channels[::9]
    found = model.scan(q, channels, n_modes=9)
    assert found.frequency_hz.shape == (12, 9)
    for number, pose in enumerate(q):
        alone = model.modes(pose, channels)
        np.testing.assert_allclose(found.frequency_hz[number], alone.frequency_hz[:9], rtol=1e-8)
        np.testing.assert_allclose(found.damping_ratio[number], alone.damping_ratio[:9], rtol=1e-6)
        np.testing.assert_allclose(
            np.abs(found.channel_shapes[number]),
            np.abs(alone.channel_shapes[:, :9]),
            atol=1e-5 * np.abs(alone.channel_shapes).max(),
        )


def test_random_poses_repeat_and_stay_inside(shipped):
    model, _ = shipped
    first = random_poses(model.limits, 40, np.random.default_rng(SEED))
    again = random_poses(model.limits, 40, np.random.default_rng(SEED))
    np.testing.assert_array_equal(first, again)
    assert model.limits.position_violation(first) is None


def test_turning_the_first_joint_leaves_the_frequencies_alone(shipped):
    """On a rigid floor with a round first bearing, azimuth is a symmetry of the arm."""
    model, _ = shipped
    model = model.replace(dataclasses.replace(model.spec, base=BaseSpec()))
    q = np.tile(model.pose(next(iter(model.poses_controller_rad))), (5, 1))
    q[:, 0] = np.linspace(-2.0, 2.0, 5)
    found = model.scan(q).frequency_hz
    np.testing.assert_allclose(found, np.tile(found[0], (5, 1)), rtol=1e-7)


def sweep(model, rate, seconds, size):
    """Return q, qd, qdd of a smooth swing of every joint about the first named pose."""
    time = np.arange(round(rate * seconds)) / rate
    start = model.pose(next(iter(model.poses_controller_rad)))
    ramp = 2 * np.pi / seconds
    weight = np.linspace(1.0, 0.4, model.n_joints) * size
    shape = (1 - np.cos(ramp * time)) ** 2
    rate_of = 2 * (1 - np.cos(ramp * time)) * np.sin(ramp * time) * ramp
    rise = (
        2 * ramp**2 * (np.sin(ramp * time) ** 2 + (1 - np.cos(ramp * time)) * np.cos(ramp * time))
    )
    return start + np.outer(shape, weight), np.outer(rate_of, weight), np.outer(rise, weight)


def test_small_trajectory_is_the_linear_time_response(shipped):
    model, layout = shipped
    channels = [
        *layout.channels[5::11],
        Channel('gyro', model.link_names[4], (0, 1, 0), unit=ANGULAR_VELOCITY),
    ]
    q, qd, qdd = sweep(model, 1000.0, 0.5, 1e-5)
    moving = model.trajectory_response((q, qd, qdd), channels, 1000.0)
    linear = model.time_response(q[0], channels, qdd, 1000.0).output
    gap = moving.output - moving.output[0] - (linear - linear[0])
    assert np.abs(gap).max() < 0.02 * np.abs(linear).max()


def test_trajectory_response_does_not_depend_on_its_steps(shipped):
    model, layout = shipped
    channels = layout.channels[-3:]
    motion = sweep(model, 1000.0, 1.0, 0.05)
    fine = model.trajectory_response(motion, channels, 1000.0, pose_step_rad=5e-4).output
    coarse = model.trajectory_response(motion, channels, 1000.0, pose_step_rad=4e-3).output
    rigid = model.rigid_acceleration(*motion, channels)
    flexible = np.abs(fine - rigid).max()
    assert np.abs(coarse - fine).max() < 0.05 * flexible, (SEED, flexible)


def test_trajectory_refuses_unequal_parts():
    model = load_robot('generic_arm_6')
    q = np.zeros((5, 6))
    with pytest.raises(ModelError, match='unequal'):
        model.trajectory_response((q, q[:4], q), [], 1000.0)
    with pytest.raises(ModelError, match='positive'):
        model.trajectory_response((q, q, q), [], 0.0)


def test_fit_finds_the_truth_and_says_what_it_cannot_see():
    truth = load_robot('generic_arm_6')
    names = [f'joints.{joint}.drive.spring.stiffness' for joint in ('a1', 'a2', 'a3')]
    start = truth.with_parameters({name: 1.4 * truth.parameters()[name] for name in names})
    parameters = tuple(
        FreeParameter(name, (name,), truth.parameters()[name] / 3, truth.parameters()[name] * 4)
        for name in names
    )
    blind = 'joints.a6.drive.spring.stiffness'
    value = truth.parameters()[blind]
    parameters += (FreeParameter('blind', (blind,), value / 2, value * 2),)
    targets = tuple(
        PoseTarget(pose, tuple(truth.modes(truth.pose(pose)).frequency_hz[:4]), ((0, 1, 2, 3),))
        for pose in ('home', 'ready')
    )
    problem = FitProblem(parameters, targets, frequency_sd=1e-4, starts=2)
    found = FrequencyFit(start, problem).run(np.random.default_rng(SEED))
    for name in names:
        assert found.values[name] == pytest.approx(truth.parameters()[name], rel=5e-3), SEED
        assert found.determined[name] > 0.95
    assert found.determined['blind'] < 0.2
    assert max(abs(r) for row in found.residual.values() for r in row) < 1e-3


def test_fit_refuses_unknown_and_empty_parameters():
    model = load_robot('generic_arm_6')
    target = (PoseTarget('home', (9.0,), ((0,),)),)
    with pytest.raises(ModelError, match='unknown model parameter'):
        FrequencyFit(model, FitProblem((FreeParameter('x', ('nothing',), 1.0, 2.0),), target))
    with pytest.raises(ModelError, match='empty'):
        FrequencyFit(model, FitProblem((FreeParameter('x', (), 2.0, 1.0),), target))


def test_published_frequencies_are_matched_within_two_percent():
    """The eight of the paper's text, each by an own model mode, rising in order."""
    model = load_robot('irb6660_205_190')
    published = {'P1': (11.1, 19.4, 29.3, 38.1), 'P3': (10.3, 18.0, 42.8, 50.6)}
    for pose, wanted in published.items():
        found = model.modes(model.pose(pose)).frequency_hz
        nearest = [int(np.argmin(np.abs(found - frequency))) for frequency in wanted]
        assert len(set(nearest)) == 4, (pose, found[:9])
        np.testing.assert_allclose(found[nearest], wanted, rtol=0.02)
        assert found[0] > 0.85 * wanted[0]
