"""`ama compare` of many recordings: modes over joint speed, load and pose in one table."""

import json
import math

import numpy as np
import pytest

from autonomous_modal_analysis.compared.mode_courses import mode_courses
from autonomous_modal_analysis.compared.operating_state import (
    differing,
    LOAD,
    NUMBER,
    OperatingState,
    SPEED,
    state_of,
    UNKNOWN_STATE,
)
from autonomous_modal_analysis.identified.results import (
    Identification,
    IdentifiedWindow,
    write_json,
)
from modal_core.measurements import JointSamples
from modal_core.mode import Mode, ModeSet
from modal_core.window import Pose
from modal_reports import over_state, StatePoint
from oma_identifier.compare import compare_modes
from oma_identifier.intake.joint_track import pose_of

JOINTS, CHANNELS = ('joint_1', 'joint_2'), ('a', 'b', 'c')
SPEEDS_DEG_S, ANGLES_DEG = (0.0, 15.0, 40.0), ((0.0, 20.0), (0.0, 20.0), (0.0, 35.0))


def modes_at(speed_deg_s, n_modes=2):
    """Return modes of which the upper falls by 0.1 % for each degree a second."""
    shapes = np.eye(3, dtype=complex)
    hz = (8.0, 19.0 * (1.0 - 1e-3 * speed_deg_s))
    modes = [
        Mode(hz[k], 0.02 + 1e-4 * speed_deg_s, shapes[:, k], 0.01 * (k + 1), 0.001, id=k + 1)
        for k in range(n_modes)
    ]
    return ModeSet(tuple(modes), CHANNELS)


def pose_at(speed_deg_s, angles_deg):
    angles = np.deg2rad(angles_deg)
    return Pose(JOINTS, angles, np.zeros(2), np.deg2rad([speed_deg_s, 0.01]))


@pytest.fixture(scope='module')
def kept(tmp_path_factory):
    """Write the results of a robot that stands, and of two that run."""
    folder = tmp_path_factory.mktemp('kept')
    for name, speed, angles in zip(
        ('standing', 'slow', 'running_fast_in_the_corner'), SPEEDS_DEG_S, ANGLES_DEG, strict=True
    ):
        modes = modes_at(speed)
        window = IdentifiedWindow(0, 0, 10**9, modes, pose=pose_at(speed, angles))
        (folder / name).mkdir()
        write_json(folder / name / 'modes.json', Identification(modes, (window,)))
    return [folder / name for name in ('standing', 'slow', 'running_fast_in_the_corner')]


def test_one_table_of_80_columns_holds_all_recordings(ama, kept):
    run = ama('compare', *kept, '--load-kg', '0,0,5')
    assert run.returncode == 0, run.stderr
    lines = run.stdout.splitlines()
    assert 'slow: pose 0, 20°, joint_1 at 15 °/s, load 0 kg' in lines
    first = next(i for i, line in enumerate(lines) if 'modes through all recordings' in line)
    table = lines[first : first + 10]
    assert all(len(line) <= 80 for line in table), table
    rows = [line for line in table if line.strip().startswith(('standing', 'slow', 'running'))]
    assert len(rows) == 6
    for row, speed in zip(rows[3:], SPEEDS_DEG_S, strict=True):
        assert f'{19.0 * (1.0 - 1e-3 * speed):.2f}' in row
        assert f'{speed:.3g}' in row
    assert '-4.00' in rows[5].replace('−', '-') and rows[5].rstrip().endswith('*')


def test_states_and_courses_are_in_json_and_in_the_report(ama, kept, tmp_path):
    run = ama('compare', *kept, '--json', '--out', tmp_path)
    assert run.returncode == 0, run.stderr
    found = json.loads(run.stdout)
    assert [each['joint_speeds_deg_s'][0] for each in found['recordings']] == pytest.approx(
        SPEEDS_DEG_S
    )
    upper = [point['frequency_hz'] for point in found['courses'][1]]
    np.testing.assert_allclose(upper, [19.0, 18.715, 18.24])
    page = (tmp_path / 'comparison.html').read_text()
    assert 'Modes through all recordings' in page
    # Two modes, over speed and angle, frequency and damping.
    assert page.count('aria-label="mode of') == 8


