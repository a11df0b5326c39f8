"""Effects hidden in the arm, each against what it must do by its own equation."""

from dataclasses import replace
import math
from pathlib import Path
import re

import numpy as np
import pytest
import yaml

from abb_emulator.cell import ArmSide, CellSettings
from abb_emulator.mechanics.arm import Arm
from abb_emulator.mechanics.arm_effect import ArmEffect, KINDS, read_effects
from abb_emulator.mechanics.arm_structure import with_effects, with_tolerances
from abb_emulator.mechanics.gear_settings import GearSettings
from abb_emulator.mechanics.gear_springs import GearSprings
from abb_emulator.run_plan import ArmOptions, run_plan
from abb_emulator.sensing.sensors import SensorSettings
from excitation_planner.planner import plan_excitation
from excitation_planner.request import PlanRequest
from modal_core.channel import Channel
from modal_core.errors import SettingsError
from modal_core.measurements import JointSamples, SampleBlock
from modal_recordings import open_recording
from structural_model.robot_files import load_layout

RATE_HZ = 2048.0
STEP_S = 1.0 / RATE_HZ
N = 512
QUIET = SensorSettings(noise_density=0.0, bias=0.0, resolution=0.0)
EXAMPLES = {
    'payload': {'link': 'flange', 'mass': 20.0, 'com': [0.1, 0.0, 0.05]},
    'joint_stiffness': {'joint': 'joint_2', 'factor': 0.7},
    'joint_damping': {'joint': 'joint_2', 'factor': 3.0},
    'base_compliance': {'compliance': 3e-8},
    'link_flexibility': {'link': 'link_2', 'position': [0, 0, 0.35], 'compliance': 2e-7},
    'rod_spring': {'stiffness': 1e6, 'sign': -1},
    'tuned_mass': {'link': 'link_3', 'mass': 15.0, 'frequency': 12.0},
    'servo_compliance': {'frequency': 30.0},
    'coulomb_friction': {'joint': 'joint_2', 'torque': 150.0},
    'backlash': {'joint': 'joint_1', 'half_gap': 1e-4},
    'cubic_stiffness': {'joint': 'joint_2', 'alpha': 1e6},
    'speed_dependent_stiffness': {'joint': 'joint_2', 'beta': 3.0},
    'transmission_error': {'joint': 'joint_1', 'sine': 3e-5, 'order': 200.0},
    'tonal_disturbance': {'joint': 'joint_2', 'frequency': 17.0, 'torque': 100.0},
    'hysteresis': {'joint': 'joint_2', 'share': 0.4, 'limit': 5e-5},
    'presliding': {'joint': 'joint_2', 'share': 0.4, 'limit': 5e-4},
    'thermal_drift': {'joint': 'joint_2', 'change': -0.2, 'time_constant': 0.5},
    'command_delay': {'delay': 0.006},
    'sensor_gain': {'sensor': 'wrist', 'gain': 1.3},
    'sensor_polarity': {'sensor': 'wrist', 'axis': 'y'},
    'sensor_axis_swap': {'sensor': 'wrist', 'axes': 'xz'},
    'sensor_rotation': {'sensor': 'wrist', 'rotation': [0.1, -0.2, 0.3]},
    'sensor_delay': {'sensor': 'wrist', 'delay': 0.0042},
    'sensor_mount_resonance': {'sensor': 'wrist', 'frequency': 90.0},
    'sensor_mass': {'sensor': 'spindle', 'mass': 3.0},
}


def effect(name, **changes):
    return ArmEffect.from_mapping({'type': name, **EXAMPLES[name], **changes})


@pytest.fixture(scope='module')
def channels():
    return load_layout('irb6660_205_190', 'sensors').channels


@pytest.fixture(scope='module')
def motion(model):
    """Return a sine of 2 rad/s² in every joint, faded in: q, qd, qdd."""
    time_s = (np.arange(N) + 1) * STEP_S
    u = np.minimum(time_s / 0.08, 1.0)
    fade = u**3 * (10 + u * (6 * u - 15))
    q = np.zeros((N, 6))
    for joint, hz in enumerate((9.0, 11.0, 14.0, 18.0, 23.0, 29.0)):
        omega = 2 * np.pi * hz
        q[:, joint] = 2.0 / omega**2 * fade * np.sin(omega * time_s)
    qd = np.gradient(q, STEP_S, axis=0, edge_order=2)
    return model.pose('P1') + q, qd, np.gradient(qd, STEP_S, axis=0, edge_order=2)


