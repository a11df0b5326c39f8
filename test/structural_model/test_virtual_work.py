"""Torques of forces at the end-effector, against weights, levers and finite motions."""

import numpy as np
import pytest

from modal_core.errors import ModelError
from structural_model import load_robot
from structural_model.virtual_work import end_effector_jacobian, joint_torque

SEED = 4
TOOL = (0.12, -0.03, 0.05)


def poses(model, n_poses=6):
    """Named poses, and some anywhere."""
    anywhere = np.random.default_rng(SEED).uniform(-2.0, 2.0, (n_poses, model.n_joints))
    return [*map(model.pose, model.poses_controller_rad), *anywhere]


@pytest.mark.parametrize('robot', ['irb6660_205_190', 'generic_arm_6'])
def test_a_payload_costs_the_torque_of_its_weight(robot):
    """Against inverse dynamics of the arm with and without 20 kg at the tool."""
    model = load_robot(robot)
    name = model.spec.masses[0].name
    place = model.spec.masses[0].position_m
    mass_kg = model.parameters()[f'masses.{name}.mass_kg']
    heavier = model.with_parameters({f'masses.{name}.mass_kg': mass_kg + 20.0})
    weight = 20.0 * np.array([*model.spec.gravity_m_s2, 0.0, 0.0, 0.0])
    for q in poses(model):
        still = np.zeros_like(q)
        more = heavier.torque(q, still, still) - model.torque(q, still, still)
        jacobian = end_effector_jacobian(model, q, model.spec.masses[0].link, place)
        # The joints hold what the weight pulls down.
        assert more == pytest.approx(-joint_torque(jacobian, weight), abs=1e-9), f'seed {SEED}'


def test_a_torque_is_the_moment_of_the_force_about_the_axis():
    """Levers, from places and axes alone; the rod's drive takes part for two joints."""
    model = load_robot('irb6660_205_190')
    rng = np.random.default_rng(SEED)
    for q in poses(model):
        force, moment = rng.normal(size=(2, 3))
        motion = model.kinematics.motion(q)
        point = model.geometry.positions([q], [('flange', np.array(TOOL))])[0, 0]
        levers = point - motion.position[0, 1:]
        axes = [
            turned @ joint.axis
            for turned, joint in zip(motion.rotation[0, 1:], model.robot.joints, strict=True)
        ]
        expected = np.sum(axes * (np.cross(levers, force) + moment), axis=1)
        jacobian = end_effector_jacobian(model, q, 'flange', TOOL)
        torque = joint_torque(jacobian, np.concatenate([force, moment]))
        assert torque == pytest.approx(expected, abs=1e-12), f'seed {SEED}'
        drives = model.axes.torque_to_controller(torque)
        assert drives[1] == pytest.approx(expected[1] - expected[2]), f'seed {SEED}'


def test_joints_and_end_effector_do_the_same_work():
    """Eqs. (12)-(14) for motions of finite size: the point's, by forward kinematics."""
    model = load_robot('irb6660_205_190')
    rng = np.random.default_rng(SEED)
    for q in poses(model):
        forces = np.zeros((4, 6))
        forces[:, :3] = rng.normal(size=(4, 3))
        step = 1e-5 * rng.normal(size=q.shape)
        tool = [('flange', np.array(TOOL))]
        before, after = model.geometry.positions([q - step, q + step], tool)
        torque = joint_torque(end_effector_jacobian(model, q, 'flange', TOOL), forces)
        work = forces[:, :3] @ (after - before)[0]
        assert torque @ (2.0 * step) == pytest.approx(work, rel=1e-6, abs=1e-12), f'seed {SEED}'


def test_what_does_not_fit_is_said():
    model = load_robot('irb6660_205_190')
    q = model.pose('P1')
    with pytest.raises(ModelError, match='unknown link'):
        end_effector_jacobian(model, q, 'hand')
    with pytest.raises(ModelError):
        end_effector_jacobian(model, q[:5], 'flange')
    with pytest.raises(ModelError, match='forces do not fit'):
        joint_torque(end_effector_jacobian(model, q, 'flange'), np.ones(3))
