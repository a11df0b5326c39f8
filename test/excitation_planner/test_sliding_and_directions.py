"""What the default plan does to a real arm: its gears slide, and it pushes in every direction."""

import numpy as np
import pytest

from excitation_planner.forecast.participation import PART_OF_BAND
from excitation_planner.forecast.torque_projection import joint_axes
from excitation_planner.motion.sliding import sliding_share
from excitation_planner.planner import plan_excitation
from excitation_planner.request import PlanRequest
from modal_core.channel import SensorLayout
from modal_core.errors import PlanError
from oma_identifier.covariance.thresholds import COVARIANCE
from robot_bridge.player import PlanPath, PlanPlayer, PlayerSettings
from structural_model import load_layout, load_robot
from structural_model.equations import random_poses

ROBOT = 'irb6660_205_190'
SEED = 1606
PRESLIDING_RAD = 1e-3


@pytest.fixture(scope='module')
def robot():
    return load_robot(ROBOT)


def _poses(robot, count):
    """Named poses and random ones (seed 1606) inside the ranges."""
    poses = [robot.pose(name) for name in ('P1', 'P2', 'P3')]
    generator, limits = np.random.default_rng(SEED), robot.limits
    while len(poses) < count:
        axes = generator.uniform(limits.controller_low, limits.controller_high)
        serial = robot.to_serial(np.clip(axes, -3.0, 3.0))
        if limits.position_violation(serial) is None:
            poses.append(serial)
    return poses


def _weakest(robot, plan):
    """D(τ) from inverse dynamics of the motion, rotors and weight left out, over its path."""
    path = plan.trajectory
    rows = np.arange(0, plan.n_samples, 40)
    q, rise = path.position[rows], path.acceleration[rows]
    still = np.zeros_like(q)
    gears = [joint.drive for joint in robot.spec.joints]
    rotor = np.array([gear.gear_ratio**2 * gear.rotor_inertia_kg_m2 for gear in gears])
    torque = robot.drive_torque(q, still, rise) - robot.drive_torque(q, still, still)
    torque -= robot.to_controller(rise) * rotor
    rms = np.sqrt(np.mean(torque**2, axis=0))
    values = [np.linalg.svd(joint_axes(robot, at) * rms[:, None])[1] for at in q[::60]]
    return min(value[2] / value[0] for value in values)


@pytest.mark.slow
@pytest.mark.parametrize('number', range(6))
def test_torques_on_the_structure_span_space_along_the_path(robot, number):
    pose = _poses(robot, 6)[number]
    request = PlanRequest(start_position=tuple(pose), duration_s=20.0, box_m=(), clearance_m=0.0)
    try:
        plan = plan_excitation(robot, None, request)
    except PlanError as error:
        assert number >= 3, error
        assert error.where, error
        return
    assert plan.torque_projection_rank == 3
    assert plan.prediction.projection.ratio >= 0.05
    assert _weakest(robot, plan) >= 0.045


def test_equal_amplitudes_leave_a_direction_without_torque_and_are_refused(robot):
    """Link inertias: about 400 kg m² on axis 1, 2.4 on axis 4, 0.3 on axis 6."""
    equal = PlanRequest(
        start_position=tuple(robot.pose('P2')), duration_s=6.0, joint_weights=(1.0,)
    )
    with pytest.raises(PlanError, match=r'structure.*rank 2.*base x.*axis_4, axis_6'):
        plan_excitation(robot, None, equal)


@pytest.mark.parametrize('pose', ['P1', 'P2', 'P3'])
def test_gears_slide_most_of_the_time_and_stay_within_what_is_allowed(robot, pose):
    """Each gear as a Dahl element: it slides while its friction is within 10 % of Coulomb's."""
    request = PlanRequest(start_position=tuple(robot.pose(pose)), duration_s=30.0)
    plan = plan_excitation(robot, load_layout(ROBOT), request)
    assert plan.signal == 'sliding_noise'
    axis = robot.to_controller(plan.position)
    friction, slides = np.zeros(6), np.zeros((len(axis), 6), dtype=bool)
    for row, way in enumerate(np.diff(axis, axis=0)):
        # dz/dx = 1 - sign(x') z / z_max with z_max a third of the presliding travel.
        friction += way / (PRESLIDING_RAD / 3.0) * (1.0 - np.sign(way) * friction)
        friction = np.clip(friction, -1.0, 1.0)
        slides[row] = np.abs(friction) > 0.9
    assert np.all(slides.mean(axis=0) > 0.85), slides.mean(axis=0)
    assert plan.prediction.sliding_share == pytest.approx(slides.mean(axis=0), abs=0.06)
    assert np.all(plan.mode_frequency_sensitivity <= request.frequency_tolerance)
    assert np.array_equal(plan.velocity[[0, -1]], np.zeros((2, 6)))
    assert plan.position[-1] == pytest.approx(plan.position[0], abs=1e-9)


def test_noise_alone_stays_in_presliding_and_a_short_range_is_not_swept(robot):
    noise = PlanRequest(signal='band_limited_noise', duration_s=6.0)
    assert max(plan_excitation(robot, None, noise).prediction.sliding_share) < 0.1
    narrow = PlanRequest(duration_s=6.0, frequency_tolerance=0.002)
    plan = plan_excitation(robot, None, narrow)
    assert plan.signal == 'band_limited_noise'
    assert any('no sweeps' in notice for notice in plan.prediction.notices)
    with pytest.raises(PlanError, match='hardly slide'):
        plan_excitation(
            robot,
            None,
            PlanRequest(signal='sliding_noise', duration_s=6.0, frequency_tolerance=0.002),
        )