def samples(model, channels, start_deg, motion, effects=(), **settings):
    cell = CellSettings(sensors=QUIET, effects=tuple(effects), **settings)
    side = ArmSide(model, channels, start_deg, cell)
    blocks = side.take(motion)
    found = np.full((N + 64, len(channels)), np.nan)
    for block in blocks:
        found[block.first_index : block.first_index + len(block.acceleration)] = block.acceleration
    return found[:N]


@pytest.fixture(scope='module')
def plain(model, channels, start_deg, motion):
    return samples(model, channels, start_deg, motion)


def test_every_kind_has_an_example():
    assert set(EXAMPLES) == set(KINDS)


@pytest.mark.parametrize('name', KINDS)
def test_every_effect_shows_and_its_label_comes_back(
    name, model, channels, start_deg, motion, plain
):
    made = effect(name)
    assert ArmEffect.from_mapping(made.to_mapping()) == made
    found = samples(model, channels, start_deg, motion, [made])
    both = np.isfinite(found[:, 0])
    assert both.sum() > 0.9 * N
    moved = np.abs(found - plain)[both]
    assert moved.max() > 0.01, 'nothing to see'
    assert np.abs(found[both]).max() < 100.0
    if name.startswith('sensor_') and name != 'sensor_mass':
        columns = [c for c, item in enumerate(channels) if item.name.startswith('wrist.')]
        assert np.delete(moved, columns, axis=1).max() < 1e-5


NEUTRAL = {
    'payload': {'mass': 1e-9},
    'joint_stiffness': {'factor': 1.0},
    'joint_damping': {'factor': 1.0},
    'base_compliance': {'compliance': 1e-18},
    'rod_spring': {'stiffness': 1e-6},
    'tuned_mass': {'mass': 1e-9},
    'coulomb_friction': {'torque': 1e-9},
    'backlash': {'half_gap': 1e-14},
    'cubic_stiffness': {'alpha': 1e-9},
    'speed_dependent_stiffness': {'beta': 1e-12},
    'transmission_error': {'sine': 0.0},
    'tonal_disturbance': {'torque': 0.0},
    'hysteresis': {'share': 1e-12},
    'presliding': {'share': 1e-12},
    'thermal_drift': {'change': 1e-12},
    'sensor_gain': {'gain': 1.0},
    'sensor_rotation': {'rotation': [0, 0, 0]},
    'sensor_mount_resonance': {'frequency': 1e6},
    'sensor_mass': {'mass': 1e-9},
}


@pytest.mark.parametrize('name', NEUTRAL)
def test_an_effect_of_no_size_changes_nothing(name, model, channels, start_deg, motion, plain):
    found = samples(model, channels, start_deg, motion, [effect(name, **NEUTRAL[name])])
    np.testing.assert_allclose(found, plain, atol=1e-4)


def test_masses_and_springs_stand_where_they_should(model, channels):
    pose = model.pose('P1')
    before = model.matrices(pose)
    spot = [
        Channel(str(axis), 'flange', tuple(direction.tolist()), (0.1, 0.0, 0.05))
        for axis, direction in enumerate(np.eye(3))
    ]
    load = with_effects(model, [effect('payload', gyration=[1e-6] * 3)], channels)
    jacobian = model.sensor_jacobian(pose, spot)
    np.testing.assert_allclose(
        load.matrices(pose).M - before.M, 20.0 * jacobian.T @ jacobian, atol=1e-6
    )
    rod = with_effects(model, [effect('rod_spring')], channels).matrices(pose).K - before.K
    w = np.zeros(model.n_dof)
    w[model.dof_names.index('joint_2/drive')] = 1.0
    w[model.dof_names.index('joint_3/drive')] = -1.0
    np.testing.assert_allclose(rod, 1e6 * np.outer(w, w), atol=1e-3)
    soft = with_effects(model, [effect('base_compliance')], channels)
    for row in (3, 4):
        give = 1.0 / soft.assembly.stiffness[row, row] - 1.0 / model.assembly.stiffness[row, row]
        assert give == pytest.approx(3e-8, rel=1e-9)
    hung = with_effects(model, [effect('tuned_mass')], channels)
    assert hung.n_dof == model.n_dof + 1
    row = next(n for n, name in enumerate(hung.dof_names) if name not in model.dof_names)
    matrices = hung.matrices(pose)
    hz = math.sqrt(hung.assembly.stiffness[row, row] / matrices.M[row, row]) / (2 * math.pi)
    assert hz == pytest.approx(12.0)
    factor = with_effects(model, [effect('joint_stiffness')], channels).parameters()
    name = 'joints.joint_2.drive.spring.stiffness'
    assert factor[name] == pytest.approx(0.7 * model.parameters()[name])


