"""Accepted means: every limit holds on a ten times finer grid, seen by other means."""

from dataclasses import replace

from hypothesis import given, HealthCheck, settings
from hypothesis import strategies as st
import numpy as np
import pinocchio as pin
import pytest

from excitation_planner.bounds.limits import check_limits, PlanLimits
from excitation_planner.bounds.self_collision import proven_clearance
from excitation_planner.drawing.drawing import draw_motion
from excitation_planner.motion.trajectory import Trajectory
from excitation_planner.planner import plan_limits
from excitation_planner.request import PlanRequest
from excitation_planner.setting import bring_together
from modal_core.errors import PlanError
from structural_model import load_robot

ROBOTS = {name: load_robot(name) for name in ('irb6660_205_190', 'generic_arm_6')}
FINER = 10
# Numerical differentiation and other people's kinematics agree to this part of a limit.
SLACK = 1.001


def independent_motion(trajectory: Trajectory):
    """Evaluate a trajectory without its own splines: shifted grid, de Boor from scratch."""
    from scipy.interpolate import make_interp_spline

    spline = make_interp_spline(
        trajectory.time_s,
        trajectory.velocity,
        k=3,
        bc_type=([(1, np.zeros(6))], [(1, np.zeros(6))]),
    )
    # A grid that does not contain the one the check uses.
    n_fine = (trajectory.n_samples - 1) * FINER + 4
    time_s = np.linspace(0.0, trajectory.duration_s, n_fine)
    position = trajectory.position[0] + spline.antiderivative()(time_s)
    return position, spline(time_s), spline.derivative(1)(time_s), spline.derivative(2)(time_s)


def point_speeds(model, position, velocity):
    """Speed of points on the surface of every shape, by pinocchio's frame Jacobians."""
    rigid, data = model.robot.model, model.robot.model.createData()
    fastest = 0.0
    for q, qd in zip(position, velocity, strict=True):
        pin.forwardKinematics(rigid, data, q, qd)
        pin.updateFramePlacements(rigid, data)
        for shape in model.robot.shapes:
            frame = rigid.getFrameId(shape.link)
            twist = pin.getFrameVelocity(rigid, data, frame, pin.ReferenceFrame.LOCAL)
            for end in (-0.5, 0.5):
                tip = shape.position + shape.rotation @ np.array([0.0, 0.0, end * shape.length])
                for side in np.vstack([np.eye(3), -np.eye(3)]):
                    point = tip + shape.radius * side
                    speed = np.linalg.norm(twist.linear + np.cross(twist.angular, point))
                    fastest = max(fastest, float(speed))
    return fastest


def assert_all_limits_hold(model, trajectory, limits: PlanLimits, seed):
    position, velocity, acceleration, jerk = independent_motion(trajectory)
    bounds = model.limits
    axis = model.to_controller(position)
    assert np.all(axis <= bounds.controller_high + 1e-9), seed
    assert np.all(axis >= bounds.controller_low - 1e-9), seed
    assert np.all(position <= bounds.position_high + 1e-9), seed
    assert np.all(position >= bounds.position_low - 1e-9), seed
    for value, limit in (
        (velocity, bounds.velocity),
        (acceleration, bounds.acceleration),
        (jerk, limits.jerk),
    ):
        assert np.all(np.abs(model.to_controller(value)) <= SLACK * limit), seed
    rows = np.unique(
        np.concatenate(
            [
                np.argmax(np.abs(acceleration), axis=0),
                np.argmax(np.abs(velocity), axis=0),
                np.linspace(0, len(position) - 1, 60).astype(int),
            ]
        )
    )
    torque = model.drive_torque(position[rows], velocity[rows], acceleration[rows])
    assert np.all(np.abs(torque) <= SLACK * bounds.effort), seed
    assert point_speeds(model, position[rows], velocity[rows]) <= limits.point_speed_m_s, seed
    closest = model.geometry.clearance(position[rows])
    if closest is not None:
        assert closest.distance_m >= limits.clearance_m, seed


@given(
    robot=st.sampled_from(sorted(ROBOTS)),
    seed=st.integers(0, 10_000),
    strength=st.floats(0.2, 3.0),
    signal=st.sampled_from(['random_pulses', 'band_limited_noise']),
    low_hz=st.floats(1.0, 10.0),
    pose=st.integers(0, 2),
)
@settings(max_examples=15, deadline=None, suppress_health_check=list(HealthCheck))
def test_accepted_means_every_limit_holds_between_the_samples(
    robot, seed, strength, signal, low_hz, pose
):
    model = ROBOTS[robot]
    names = list(model.poses_controller_rad)
    start = model.pose(names[pose % len(names)])
    request = PlanRequest(
        seed=seed,
        signal=signal,
        duration_s=3.0,
        start_position=tuple(float(angle) for angle in start),
        acceleration_rms=strength,
        band_low_hz=low_hz,
        half_range=0.02 * strength,
        speed_low=min(0.3 * strength, 1.0),
        speed_high=min(strength, 1.0),
        acceleration_high=min(0.4 * strength, 1.0),
        acceleration_low=0.05,
        fade_s=0.3,
        enforce_tolerance=False,
    )
    try:
        trajectory = draw_motion(bring_together(model, None, request)).trajectory
    except PlanError as error:
        assert 'no pulse' in str(error)
        return
    limits = plan_limits(model, request)
    try:
        check_limits(trajectory, limits)
    except PlanError as error:
        assert error.found is not None
        assert error.expected is not None
        return
    assert_all_limits_hold(model, trajectory, limits, seed)


