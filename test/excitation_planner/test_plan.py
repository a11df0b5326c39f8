"""The plan as a whole: same seed same bytes, the hash binds every field, limits hold."""

from dataclasses import replace
import hashlib

import numpy as np
import pytest

from excitation_planner.plan import canonical_bytes, check_plan, plan_hash, sealed
from excitation_planner.planner import plan_excitation
from excitation_planner.request import PlanRequest
from modal_core.errors import LayoutError, ModelError, PlanError, SettingsError
from structural_model import load_layout, load_robot

ROBOT = 'irb6660_205_190'


@pytest.fixture(scope='module')
def robot():
    return load_robot(ROBOT)


@pytest.fixture(scope='module')
def layout():
    return load_layout(ROBOT)


@pytest.fixture(scope='module')
def plan(robot, layout):
    return plan_excitation(robot, layout, PlanRequest(duration_s=6.0, seed=5))


def test_same_seed_same_bytes(robot, layout, plan):
    again = plan_excitation(load_robot(ROBOT), layout, PlanRequest(duration_s=6.0, seed=5))
    other = plan_excitation(robot, layout, PlanRequest(duration_s=6.0, seed=6))
    assert canonical_bytes(again) == canonical_bytes(plan)
    assert plan.plan_hash == again.plan_hash == hashlib.sha256(canonical_bytes(plan)).hexdigest()
    assert other.plan_hash != plan.plan_hash


@pytest.mark.parametrize(
    'change',
    [
        {'seed': 6},
        {'robot_name': 'another'},
        {'torque_projection_rank': 2},
        {'band_high_hz': 59.0},
        {'joint_names': tuple('abcdef')},
    ],
)
def test_hash_binds_scalars_and_names(plan, change):
    assert plan_hash(replace(plan, **change)) != plan.plan_hash


@pytest.mark.parametrize('name', ['position', 'velocity', 'peak_velocity', 'mode_frequency_hz'])
def test_hash_binds_the_last_bit_of_every_array(plan, name):
    array = getattr(plan, name).copy()
    array.flat[-1] = np.nextafter(array.flat[-1], np.inf)
    changed = replace(plan, **{name: array})
    assert plan_hash(changed) != plan.plan_hash
    with pytest.raises(PlanError):
        check_plan(changed)


def test_plan_is_frozen(plan):
    with pytest.raises(ValueError, match='read-only'):
        plan.position[0, 0] = 1.0


def test_plan_returns_to_rest_at_its_start(plan):
    assert np.array_equal(plan.position[0], plan.start_position)
    assert np.allclose(plan.position[-1], plan.start_position, atol=1e-10)
    assert not plan.velocity[0].any()
    assert not plan.velocity[-1].any()


def test_position_that_is_not_the_integral_of_velocity_is_refused(plan):
    position = plan.position.copy()
    position[100, 2] += 1e-4
    with pytest.raises(PlanError, match='not the integral'):
        check_plan(sealed(replace(plan, position=position)))