def test_one_load_is_stated_for_each_recording(ama, kept):
    run = ama('compare', *kept, '--load-kg', '0,5')
    assert run.returncode == 2 and 'one load for each recording' in run.stderr
    assert len(run.stderr.strip().splitlines()) == 1


def test_what_states_differ_in_is_found_without_being_told():
    states = [
        state_of([pose_at(speed, angles), None])
        for speed, angles in zip(SPEEDS_DEG_S, ANGLES_DEG, strict=True)
    ]
    (name, speeds), (angle, values) = differing(states)
    assert name == SPEED and speeds == pytest.approx(SPEEDS_DEG_S)
    assert angle == 'joint_2 angle [°]' and values == pytest.approx([20.0, 20.0, 35.0])
    loaded = [OperatingState((), np.zeros(0), np.zeros(0), load) for load in (0.0, 5.0)]
    assert differing(loaded) == [(LOAD, [0.0, 5.0])]
    assert differing([UNKNOWN_STATE] * 3) == [(NUMBER, [1.0, 2.0, 3.0])]
    assert state_of([]) is UNKNOWN_STATE and math.isnan(UNKNOWN_STATE.fastest_deg_s)
    # One whose load is not stated: loads cannot be an axis.
    assert differing([*loaded, UNKNOWN_STATE])[0][0] == NUMBER


def test_a_mode_that_a_recording_lacks_is_left_out_of_its_course():
    first = modes_at(0.0)
    found = [compare_modes(first, modes_at(15.0, n_modes=1)), compare_modes(first, modes_at(40.0))]
    lower, upper = mode_courses(first, found)
    assert [point.recording for point in lower] == [0, 1, 2]
    assert [point.recording for point in upper] == [0, 2]
    assert upper[0].change is None and upper[1].change.frequency_change == pytest.approx(-0.04)


@pytest.mark.parametrize('noise_rad', [0.0, 1e-5])
def test_the_speed_of_a_window_is_that_of_its_joints(noise_rad):
    """A joint that swings as 0.1 sin 2πt goes 0.4 rad in a second, seen ten times a second."""
    time = np.arange(0.0, 20.0, 0.004)
    rng = np.random.default_rng(3)
    angles = np.column_stack([0.1 * np.sin(2.0 * np.pi * time), 0.3 * time, 0.0 * time])
    angles += noise_rad * rng.standard_normal(angles.shape)
    stamps = np.round(time * 1e9).astype(np.int64)
    pose = pose_of(JointSamples(stamps, ('a', 'b', 'c'), angles, angles * 0.0))
    np.testing.assert_allclose(pose.mean_speed[1], 0.3, rtol=1e-3)
    # Of four ways to the peak per turn, as far as samples a tenth of a turn apart see it.
    seen = 4.0 * 0.1 * np.sin(2.0 * np.pi * 0.2)
    assert pose.mean_speed[0] == pytest.approx(seen, rel=0.01)
    assert pose.mean_speed[2] < 2e-4


def test_a_picture_holds_bars_and_single_values():
    points = [StatePoint(0.0, 8.0, 0.1, 'one'), StatePoint(5.0, 7.5, math.nan, '<two>')]
    drawn = str(over_state('mode', ('speed', 'Hz'), points))
    assert drawn.count('<circle') == 2 and '&lt;two&gt;' in drawn and 'nan' not in drawn
    assert 'nan' not in str(over_state('mode', ('speed', 'Hz'), points[1:]))


def test_what_is_counted_has_whole_ticks():
    points = [StatePoint(number, 10.0 - number, 0.1, '') for number in (1, 2)]
    drawn = str(over_state('mode', ('recording', 'Hz'), points))
    assert '>1</text>' in drawn and '>2</text>' in drawn and '>1.2</text>' not in drawn