def test_a_drift_that_has_come_to_its_end_is_another_stiffness(model, channels, start_deg, motion):
    """Two ways to the same arm: the torque law and the structure itself."""
    warm = samples(
        model, channels, start_deg, motion,
        [effect('thermal_drift', change=-0.3, time_constant=0.01)], uptime_s=10.0,
    )  # fmt: skip
    soft = samples(model, channels, start_deg, motion, [effect('joint_stiffness', factor=0.7)])
    np.testing.assert_allclose(warm, soft, atol=2e-2 * np.ptp(soft, axis=0).max())


def test_a_stiff_servo_is_none(model, channels, start_deg, motion, plain):
    found = samples(
        model, channels, start_deg, motion, [effect('servo_compliance', frequency=3e3)]
    )
    np.testing.assert_allclose(found, plain, atol=2e-3 * np.ptp(plain, axis=0).max())


def line(values, hz):
    """Return the complex amplitude of a line, by a Hann window."""
    time_s = (np.arange(len(values)) + 1) * STEP_S
    window = np.hanning(len(values))
    return 2 * (window * np.exp(-2j * np.pi * hz * time_s)) @ values / window.sum()


@pytest.mark.parametrize('name', ['tonal_disturbance', 'transmission_error'])
def test_lines_have_the_size_the_frequency_response_gives(name, model):
    """A tone, and the ripple of a joint that turns steadily."""
    pose, n, axis = model.pose('P1'), 4096, 0
    matrices = model.matrices(pose)
    spring = model.spec.joints[axis].drive.spring
    q, qd, still = np.tile(pose, (n, 1)), np.zeros((n, 6)), np.zeros((n, 6))
    if name == 'tonal_disturbance':
        hz, made = 17.0, effect(name, joint='joint_1')
        push = 100.0
    else:
        speed, order = 0.1, 942.0
        hz, made = speed * order / (2 * np.pi), effect(name, joint='joint_1', order=order)
        q[:, axis] += speed * (np.arange(n) + 1) * STEP_S
        qd[:, axis] = speed
        # e = a sin(order (q0 + speed t)); the sine is -j.
        push = -1j * 3e-5 * np.exp(1j * order * pose[axis])
        push *= spring.stiffness + 2j * np.pi * hz * spring.damping
    arm = Arm(model, (), pose, STEP_S, effects=[made])
    found = np.concatenate(
        [arm.advance(q[i : i + 64], qd[i : i + 64], still[:64]).deflection
         for i in range(0, n, 64)]
    )[n // 2 :]  # fmt: skip
    omega = 2 * np.pi * hz
    load = np.zeros(model.n_dof)
    load[model.dof_names.index('joint_1/drive')] = 1.0
    dynamic = matrices.K - omega**2 * matrices.M + 1j * omega * matrices.C
    expected = np.linalg.solve(dynamic, load * push)
    # The joint turns on through 0.2 rad: the response about its middle, to some percent.
    phase = np.exp(2j * np.pi * hz * (n // 2) * STEP_S)
    seen = np.array([line(column, hz) for column in found.T]) / phase
    near = 0.02 if name == 'tonal_disturbance' else 0.1
    np.testing.assert_allclose(seen, expected, atol=near * np.abs(expected).max())


def test_slip_follows_its_equation_and_not_the_step(model):
    """dz/dy = 1 - sign(y') z / L, integrated finely; the loop is closed and has an area."""
    limit, share = 5e-5, 0.4
    settings = GearSettings(slip_share=(share,) * 6, slip_limit_rad=(limit,) * 6)
    path = 2e-4 * np.sin(np.linspace(0.0, 4 * np.pi, 200001))
    z, fine = 0.0, np.empty(len(path))
    for k in range(1, len(path)):
        dy = path[k] - path[k - 1]
        z += dy * (1.0 - math.copysign(1.0, dy) * z / limit)
        fine[k] = z
    for every in (250, 1000):
        springs = GearSprings(settings, model)
        springs.rest(np.zeros(6), np.zeros(6))
        factor = springs.factor(np.zeros((1, 6)), np.zeros(1))[0]
        found = []
        for y in path[::every]:
            found.append(springs.torque(np.full(6, y), factor, np.zeros(6))[0][1])
            springs.arrive(np.full(6, y), np.zeros(6))
        stiffness = model.spec.joints[1].drive.spring.stiffness
        wanted = share * stiffness * fine[::every]
        np.testing.assert_allclose(found, wanted, atol=0.02 * share * stiffness * limit)
    y, torque = path[100000:], share * stiffness * fine[100000:]
    area = -np.sum(0.5 * (torque[1:] + torque[:-1]) * np.diff(y))
    assert abs(area) > share * stiffness * limit * 2e-4


def test_friction_of_a_joint_stiffens_it_while_it_stands_and_not_while_it_runs(model):
    """Dahl over axis and twist: slope k s where it stands, none after sliding through 5 limits."""
    limit, share = 3e-4, 0.3
    settings = GearSettings(stick_share=(share,) * 6, stick_limit_rad=(limit,) * 6)
    springs = GearSprings(settings, model)
    springs.rest(np.zeros(6), np.zeros(6))
    factor = springs.factor(np.zeros((1, 6)), np.zeros(1))[0]
    stiffness = share * np.array([joint.drive.spring.stiffness for joint in model.spec.joints])
    small = np.full(6, 1e-7)
    standing = springs.torque(small, factor, np.zeros(6))[0] / small
    np.testing.assert_allclose(standing, stiffness, rtol=1e-3)
    for angle in np.linspace(0.0, 5 * limit, 50):
        springs.arrive(np.zeros(6), np.full(6, angle))
    here = springs.torque(np.zeros(6), factor, np.full(6, 5 * limit))[0]
    on = springs.torque(small, factor, np.full(6, 5 * limit))[0]
    np.testing.assert_allclose(here, stiffness * limit, rtol=0.01)
    assert np.all(np.abs(on - here) / small < 0.01 * stiffness)


def test_speed_dependent_stiffness_takes_the_speed_of_the_axis(model):
    settings = GearSettings(speed_stiffness_s_rad=(0, 3.0, 0, 0, 0, 0))
    springs = GearSprings(settings, model)
    speed = np.array([[0.0, -0.5, 0, 0, 0, 0]])
    factor = springs.factor(speed, np.zeros(1))[0]
    torque, slope = springs.torque(np.full(6, 1e-4), factor, np.zeros(6))
    k = model.spec.joints[1].drive.spring.stiffness
    assert torque[1] == pytest.approx(k * 3.0 * 0.5 * 1e-4)
    assert slope[1] == pytest.approx(k * 1.5)
    assert not np.delete(torque, 1).any()


def test_sensor_errors_are_what_they_are_called(model, channels, start_deg, motion, plain):
    wrist = [c for c, item in enumerate(channels) if item.name.startswith('wrist.')]

    def wrist_of(name, **changes):
        return samples(model, channels, start_deg, motion, [effect(name, **changes)])[:, wrist]

    right = plain[:, wrist]
    np.testing.assert_allclose(wrist_of('sensor_gain'), 1.3 * right, rtol=1e-5)
    np.testing.assert_allclose(wrist_of('sensor_gain', axis='z'), right * [1, 1, 1.3], rtol=1e-5)
    np.testing.assert_allclose(wrist_of('sensor_polarity'), right * [1, -1, 1], rtol=1e-5)
    np.testing.assert_allclose(wrist_of('sensor_axis_swap'), right[:, [2, 1, 0]], rtol=1e-5)
    turned = wrist_of('sensor_rotation')
    np.testing.assert_allclose(
        np.linalg.norm(turned, axis=1), np.linalg.norm(right, axis=1), rtol=1e-5
    )
    turn = np.linalg.lstsq(right, turned, rcond=None)[0].T
    angle = math.acos((np.trace(turn) - 1) / 2)
    assert angle == pytest.approx(math.sqrt(0.14), rel=1e-4)
    axis = np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
    np.testing.assert_allclose(axis / np.linalg.norm(axis), np.array([1, -2, 3]) / math.sqrt(14))


@pytest.mark.parametrize('delay_s', [0.0042, -0.003, 2.5 / RATE_HZ])
def test_a_late_or_early_sensor_keeps_its_shape(
    delay_s, model, channels, start_deg, motion, plain
):
    wrist = [c for c, item in enumerate(channels) if item.name.startswith('wrist.')]
    found = samples(
        model, channels, start_deg, motion, [effect('sensor_delay', delay=delay_s)]
    )  # fmt: skip
    others = np.delete(np.arange(len(channels)), wrist)
    known = np.isfinite(found[:, 0])
    np.testing.assert_allclose(found[known][:, others], plain[known][:, others], atol=1e-5)
    # As interpolated by a spline, away from the ends.
    from scipy.interpolate import CubicSpline

    middle = np.arange(40, N - 80)
    wanted = CubicSpline(np.arange(N), plain[:, wrist])(middle - delay_s * RATE_HZ)
    np.testing.assert_allclose(
        found[middle][:, wrist], wanted, atol=2e-3 * np.ptp(wanted, axis=0).max()
    )


def test_a_delayed_command_delays_everything(model, channels, start_deg, motion, plain):
    steps = 12
    found = samples(
        model, channels, start_deg, motion, [effect('command_delay', delay=steps / RATE_HZ)]
    )
    np.testing.assert_allclose(found[steps:], plain[:-steps], atol=1e-4)
    with pytest.raises(SettingsError, match='too short'):
        samples(model, channels, start_deg, motion, [effect('command_delay', delay=1e-5)])


def test_a_soft_mount_has_its_transfer_function(model, channels, start_deg):
    from abb_emulator.sensing.sensor_errors import SensorErrors

    made = effect('sensor_mount_resonance')
    errors = SensorErrors([made], channels, RATE_HZ, np.full(len(channels), 3.0))
    column = next(c for c, item in enumerate(channels) if item.name == 'wrist.x')
    n = 8192
    for hz in (20.0, 60.0, 88.0):
        time_s = (np.arange(n) + 1) * STEP_S
        wave = 3.0 + np.sin(2 * np.pi * hz * time_s)
        readings = np.tile(wave[:, None], (1, len(channels)))
        found = np.concatenate([errors.apply(part) for part in np.split(readings, 64)])[:, column]
        r = hz / 90.0
        wanted = (1 + 0.1j * r) / (1 - r * r + 0.1j * r)
        ratio = line(found[n // 2 :] - 3.0, hz) / line(wave[n // 2 :] - 3.0, hz)
        # Straight lines between the samples take (π f / rate)² / 3 off a sine.
        assert ratio == pytest.approx(wanted, rel=1.2 * (np.pi * hz * STEP_S) ** 2 / 3 + 1e-4)


def test_tolerances_are_seeded_and_of_the_size_stated(model):
    random = [np.random.default_rng(seed) for seed in (7, 7, 8)]
    first, again, other = (with_tolerances(model, 1.0, item).parameters() for item in random)
    assert first == again != other
    names = [n for n in model.parameters() if n.endswith('.stiffness')]
    names = [n for n in names if math.isfinite(model.parameters()[n])]
    many = [
        with_tolerances(model, 1.0, np.random.default_rng(seed)).parameters() for seed in range(30)
    ]
    spread = np.std([[math.log(item[n] / model.parameters()[n]) for n in names] for item in many])
    assert spread == pytest.approx(0.015, rel=0.1)
    assert with_tolerances(model, 0.0, random[0]) is model


WRONG = (
    ({'type': 'gremlin'}, 'unknown effect'),
    ({'type': 'payload', 'link': 'flange'}, 'missing'),
    ({'type': 'payload', 'link': 'flange', 'mass': -1}, 'not positive'),
    ({'type': 'payload', 'mass': 3}, 'link missing'),
    ({'type': 'payload', 'link': 'flange', 'mass': 3, 'colour': 1}, 'unknown value'),
    ({'type': 'sensor_axis_swap', 'sensor': 'wrist', 'axes': 'xx'}, 'no such axis'),
    ({'type': 'payload', 'link': 'flange', 'mass': 3, 'com': [1, 2]}, 'bad vector'),
    ({'type': 'backlash', 'joint': 'joint_2', 'half_gap': 'wide'}, 'not a number'),
    (7, 'not a mapping'),
)


@pytest.mark.parametrize(('data', 'reason'), WRONG)
def test_wrong_effects_are_refused_in_one_line(data, reason):
    with pytest.raises(SettingsError) as caught:
        read_effects([data])
    assert reason in str(caught.value)
    assert '\n' not in str(caught.value)


@pytest.mark.parametrize(
    ('name', 'place'), [('backlash', 'joint'), ('payload', 'link'), ('sensor_gain', 'sensor')]
)
def test_a_place_the_arm_does_not_have_is_refused(name, place, model, channels, start_deg, motion):
    with pytest.raises(SettingsError, match='no such place'):
        samples(model, channels, start_deg, motion, [effect(name, **{place: 'moon'})])


def test_effects_are_read_from_text_and_files(tmp_path):
    text = '[{type: backlash, joint: joint_2, half_gap: 1e-4}]'
    made = read_effects(text)
    assert made[0].number('half_gap') == 1e-4
    (tmp_path / 'hidden.yaml').write_text(f'effects: {text}')
    assert read_effects(tmp_path / 'hidden.yaml') == made
    assert read_effects('') == ()
    for wrong in ('[{', '[&a 1, *a]', str(tmp_path / 'none.yaml'), '3'):
        with pytest.raises(SettingsError):
            read_effects(wrong)


@pytest.fixture(scope='module')
def short_plans(model):
    layout = load_layout('irb6660_205_190', 'sensors')
    start = tuple(model.pose('P1').tolist())
    return {
        signal: plan_excitation(
            model, layout, PlanRequest(seed=1, signal=signal, duration_s=3.0, start_position=start)
        )
        for signal in ('band_limited_noise', 'random_pulses')
    }


@pytest.mark.parametrize('signal', ['band_limited_noise', 'random_pulses'])
def test_a_plan_is_recorded_with_what_is_hidden(signal, short_plans, model, tmp_path):
    plan = short_plans[signal]
    options = ArmOptions.from_mapping(
        {'seed': 5, 'sample_rate_hz': 1000, 'tolerance': 1.0, 'rest_s': 0.25,
         'effects': [{'type': 'payload', 'link': 'flange', 'mass': 20}]}
    )  # fmt: skip
    told = []
    cases = [options, options.with_effects()]
    if signal == 'band_limited_noise':
        cases.append(options)
    found = [
        run_plan(case, plan, tmp_path / f'{number}.mcap', told.append)
        for number, case in enumerate(cases)
    ]
    assert told[-1] == 1.0
    recorded = []
    for run in found:
        items = list(open_recording(run.path).measurements())
        blocks = [item for item in items if isinstance(item, SampleBlock)]
        joints = [item for item in items if isinstance(item, JointSamples)]
        samples_ = np.concatenate([block.acceleration for block in blocks])
        index = np.concatenate([b.first_index + np.arange(len(b.acceleration)) for b in blocks])
        np.testing.assert_array_equal(index, np.arange(len(index)))
        recorded.append((samples_, np.concatenate([item.position for item in joints])))
    if len(cases) > 2:
        np.testing.assert_array_equal(recorded[0][0], recorded[2][0])
    assert np.abs(recorded[0][0] - recorded[1][0]).max() > 0.1
    position = recorded[0][1]
    # The command stays the same: what is hidden is in the arm.
    np.testing.assert_array_equal(position, recorded[1][1])
    np.testing.assert_allclose(position[0], plan.start_position, atol=1e-5)
    np.testing.assert_allclose(position[-1], plan.position[-1], atol=2e-4)
    ratio = np.ptp(position, axis=0) / np.ptp(plan.position, axis=0)
    np.testing.assert_allclose(ratio, 1.0, atol=0.25)
    assert found[0].duration_s == pytest.approx(len(position) * 0.004032)


@pytest.mark.parametrize(
    'wrong',
    [
        {'colour': 1},
        {'seed': 'x'},
        {'servo': {'x': 1}},
        {'servo': 3},
        {'gears': {'friction_nm': [1]}},
    ],
)
def test_wrong_arm_options_are_refused(wrong):
    with pytest.raises(SettingsError, match='arm'):
        ArmOptions.from_mapping(wrong)
    assert replace(ArmOptions(), rest_s=2.0).rest_s == 2.0


def test_the_documentation_names_every_effect_and_its_example_is_read():
    text = (Path(__file__).parents[3] / 'docs' / 'reference' / 'abb.md').read_text()
    part = text[text.index('## Effects in the arm') : text.index('## Control law')]
    lines = [line[4:] for line in part.splitlines() if line.startswith('    ')]
    assert [item.type for item in read_effects(yaml.safe_load('\n'.join(lines))['effects'])] == [
        'payload', 'backlash', 'sensor_delay',
    ]  # fmt: skip
    rows = ' '.join(line for line in part.splitlines() if line.startswith('| '))
    assert set(re.findall(r'`(\w+)`', rows)) == set(KINDS)