def one_joint(joint, amplitude, frequency_hz, robot='irb6660_205_190', pose='P1', duration_s=4.0):
    """Return a faded sine of one joint, position amplitude in rad."""
    model = ROBOTS[robot]
    time_s = np.arange(round(duration_s / 0.004) + 1) * 0.004
    fade = np.sin(np.pi * time_s / duration_s) ** 4
    velocity = np.zeros((len(time_s), 6))
    velocity[:, joint] = np.gradient(
        amplitude * fade * np.sin(2.0 * np.pi * frequency_hz * time_s), 0.004
    )
    velocity[[0, -1]] = 0.0
    return model, Trajectory.from_velocity(model.pose(pose), velocity, 0.004)


@pytest.mark.parametrize(
    ('joint', 'amplitude', 'frequency_hz', 'kind', 'owner', 'unit'),
    [
        (2, -0.25, 0.125, 'axis range', 'axis_3', 'deg'),
        (5, 0.6, 1.0, 'velocity', 'axis_6', 'deg/s'),
        (5, 0.02, 5.0, 'acceleration', 'axis_6', 'deg/s²'),
        (5, 0.0015, 9.0, 'jerk', 'axis_6', 'deg/s³'),
        (1, 0.05, 1.0, 'point speed', 'link', 'm/s'),
    ],
)
def test_each_limit_is_refused_by_name_with_time_value_and_limit(
    joint, amplitude, frequency_hz, kind, owner, unit
):
    model, trajectory = one_joint(joint, amplitude, frequency_hz)
    with pytest.raises(PlanError) as caught:
        check_limits(trajectory, PlanLimits(model))
    line = str(caught.value)
    for word in (kind, owner, unit, ' s: ', 'found', 'expected'):
        assert word in line, line


def test_a_limit_passed_by_a_hair_is_told_by_figures_that_differ():
    model = load_robot('irb6660_205_190')
    pose = model.to_serial(np.radians([0.0, 84.99999, 15.0, 0.0, 0.0, 0.0]))
    velocity = np.zeros((400, 6))
    velocity[1:200, 1], velocity[200:-1, 1] = 1e-6, -1e-6
    with pytest.raises(PlanError, match='axis range of axis_2') as caught:
        check_limits(Trajectory.from_velocity(pose, velocity, 0.004), PlanLimits(model))
    found, limit = (text.split()[-2] for text in (caught.value.found, caught.value.expected))
    assert float(found) > float(limit) == 85.0


def test_torque_limit_counts_gravity_and_inertia():
    model, trajectory = one_joint(1, 0.0005, 5.0)
    uses = {use.name: use for use in check_limits(trajectory, PlanLimits(model)).uses}
    used = uses['drive torque'].fraction
    for factor, accepted in ((1.02 * used, True), (0.98 * used, False)):
        weaker = replace(model.limits, effort=factor * model.limits.effort)
        limits = PlanLimits(replace(model, limits=weaker))
        if accepted:
            check_limits(trajectory, limits)
        else:
            with pytest.raises(PlanError, match=r'drive torque of axis_.*N m'):
                check_limits(trajectory, limits)
    gravity = model.drive_torque(trajectory.position[0], np.zeros(6), np.zeros(6))
    assert uses['drive torque'].fraction > 1.05 * np.max(np.abs(gravity) / model.limits.effort)


def test_self_collision_is_seen_where_the_arm_folds_into_itself():
    model = ROBOTS['irb6660_205_190']
    generator = np.random.default_rng(3)
    axis = generator.uniform(model.limits.controller_low, model.limits.controller_high, (800, 6))
    poses = [q for q in model.to_serial(axis) if model.limits.position_violation(q) is None]
    distances = [model.geometry.clearance(q).distance_m for q in poses]
    nearest = int(np.argmin(distances))
    still = Trajectory(0.004, np.tile(poses[nearest], (5, 1)), np.zeros((5, 6)))
    for margin_m, accepted in ((-0.002, True), (0.002, False)):
        limits = PlanLimits(model, clearance_m=distances[nearest] + margin_m)
        if accepted:
            assert check_limits(still, limits).clearance_m == pytest.approx(distances[nearest])
        else:
            with pytest.raises(PlanError, match=r'links .* come too close .*mm'):
                check_limits(still, limits)


def test_clearance_is_proven_between_the_poses_it_is_measured_at():
    """A fold that comes close in the middle of the motion is not stepped over."""
    model = ROBOTS['irb6660_205_190']
    start, end = model.to_serial(np.deg2rad([[0, 40, -10, 0, -115, 0], [0, 40, -10, 0, 115, 0]]))
    path = start + np.linspace(0.0, 1.0, 2001)[:, None] * (end - start)
    brute = min(model.geometry.clearance(q).distance_m for q in path[::5])
    proven = proven_clearance(model, path, least_m=0.0)
    assert proven.distance_m <= brute + 1e-9
    assert proven.distance_m > 0.3 * brute


def test_a_plan_is_never_clipped():
    """Just below a limit it is accepted with the values it asked for; just above refused whole."""
    model, trajectory = one_joint(5, 0.001, 8.0)
    envelope = check_limits(trajectory, PlanLimits(model))
    worst = envelope.worst
    for factor, accepted in ((0.99 / worst.fraction, True), (1.01 / worst.fraction, False)):
        scaled = Trajectory.from_velocity(
            trajectory.position[0], trajectory.velocity * factor, 0.004
        )
        if accepted:
            assert check_limits(scaled, PlanLimits(model)).worst.fraction == pytest.approx(
                0.99, abs=5e-3
            )
            assert np.max(np.abs(scaled.velocity)) == pytest.approx(
                factor * np.max(np.abs(trajectory.velocity)), rel=1e-6
            )
        else:
            with pytest.raises(PlanError):
                check_limits(scaled, PlanLimits(model))
