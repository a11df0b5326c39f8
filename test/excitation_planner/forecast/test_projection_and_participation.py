"""Torque projection, participation and predicted σ against known truth and simulation."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.signal import welch

from excitation_planner.forecast.participation import cramer_rao_std, VISIBLE_DB
from excitation_planner.forecast.torque_projection import (
    joint_axes,
    require_full_rank,
    torque_projection,
)
from excitation_planner.planner import plan_excitation
from excitation_planner.request import PlanRequest
from modal_core.errors import PlanError
from structural_model import load_layout, load_robot

ROBOT = 'irb6660_205_190'
NAMES = tuple(f'joint_{number}' for number in range(1, 7))
SEED = 77


@pytest.fixture(scope='module')
def robot():
    return load_robot(ROBOT)


def test_rank_and_singular_values_of_orthogonal_axes():
    projection = torque_projection(np.eye(3), np.array([3.0, 2.0, 1.0]), NAMES[:3])
    assert projection.rank == 3
    assert projection.singular_values == pytest.approx([3.0, 2.0, 1.0])
    assert projection.ratio == pytest.approx(1.0 / 3.0)
    assert projection.reason == ''


@pytest.mark.parametrize(('active', 'rank'), [((1, 2), 1), ((0, 1), 2), ((0, 1, 3), 3), ((5,), 1)])
def test_rank_at_the_zero_pose_follows_from_the_axes(robot, active, rank):
    """All angles 0: axis 1 is z, axes 2, 3 and 5 are y, axes 4 and 6 are x."""
    axes = joint_axes(robot, robot.pose('P2'))
    assert axes == pytest.approx(np.eye(3)[[2, 1, 1, 0, 1, 0]], abs=1e-9)
    torque = np.isin(np.arange(6), active).astype(float)
    projection = torque_projection(axes, torque, NAMES)
    assert projection.rank == rank


def test_reason_names_direction_and_joints_that_add_it(robot):
    axes = joint_axes(robot, robot.pose('P2'))
    projection = torque_projection(axes, np.array([1.0, 1.0, 1.0, 0.0, 1.0, 0.0]), NAMES)
    assert projection.missing == ((1.0, 0.0, 0.0),)
    assert projection.helpful_joints == ('joint_4', 'joint_6')
    with pytest.raises(PlanError, match=r'rank 2.*base x.*joint_4, joint_6'):
        require_full_rank(projection)


def test_axes_agree_with_finite_rotations(robot):
    q = np.array([0.3, 0.5, -0.4, 0.9, -1.1, 0.2])
    axes = joint_axes(robot, q)
    for joint in range(6):
        turned = [
            robot.kinematics.motion(q + sign * 1e-5 * np.eye(6)[joint]).rotation[0, -1]
            for sign in (-1.0, 1.0)
        ]
        skew = (turned[1] - turned[0]) / 2e-5 @ (0.5 * (turned[0] + turned[1])).T
        vector = np.array([skew[2, 1], skew[0, 2], skew[1, 0]])
        assert axes[joint] == pytest.approx(vector, abs=1e-8)


def test_std_without_noise_is_the_uncertainty_law():
    """Au (2014): σ_f/f = sqrt(ζ/(2π f T)), σ_ζ/ζ = 1/sqrt(2π f ζ T), for a wide band."""
    for frequency_hz, damping, duration_s in ((10.0, 0.01, 100.0), (40.0, 0.005, 60.0)):
        std = cramer_rao_std(frequency_hz, damping, 1e12, duration_s)
        law_f = frequency_hz * np.sqrt(damping / (2.0 * np.pi * frequency_hz * duration_s))
        law_z = damping / np.sqrt(2.0 * np.pi * frequency_hz * damping * duration_s)
        # The finite band costs some information (Au's B factors for κ = 12: 0.90 and 0.81).
        assert 1.0 < std.frequency_hz / law_f < 1.12
        assert 1.0 < std.damping_ratio / law_z < 1.25


def test_std_falls_with_the_signal_and_with_the_root_of_time():
    noisy = [cramer_rao_std(20.0, 0.02, ratio, 60.0) for ratio in (1e-4, 1e-2, 1.0, 1e2)]
    for worse, better in pairwise(noisy):
        assert worse.frequency_hz > better.frequency_hz
        assert worse.damping_ratio > better.damping_ratio
    longer = cramer_rao_std(20.0, 0.02, 1.0, 240.0)
    assert noisy[2].frequency_hz / longer.frequency_hz == pytest.approx(2.0, rel=1e-9)


def test_bound_is_reached_by_maximum_likelihood_on_simulated_noisy_records():
    """Monte Carlo: one mode in noise, Whittle's likelihood maximised; its scatter is the bound."""
    from scipy.optimize import minimize

    frequency_hz, damping, force_to_noise, duration_s, n_runs = 10.0, 0.02, 0.01, 200.0, 120
    lines = np.arange(round(7.6 * duration_s), round(12.4 * duration_s)) / duration_s
    generator = np.random.default_rng(SEED)

    def density(f0, z, force):
        ratio = lines / f0
        return force * ratio**4 / ((1 - ratio**2) ** 2 + (2 * z * ratio) ** 2) + 1.0

    truth = density(frequency_hz, damping, force_to_noise)

    def fit(power):
        def loss(x):
            expected = density(frequency_hz * np.exp(x[0]), damping * np.exp(x[1]), np.exp(x[2]))
            return np.sum(np.log(expected) + power / expected)

        start = [0.0, 0.0, np.log(force_to_noise)]
        return minimize(loss, start, method='Nelder-Mead', options={'xatol': 1e-6}).x

    estimates = np.array(
        [fit(truth * generator.exponential(size=len(lines))) for _ in range(n_runs)]
    )
    bound = cramer_rao_std(frequency_hz, damping, force_to_noise, duration_s)
    # 120 runs give each standard deviation to 6.5 %; three of these.
    assert np.std(estimates[:, 0]) * frequency_hz == pytest.approx(bound.frequency_hz, rel=0.2)
    assert np.std(estimates[:, 1]) * damping == pytest.approx(bound.damping_ratio, rel=0.2)