def test_a_peak_of_the_noise_beyond_the_acceleration_limit_lowers_it_instead_of_refusing(robot):
    """Of 20 random poses one was refused for 406 of 400 deg/s² on axis 4."""
    start = random_poses(robot.limits, 1, np.random.default_rng(7314))[0]
    plan = plan_excitation(robot, None, PlanRequest(seed=7314, start_position=tuple(start)))
    assert plan.signal == 'sliding_noise'
    assert any('dB below what was asked' in notice for notice in plan.prediction.notices)
    worst = next(use for use in plan.prediction.envelope.uses if use.name == 'acceleration')
    assert 0.6 < worst.fraction < 1.0


def test_the_band_of_noise_weaker_than_its_sweeps_is_that_of_the_noise(robot):
    """30 dB below what was asked; of the sweeps' 0 to 5 Hz the identifier found no mode of 7."""
    start = random_poses(robot.limits, 1, np.random.default_rng(7303))[0]
    plan = plan_excitation(robot, None, PlanRequest(seed=7303, start_position=tuple(start)))
    assert any('30 dB below what was asked' in notice for notice in plan.prediction.notices)
    assert plan.band_low_hz < 6.0 and plan.band_high_hz == pytest.approx(60.0, abs=1.0)


def test_sweeps_stay_within_the_range_a_person_gives(robot):
    request = PlanRequest(duration_s=10.0, half_range=np.deg2rad(0.8))
    plan = plan_excitation(robot, None, request)
    off = robot.to_controller(plan.position - plan.position[0])
    assert plan.signal == 'sliding_noise'
    assert np.max(np.abs(off)) < np.deg2rad(0.85)


def test_a_joint_that_rests_after_a_move_does_not_slide():
    move = np.concatenate([np.linspace(0.0, 0.1, 500), np.full(1500, 0.1)])[:, None]
    assert sliding_share(move, 0.004, PRESLIDING_RAD)[0] == pytest.approx(0.25, abs=0.02)


def test_the_player_grows_a_sweeping_plan_in_its_own_time(robot):
    """Sweeps go far for their speed, but begin after the ramp: no 40 s of ramp-in."""
    request = PlanRequest(start_position=tuple(robot.pose('P2')), duration_s=20.0)
    plan = plan_excitation(robot, None, request)
    path = PlanPath.from_trajectory(plan.plan_hash, plan.trajectory, robot.to_controller)
    player = PlanPlayer(path, path.start_deg, PlayerSettings())
    for _ in range(300):
        player.step(0.004)
    assert player.position_deg == pytest.approx(path.position(1.2), abs=1e-9)


def test_a_plan_of_pulses_carries_all_its_modes_and_says_what_reaches_the_missed(robot):
    layout = load_layout(ROBOT)
    request = PlanRequest(signal='random_pulses', duration_s=20.0)
    plan = plan_excitation(robot, layout, request)
    modes = robot.modes(robot.pose('P1'))
    inside = modes.frequency_hz[modes.frequency_hz <= request.band_high_hz]
    assert plan.mode_frequency_hz == pytest.approx(inside, rel=1e-5)
    assert len(plan.mode_signal_to_noise_db) == len(plan.mode_frequency_sensitivity) == len(inside)
    missed = plan.prediction.missed
    assert missed
    assert all(mode.cure for mode in missed)
    assert any('band_limited_noise would reach it' in mode.cure for mode in missed)
    better = plan_excitation(robot, layout, PlanRequest(duration_s=20.0))
    assert not better.prediction.missed


@pytest.mark.parametrize(
    ('above', 'cure'), [(0.98, 'band_high_hz of'), (None, 'with max_frequency_hz stated')]
)
def test_a_mode_at_the_edge_of_the_excitation_is_forecast_missed(robot, above, cure):
    """The identifier's band ends below the corner of the noise, which looks like a mode."""
    assert PART_OF_BAND == COVARIANCE.below_edge
    layout = load_layout(ROBOT)
    start, high_hz = robot.pose('P1'), 60.0
    if above is None:
        # A pose whose mode lies at 57.69 Hz.
        start = random_poses(robot.limits, 1, np.random.default_rng(112))[0]
    else:
        frequency_hz = robot.modes(start).frequency_hz
        high_hz = float(frequency_hz[frequency_hz < 55.0][-1]) / above
    request = PlanRequest(
        start_position=tuple(start), band_high_hz=high_hz, duration_s=6.0, require_full_rank=False
    )
    modes = plan_excitation(robot, layout, request).prediction.modes
    assert [mode.missed for mode in modes] == [False] * (len(modes) - 1) + [True]
    assert modes[-1].frequency_hz > 0.95 * high_hz
    assert 'where the analysed band ends' in modes[-1].reason and cure in modes[-1].cure


def test_a_missed_mode_says_which_sensor_would_see_it(robot):
    base = SensorLayout(tuple(s for s in load_layout(ROBOT).sensors if 'base' in s.name))
    request = PlanRequest(duration_s=6.0, noise_density=0.02, signal='band_limited_noise')
    cures = [mode.cure for mode in plan_excitation(robot, base, request).prediction.missed]
    assert cures
    assert any(cure.startswith('a sensor on ') for cure in cures)
