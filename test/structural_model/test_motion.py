"""Rigid motion, torques, points and drawing against pinocchio on the plain URDF."""

import numpy as np
import pinocchio as pin
import pytest

from modal_core.channel import Channel
from modal_core.units import ANGULAR_VELOCITY
from structural_model import load_robot

SEED = 40


@pytest.fixture
def motion(shipped):
    model, _ = shipped
    rng = np.random.default_rng(SEED)
    q, qd, qdd = rng.normal(size=(3, 7, model.n_joints)) * np.array([0.4, 1.0, 5.0])[:, None, None]
    return q, qd, qdd


def test_readings_of_the_rigid_arm(shipped, motion):
    model, layout = shipped
    gyros = [
        Channel(f'{c.name}.gyro', c.frame_id, c.direction, c.position_m, ANGULAR_VELOCITY)
        for c in layout.channels[::7]
    ]
    channels = [*layout.channels[::2], *gyros]
    found = model.rigid_acceleration(*motion, channels)
    rigid = model.robot.model
    data = rigid.createData()
    local = pin.ReferenceFrame.LOCAL
    for row, q, qd, qdd in zip(found, *motion, strict=True):
        pin.forwardKinematics(rigid, data, q, qd, qdd)
        pin.updateFramePlacements(rigid, data)
        for value, channel in zip(row, channels, strict=True):
            frame = rigid.frames[rigid.getFrameId(channel.frame_id)]
            place = frame.placement * pin.SE3(np.eye(3), np.array(channel.position_m))
            joint = frame.parentJoint
            turn = (data.oMi[joint] * place).rotation
            if channel.unit == ANGULAR_VELOCITY:
                spin = pin.getFrameVelocity(rigid, data, joint, place, local).angular
                expected = spin @ np.array(channel.direction)
            else:
                acceleration = pin.getFrameClassicalAcceleration(rigid, data, joint, place, local)
                expected = (acceleration.linear + turn.T @ [0, 0, 9.81]) @ channel.direction
            assert value == pytest.approx(expected, abs=1e-9), (SEED, channel)


def test_resting_sensor_reads_gravity_upwards():
    model = load_robot('generic_arm_6')
    zero = np.zeros(6)
    up = Channel('up', 'base_link', (0.0, 0.0, 1.0))
    assert model.rigid_acceleration(zero, zero, zero, [up])[0] == pytest.approx(9.81)


def test_torque_against_pinocchio_on_the_urdf_alone(arms):
    """No payload, no rotor: the expanded model's torque is that of the plain URDF."""
    import dataclasses

    model = load_robot('irb6660_205_190')
    joints = tuple(
        dataclasses.replace(j, drive=dataclasses.replace(j.drive, rotor_inertia_kg_m2=0.0))
        for j in model.spec.joints
    )
    bare = model.replace(dataclasses.replace(model.spec, joints=joints, masses=(), links=()))
    rng = np.random.default_rng(SEED + 1)
    q, qd, qdd = rng.normal(size=(3, 5, 6))
    rigid = bare.robot.model
    expected = [pin.rnea(rigid, rigid.createData(), *row) for row in zip(q, qd, qdd, strict=True)]
    np.testing.assert_allclose(bare.torque(q, qd, qdd), expected, rtol=1e-9, atol=1e-6)


def test_rotors_add_their_inertia_on_the_controller_axes():
    model = load_robot('irb6660_205_190')
    zero = np.zeros(6)
    q = model.pose('P1')
    qdd = model.to_serial(np.array([0.0, 0.0, 1.0, 0.0, 0.0, 0.0]))
    drive = model.spec.joints[2].drive
    name = 'joints.joint_3.drive.rotor_inertia_kg_m2'
    without = model.with_parameters({name: 0.0})
    added = model.drive_torque(q, zero, qdd) - without.drive_torque(q, zero, qdd)
    expected = np.zeros(6)
    expected[2] = drive.gear_ratio**2 * drive.rotor_inertia_kg_m2
    np.testing.assert_allclose(added, expected, atol=1e-9)