def test_predicted_resonance_agrees_with_the_simulated_response(robot):
    """Modal force and response, checked by integrating the model's equations of motion."""
    layout = load_layout(ROBOT)
    request = PlanRequest(duration_s=120.0, seed=SEED, acceleration_rms=1.0)
    plan = plan_excitation(robot, layout, request)
    mode = max(plan.prediction.modes[:4], key=lambda item: item.signal_to_noise_db)
    channel = layout.channel(mode.best_channel)
    response = robot.time_response(
        plan.start_position, [channel], plan.trajectory.acceleration, 250.0
    ).output[:, 0]
    frequency_hz, density = welch(response - np.mean(response), 250.0, nperseg=4096)
    half = mode.damping_ratio * mode.frequency_hz
    near = np.abs(frequency_hz - mode.frequency_hz) < half
    simulated_db = 10.0 * np.log10(np.mean(density[near]) / request.noise_density**2)
    # The mean over the half-power band is pi/4 of the peak.
    predicted_db = mode.signal_to_noise_db + 10.0 * np.log10(np.pi / 4.0)
    assert simulated_db == pytest.approx(predicted_db, abs=2.0), f'seed {SEED}'


def test_a_mode_no_sensor_sees_is_named_before_the_robot_moves(robot):
    layout = load_layout(ROBOT)
    base_only = type(layout)(
        sensors=tuple(sensor for sensor in layout if sensor.frame_id == 'base_link')
    )
    request = PlanRequest(duration_s=6.0, noise_density=0.008)
    assert not plan_excitation(robot, layout, request).prediction.missed
    forecast = plan_excitation(robot, base_only, request).prediction
    assert forecast.missed, 'the base plate moves least, and these sensors are poor'
    for mode in forecast.missed:
        assert mode.signal_to_noise_db < VISIBLE_DB
        assert any(f'{mode.frequency_hz:.2f} Hz would be missed' in n for n in forecast.notices)
    nowhere = plan_excitation(robot, None, request).prediction
    assert {mode.reason for mode in nowhere.missed} == {'no sensor'}


def test_resting_joints_lower_the_forecast_of_the_modes_they_drive(robot):
    layout = load_layout(ROBOT)
    every = plan_excitation(robot, layout, PlanRequest(duration_s=10.0))
    sixth = plan_excitation(
        robot,
        layout,
        PlanRequest(duration_s=10.0, joints=('joint_6',), require_full_rank=False),
    )
    assert sixth.torque_projection_rank == 1
    for all_joints, one_joint in zip(every.prediction.modes, sixth.prediction.modes, strict=True):
        assert one_joint.modal_force_density < 0.2 * all_joints.modal_force_density
