"""Robots in, models and plans out: the same as the command line's."""

import json

import numpy as np
import pytest

import autonomous_modal_analysis as ama
from modal_core.errors import ModelError, PlanError, RecordingError, SettingsError
from modal_core.measurements import JointSamples
from modal_recordings.containers import RecordingWriter
from modal_recordings.messages import encode
from structural_model.robot_files import load_layout, load_robot

ROBOT = 'irb6660_205_190'


def test_a_model_in_a_pose_is_what_the_command_prints(ama_command):
    found = ama.model(ROBOT, [0, 45, -10, 90, -90, 0], max_frequency_hz=40, step_deg=5)
    printed = ama_command(
        *('model', ROBOT, '--pose-deg', '0,45,-10,90,-90,0', '--max-frequency-hz', 40),
        *('--sensitivity', '--json'),
    )
    assert found.to_dict() == json.loads(printed)
    assert found.frequencies_hz.max() <= 40.0
    assert found.shapes.shape == (len(found.channel_names), len(found.frequencies_hz))


def test_a_model_has_the_modes_of_its_matrices():
    """K φ = ω² M φ: damping of a few per cent moves a frequency by its square."""
    found = ama.model(ROBOT, 'P2')
    matrices = found.model.matrices(found.q)
    squared = np.linalg.eigvals(np.linalg.solve(matrices.M, matrices.K)).real
    undamped_hz = np.sort(np.sqrt(squared)) / (2 * np.pi)
    n_modes = len(found.frequencies_hz)
    assert found.frequencies_hz == pytest.approx(undamped_hz[:n_modes], rel=5e-3)


def _recorded(path, q):
    """Return a recording of joint states around a pose, as the bridge publishes them."""
    stamps = np.arange(50, dtype=np.int64) * 4_000_000
    sway = 1e-3 * np.sin(2 * np.pi * np.arange(50) / 50)[:, None] * np.ones(6)
    names = tuple(f'joint_{number}' for number in range(1, 7))
    states = JointSamples(stamps, names[::-1], (q + sway)[:, ::-1], np.full((50, 6), np.nan))
    with RecordingWriter(path) as writer:
        for message in encode(states, '/joint_states'):
            writer.write(message.topic, message.message_type, message.log_time_ns, message.data)
    return path


def test_angles_of_axes_and_of_joints_are_told_apart(ama_command, tmp_path):
    """P1 by every way there is: its modes are the same, and those of the mix-up are not."""
    arm = load_robot(ROBOT)
    joints_deg = np.rad2deg(arm.pose('P1'))
    right = ama.model(ROBOT, 'P1').frequencies_hz
    recording = _recorded(tmp_path / 'there.mcap', arm.pose('P1'))
    for given, serial in ((joints_deg, True), (recording, False), (recording, True)):
        assert ama.model(ROBOT, given, serial=serial).frequencies_hz == pytest.approx(right)
    angles = ','.join(f'{angle:.9g}' for angle in joints_deg)
    printed = json.loads(ama_command('model', ROBOT, '--pose-deg', angles, '--serial', '--json'))
    assert printed['frequencies_hz'][:3] == pytest.approx(right[:3])
    assert printed['serial_pose_deg'] == pytest.approx(joints_deg)
    mixed_up = ama.model(ROBOT, [0, 20, -20, 0, 30, 0]).frequencies_hz
    meant = ama.model(ROBOT, [0, 20, -20, 0, 30, 0], serial=True).frequencies_hz
    assert np.max(np.abs(mixed_up[:6] / meant[:6] - 1)) > 0.02
    start = ama.plan(ROBOT, recording, duration_s=4).plan.start_position
    assert start == pytest.approx(arm.pose('P1'))
    assert not set(arm.axis_names) & set(arm.joint_names)


def test_a_recording_of_no_robot_is_no_pose(tmp_path):
    path = tmp_path / 'array.csv'
    np.savetxt(path, np.random.default_rng(1).normal(size=(50, 2)), '%.6f', ',')
    with pytest.raises((ModelError, RecordingError)):
        ama.model(ROBOT, path)


def test_a_robot_may_be_a_model_of_its_own():
    by_name, by_model = ama.model(ROBOT), ama.model(load_robot(ROBOT), layout=load_layout(ROBOT))
    assert by_name.to_dict() == by_model.to_dict()
    assert ama.model(load_robot(ROBOT)).shapes.shape[0] == 0


def test_a_mode_that_does_not_oscillate_is_noted():
    arm = load_robot(ROBOT)
    heavy = arm.with_parameters({'joints.joint_1.drive.spring.damping': 1e9})
    assert ama.model(arm).notes == ()
    (note,) = ama.model(heavy).notes
    assert note.startswith(f'1 of {arm.n_dof} modes do not oscillate'), note