def test_force_of_the_rigid_motion_and_its_input_matrix(shipped, motion):
    """At rest the inertia part is linear in the acceleration: input_matrix times it."""
    model, _ = shipped
    q, _, qdd = motion
    zero = np.zeros_like(q)
    gap = model.rigid_force(q, zero, qdd) - model.rigid_force(q, zero, zero)
    for row, pose, rise in zip(gap, q, qdd, strict=True):
        np.testing.assert_allclose(row, model.input_matrix(pose) @ rise, rtol=1e-7, atol=1e-6)


def test_jacobians_against_finite_differences(shipped, motion):
    """Deflect the expanded model and look where the sensors go."""
    model, layout = shipped
    q = motion[0][0]
    channels = layout.channels[::4]
    assembly = model.assembly
    step = 1e-6

    def placed(deflection):
        data = assembly.model.createData()
        pin.forwardKinematics(assembly.model, data, model.dynamics.position(q, deflection))
        frames = []
        for channel in channels:
            joint, placement = assembly.attach(channel.frame_id, np.array(channel.position_m))
            frames.append(data.oMi[joint] * placement)
        return frames

    jacobian = model.sensor_jacobian(q, channels)
    tilt = model.gravity_jacobian(q, channels)
    rest = placed(np.zeros(model.n_dof))
    up = np.array([0.0, 0.0, 9.81])
    for dof in range(model.n_dof):
        moved = placed(step * np.eye(model.n_dof)[dof])
        for number, channel in enumerate(channels):
            direction = np.array(channel.direction)
            shift = rest[number].rotation.T @ (
                moved[number].translation - rest[number].translation
            )
            assert shift @ direction / step == pytest.approx(jacobian[number, dof], abs=1e-5)
            turn = (moved[number].rotation - rest[number].rotation).T @ up
            assert turn @ direction / step == pytest.approx(tilt[number, dof], abs=1e-4)


def test_fastest_point_bounds_every_point(shipped, motion):
    model, _ = shipped
    q, qd, _ = motion
    bound = model.geometry.fastest_point(q, qd).speed_m_s
    capsules = model.geometry.capsules(q[0])
    step = 1e-6
    moved = model.geometry.capsules(q[0] + step * qd[0])
    for start, end in ((capsules.start, moved.start), (capsules.end, moved.end)):
        speed = np.linalg.norm(end - start, axis=1) / step
        assert speed.max() <= bound[0] * (1 + 1e-4)
    assert bound[0] > 0.0


def test_points_and_extent(shipped, motion):
    model, _ = shipped
    q = motion[0]
    skeleton = model.frame_positions(q)
    assert skeleton.shape == (7, len(model.link_names), 3)
    rigid = model.robot.model
    data = rigid.createData()
    pin.framesForwardKinematics(rigid, data, q[0])
    tool = data.oMf[rigid.getFrameId(model.link_names[-1])].translation
    np.testing.assert_allclose(skeleton[0, -1], tool, atol=1e-12)
    low, high = model.geometry.extent(q)
    assert (skeleton.min(axis=(0, 1)) >= low - 0.3).all() and (low < high).all()


def test_mode_deflects_the_skeleton_as_the_jacobian_says(shipped, motion):
    model, _ = shipped
    q = motion[0][1]
    shape = model.modes(q).shapes[:, 0]
    scale = 1e-3
    local = model.sensor_jacobian(q, model.geometry.skeleton_channels) @ (scale * shape)
    moved = model.geometry.to_base(q, local.reshape(-1, 3))
    assembly = model.assembly
    data = assembly.model.createData()
    pin.forwardKinematics(assembly.model, data, model.dynamics.position(q, 1e-3 * scale * shape))
    joint, placement = assembly.attach(model.link_names[-1], np.zeros(3))
    end = (data.oMi[joint] * placement).translation
    np.testing.assert_allclose(
        1e3 * (end - model.frame_positions(q)[-1]), moved[-1], atol=2e-4 * np.abs(moved).max()
    )


def test_self_collision_is_seen():
    model = load_robot('irb6660_205_190')
    free = model.geometry.clearance(model.pose('P2'))
    assert free.distance_m > 0.02
    folded = model.geometry.clearance(np.array([0.0, 0.5, 2.6, 0.0, 0.0, 0.0]))
    assert folded.distance_m < 0.0
    both = model.geometry.clearance([model.pose('P2'), [0.0, 0.5, 2.6, 0.0, 0.0, 0.0]])
    assert both.sample == 1 and both.distance_m == pytest.approx(folded.distance_m)
