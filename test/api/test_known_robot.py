"""A recording of a known robot is drawn on it: it carries the robot, or its plan names it."""

import json
import sys

import pytest

import autonomous_modal_analysis as ama
from autonomous_modal_analysis import cli
from autonomous_modal_analysis.identified.known_robot import layout_of, robot_of
from modal_core.files.version import software
from modal_recordings import open_recording, RecordingWriter

PLAN = '/excitation_planner/excitation_plan'


@pytest.fixture(scope='module')
def path(tmp_path_factory):
    """Return a recording of the emulated arm, 10 s, seed 1, with the plan it was made by."""
    file = tmp_path_factory.mktemp('arm') / 'arm.mcap'
    ama.plan('irb6660_205_190', 'P1', duration_s=10.0).emulate(file)
    return file


def points(recording, folder):
    """Return how many points the mode shapes of the report are drawn with."""
    recording.identify(window_s=10.0, max_order=40).save(folder)
    page = (folder / 'report.html').read_text()
    data = json.loads(page.split('id="report-data">')[1].split('</script>')[0])
    return len(((data.get('mode_shapes') or {}).get('geometry') or {}).get('points_m', ()))


def carried(path):
    return {each.name: each.data for each in open_recording(path).attachments()}


def without_plan(path, target, files=None):
    writer = RecordingWriter(target, attached=files)
    recording = open_recording(path)
    topics = frozenset(entry.name for entry in recording.entries) - {PLAN}
    for message in recording.file.messages(topics):
        writer.write(message.topic, message.message_type, message.log_time_ns, message.data)
    return writer.close()


def test_a_recording_is_drawn_on_the_robot_it_names(path, tmp_path):
    # Of the arm's skeleton and its fourteen sensors.
    assert points(ama.open(path), tmp_path) > 14


def test_one_that_names_no_robot_is_not(path, tmp_path):
    other = without_plan(path, tmp_path / 'other.mcap')
    assert points(ama.open(other), tmp_path / 'results') == 0


@pytest.mark.slow
def test_one_that_carries_its_robot_is_drawn_on_it(path, tmp_path):
    """The robot is in no folder here: another name, and a plan that names none."""
    files = carried(path)
    files['model.yaml'] = files['model.yaml'].replace(b'irb6660_205_190', b'arm_of_my_own')
    other = without_plan(path, tmp_path / 'other.mcap', files)
    assert robot_of(open_recording(other)).robot_name == 'arm_of_my_own'
    assert points(ama.open(other), tmp_path / 'results') > 14


@pytest.mark.parametrize(
    ('name', 'content'),
    [('robot.urdf', b'<robot><link/></robot>'), ('model.yaml', b'joints: 3'), ('model.yaml', b'')],
)
def test_a_robot_that_is_none_is_said_and_the_name_holds(path, tmp_path, caplog, name, content):
    files = {**carried(path), name: content}
    target = tmp_path / 'other.mcap'
    with RecordingWriter(target, attached=files) as writer:
        for message in open_recording(path).file.messages(frozenset([PLAN])):
            writer.write(message.topic, message.message_type, message.log_time_ns, message.data)
    found = robot_of(open_recording(target, to_look=True))
    assert found.robot_name == 'irb6660_205_190'
    assert 'the robot in the recording is not used' in caplog.text


def test_sensors_are_those_it_carries(path, tmp_path):
    """A layout of the recording counts before one of that name here."""
    names = ama.open(path).channel_names
    files = carried(path)
    moved = files['sensors.yaml'].replace(b'position_m: [', b'position_m: [1', 1)
    assert moved != files['sensors.yaml']
    other = open_recording(
        without_plan(path, tmp_path / 'a.mcap', {**files, 'sensors.yaml': moved})
    )
    found = layout_of(other, 'irb6660_205_190', names)
    shipped = layout_of(
        open_recording(without_plan(path, tmp_path / 'b.mcap')), 'irb6660_205_190', names
    )
    assert [sensor.name for sensor in found] == [sensor.name for sensor in shipped]
    assert found.sensors[0].position_m != shipped.sensors[0].position_m
    assert found.sensors[1:] == shipped.sensors[1:]


def test_info_lists_and_gives_out_what_it_carries(path, tmp_path, monkeypatch, capsys):
    def run(*arguments):
        monkeypatch.setattr(sys, 'argv', ['ama', *map(str, arguments)])
        with pytest.raises(SystemExit) as ended:
            cli.main()
        return ended.value.code, capsys.readouterr()

    code, said = run('info', path, '--attachments', tmp_path / 'arm')
    assert not code, said.err
    for name, content in carried(path).items():
        assert f'carries: {name}, {len(content)} bytes' in said.out
        assert (tmp_path / 'arm' / name).read_bytes() == content
    assert f'written by: {software()}' in said.out
    code, said = run('info', path, '--json')
    printed = json.loads(said.out)
    assert printed['software'] == software()
    assert [each['name'] for each in printed['attachments']] == list(carried(path))
    code, said = run('info', path, '--attachments', tmp_path / 'arm')
    assert code == 2 and 'is there already' in said.err
    # What was given out is a robot.
    code, said = run('model', tmp_path / 'arm', '--pose-deg', 'P1', '--json')
    assert not code, said.err
    assert json.loads(said.out) == ama.model('irb6660_205_190', 'P1').to_dict()
