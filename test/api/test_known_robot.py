"""A recording of a known robot is drawn on it: the plan in it names the robot."""

import json

import pytest

import autonomous_modal_analysis as ama
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


def without_plan(path, target):
    writer = RecordingWriter(target)
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