def test_the_text_of_a_model_names_robot_pose_and_modes():
    found = ama.model(ROBOT, 'P1', max_frequency_hz=20)
    lines = repr(found).splitlines()
    assert lines[0] == f'{ROBOT} at (0, 45, -10, 90, -90, 0) deg: 3 modes up to 20 Hz'
    assert len(lines) == 5


def test_a_plan_is_what_the_command_prints(ama_command, tmp_path):
    made = ama.plan(ROBOT, 'P1', duration_s=10, seed=4, signal='random_pulses')
    printed = ama_command(
        *('plan', ROBOT, '--pose-deg', 'P1', '--duration-s', 10, '--seed', 4, '--json'),
        *('--signal', 'random_pulses', '--rapid', tmp_path / 'command.mod'),
    )
    assert made.to_dict() == json.loads(printed)
    made.save_rapid(tmp_path / 'api.mod')
    assert (tmp_path / 'api.mod').read_bytes() == (tmp_path / 'command.mod').read_bytes()


def test_a_plan_moves_as_its_arrays_say():
    made = ama.plan(ROBOT, duration_s=10)
    assert made.position.shape == made.velocity.shape == (len(made.time_s), 6)
    moved = np.cumsum(made.velocity, axis=0) * made.plan.sample_period_s
    assert made.position - made.position[0] == pytest.approx(moved, abs=5e-4)
    assert made.position[-1] == pytest.approx(made.position[0], abs=1e-9)
    assert 'sliding noise, 10 s' in repr(made) and made.plan_hash[:12] in repr(made)


def test_an_approach_ends_where_the_plan_starts():
    there = ama.plan(ROBOT, 'P1', approach_from='P2')
    assert there.position[-1] == pytest.approx(ama.model(ROBOT, 'P1').q, abs=1e-9)
    assert there.position[0] == pytest.approx(ama.model(ROBOT, 'P2').q, abs=1e-9)
    assert there.columns()['frequency_hz'] == []
    with pytest.raises(SettingsError, match='no spectrum'):
        there.plot_spectrum()


@pytest.mark.slow
def test_an_emulated_plan_shows_the_modes_of_the_model(tmp_path):
    """The plan's own forecast of the standard deviations is a lower bound."""
    made = ama.plan(ROBOT, duration_s=20)
    found = made.emulate(tmp_path / 'emulated.mcap', {'seed': 5}).identify(robot=ROBOT)
    expected = {name: np.array(values) for name, values in made.columns().items()}
    assert len(found) >= 5
    for frequency_hz, std_hz in zip(found.frequencies_hz, found.frequencies_std_hz, strict=True):
        nearest = np.argmin(np.abs(expected['frequency_hz'] - frequency_hz))
        assert abs(expected['frequency_hz'][nearest] - frequency_hz) < 5.0 * std_hz
    with pytest.raises(ModelError, match='name or folder'):
        ama.plan(load_robot(ROBOT), duration_s=10).emulate(tmp_path / 'none.mcap')


@pytest.mark.parametrize(
    ('ask', 'kind', 'words'),
    [
        (lambda: ama.model('no_such_arm'), ModelError, 'unknown robot'),
        (lambda: ama.model(ROBOT, 'P99'), ModelError, 'neither a named pose, nor angles'),
        (lambda: ama.model(ROBOT, [1.0, 2.0]), ModelError, 'wrong number of angles'),
        (lambda: ama.model(ROBOT, 7), ModelError, 'neither a named pose, nor angles'),
        (lambda: ama.model(ROBOT, max_frequency_hz=-1), SettingsError, 'max_frequency_hz'),
        (lambda: ama.model(ROBOT, step_deg=90), SettingsError, 'step_deg'),
        (lambda: ama.plan(ROBOT, durations_s=10), SettingsError, 'expected duration_s'),
        (lambda: ama.plan(ROBOT, duration_s='ten'), SettingsError, 'duration_s'),
        (lambda: ama.plan(ROBOT, frequency_tolerance=1e-9), PlanError, 'plan|range|tolerance'),
        (lambda: ama.gap('/no/such/folder', ROBOT), SettingsError, 'not a folder'),
    ],
)
def test_what_is_wrong_is_one_line(ask, kind, words):
    with pytest.raises(kind, match=words) as caught:
        ask()
    assert '\n' not in str(caught.value)


@pytest.mark.usefixtures('no_window')
def test_pictures_of_models_and_plans():
    found, made = ama.model(ROBOT, max_frequency_hz=25), ama.plan(ROBOT, duration_s=10)
    assert len(found.plot_shapes()) == len(found.frequencies_hz)
    turned = made.plot_trajectory().lines[0].get_ydata()
    assert np.abs(turned).max() == pytest.approx(
        np.rad2deg(np.abs(made.position[:, 0] - made.position[0, 0]).max())
    )
    lines = made.plot_spectrum().lines
    assert len(lines) == 6 + len(made.expected_modes)