@pytest.mark.parametrize(
    'change',
    [
        {'sample_period_s': 1e308, 'duration_s': 1e308},
        {'sample_period_s': 5e-324, 'duration_s': 0.0},
        {'sample_period_s': 0.0},
        {'sample_period_s': -0.004},
        {'velocity': 1e308},
        {'position': 1e308},
        {'velocity': np.nan},
    ],
)
def test_numbers_of_no_machine_are_refused_before_anything_is_made_of_them(plan, change):
    for name in {'position', 'velocity'} & set(change):
        table = getattr(plan, name).copy()
        table[len(table) // 2] = change[name]
        change = {name: table}
    with pytest.raises(PlanError, match=r'out of range|not finite'):
        check_plan(sealed(replace(plan, **change)))


def long_plan(plan, n_samples, period_s):
    """Return a plan that stands still for as many samples."""
    position = np.broadcast_to(plan.position[0], (n_samples, plan.position.shape[1])).copy()
    return sealed(
        replace(
            plan, position=position, velocity=np.zeros_like(position), sample_period_s=period_s,
            duration_s=(n_samples - 1) * period_s,
        )
    )  # fmt: skip


@pytest.mark.parametrize(
    ('n_samples', 'period_s', 'field'),
    [(1_000_000, 0.004, 'n_samples'), (150_002, 0.001, 'n_samples'),
     (150_001, 0.00401, 'duration_s'), (1000, 1.0, 'duration_s')],
)  # fmt: skip
def test_a_plan_beyond_what_is_played_in_one_go_is_refused(plan, n_samples, period_s, field):
    with pytest.raises(PlanError, match=f'{field}: too long'):
        check_plan(long_plan(plan, n_samples, period_s))


@pytest.mark.parametrize(('n_samples', 'period_s'), [(150_001, 0.004), (601, 1.0)])
def test_the_longest_plan_is_taken(plan, n_samples, period_s):
    check_plan(long_plan(plan, n_samples, period_s))


def test_default_plan_sweeps_a_degree_and_fills_the_band(plan):
    assert plan.signal == 'sliding_noise'
    rms = np.rad2deg(np.std(plan.position, axis=0))
    assert np.all((rms > 0.2) & (rms < 2.0)), rms
    assert plan.band_low_hz <= 5.5
    assert plan.band_high_hz >= 59.0
    assert plan.torque_projection_rank == 3
    assert np.all(plan.mode_frequency_sensitivity < 0.02)


@pytest.mark.parametrize(
    ('change', 'error', 'words'),
    [
        ({'joints': ('elbow',)}, PlanError, ['elbow', 'axis_1', 'axis_6']),
        ({'start_position': (0.0, 2.0, 0.0, 0.0, 0.0, 0.0)}, ModelError, ['114.592 deg', '85']),
        ({'start_position': (0.0, 0.0)}, ModelError, ['2', '6']),
        ({'joints': ('joint_2', 'joint_3')}, PlanError, ['rank 1', 'rank 3', 'axis_1']),
        (
            {'acceleration_rms': 8.0, 'signal': 'band_limited_noise'},
            PlanError,
            ['deg/s²', '400', ' s: '],
        ),
        ({'point_speed_m_s': 0.01}, PlanError, ['m/s', '0.01', 'point speed']),
        ({'box_m': (-1.0, -2.0, 0.0, 1.0, 2.0, 3.0)}, PlanError, ['box in x', '1.0000 m']),
        (
            {'signal': 'random_pulses', 'frequency_tolerance': 1e-9},
            PlanError,
            ['no joint range', '1e-09', '0.001 deg'],
        ),
        (
            {'signal': 'random_pulses', 'half_range': 0.5, 'frequency_tolerance': 0.01},
            PlanError,
            ['7.196 deg', '<=', '1 %'],
        ),
        ({'frequency_tolerance': 1e-6}, PlanError, ['0.0001 %']),
    ],
)
def test_impossible_requests_say_why_in_one_line(robot, layout, change, error, words):
    with pytest.raises(error) as caught:
        plan_excitation(robot, layout, PlanRequest(**{'duration_s': 4.0, **change}))
    line = str(caught.value)
    assert '\n' not in line
    for word in words:
        assert word in line, line


def test_an_arm_without_stated_accelerations_is_told_what_moves_need():
    rigid = load_robot('kuka_kr300')
    with pytest.raises(PlanError, match=r'axis_1.*acceleration_deg_s2'):
        plan_excitation(rigid, None, PlanRequest(signal='random_pulses', duration_s=4.0))
    found = plan_excitation(rigid, None, PlanRequest(signal='sliding_noise', duration_s=8.0))
    assert found.duration_s == 8.0, 'noise is as strong as was asked, and needs no spring'


@pytest.mark.parametrize(
    ('change', 'words'),
    [
        ({'band_high_hz': 90.0}, ['90 Hz', '60 Hz']),
        ({'duration_s': float('nan')}, ['duration_s']),
        ({'duration_s': 1e9}, ['duration_s', '600']),
        ({'duration_s': 200.0, 'sample_period_s': 0.001}, ['duration_s', '<= 150 s', '0.001']),
        ({'seed': -1}, ['seed']),
        ({'seed': True}, ['seed']),
        ({'signal': 'sweep'}, ['sweep', 'random_pulses']),
        ({'joint_weights': (2.0,)}, ['joint_weights']),
        ({'interval_low_s': 2.0}, ['interval_low_s', '1']),
        ({'shape_gain': (1.0,)}, ['shape_gain']),
        ({'box_m': (1.0, 1.0, 1.0, 0.0, 2.0, 2.0)}, ['box_m']),
    ],
)
def test_requests_out_of_range_are_refused(change, words):
    with pytest.raises(SettingsError) as caught:
        PlanRequest(**change)
    for word in words:
        assert word in str(caught.value)


def test_unknown_request_field_is_named():
    with pytest.raises(SettingsError, match='durations'):
        PlanRequest.from_mapping({'durations': 3.0})


def test_layout_on_an_unknown_link_is_refused(robot, layout):
    wrong = replace(layout, sensors=(replace(layout.sensors[0], frame_id='nose'),))
    with pytest.raises(LayoutError, match='nose'):
        plan_excitation(robot, wrong, PlanRequest(duration_s=4.0))
