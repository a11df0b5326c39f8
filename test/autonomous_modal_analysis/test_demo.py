"""The demo as a user runs it: real processes, real topics, a real recording."""

import csv
import json

import numpy as np
import pytest

from modal_recordings import open_recording

pytestmark = [pytest.mark.node, pytest.mark.slow]


def test_every_mode_in_the_excited_band_is_found(finished_demo):
    assert finished_demo.status == 0, finished_demo.output
    assert 'every mode in the excited band was found' in finished_demo.output


def test_it_leaves_recording_results_and_report(finished_demo):
    for name in ('demo.mcap', 'egm.mcap', 'modes.json', 'modes.csv', 'report.html'):
        assert (finished_demo.folder / name).stat().st_size > 1000, name
    assert not list(finished_demo.folder.glob('.*part'))


def test_at_least_three_windows_were_identified(finished_demo):
    result = json.loads((finished_demo.folder / 'modes.json').read_text())
    assert len([window for window in result['windows'] if window['modes']]) >= 3
    assert result['band']['high_from'] == 'plan'
    rows = list(csv.DictReader((finished_demo.folder / 'modes.csv').open()))
    assert len({row['window'] for row in rows}) >= 3


def test_the_recording_holds_what_was_sent_without_loss(finished_demo):
    recording = open_recording(finished_demo.folder / 'demo.mcap')
    info = recording.info()
    carried = [each.name for each in recording.attachments() if not each.problem]
    assert carried == ['robot.urdf', 'model.yaml', 'sensors.yaml', 'software.txt']
    topics = {topic.name: topic for topic in info.topics}
    blocks = topics['/acceleration_block']
    assert not info.damage
    assert blocks.n_gaps == 0
    assert len(blocks.channels) == 42
    assert topics['/joint_states'].n_samples > 200 * 40


def test_the_arm_moved_only_a_little_and_came_from_its_pose(finished_demo):
    recording = open_recording(finished_demo.folder / 'demo.mcap', topics=['/joint_states'])
    angles = np.vstack([joints.position for joints in recording.measurements()])
    # Sweeps of a degree or so to both sides: what is less leaves gears stuck.
    assert np.all(np.ptp(angles, axis=0) < np.deg2rad(6.0))
    assert np.all(np.ptp(angles, axis=0) > np.deg2rad(0.5))


def test_the_report_names_what_was_found(finished_demo):
    page = (finished_demo.folder / 'report.html').read_text()
    assert 'true modes found' in page


def test_with_the_robot_named_the_report_draws_its_modes_on_the_arm(ama, finished_demo, tmp_path):
    out = tmp_path / 'results'
    recording = finished_demo.folder / 'demo.mcap'
    run = ama('identify', recording, '--window-s', 24, '--robot', 'irb6660_205_190', '--out', out)
    assert run.returncode == 0, run.stderr
    data = (out / 'report.html').read_text().split('id="report-data">')[1].split('</script>')[0]
    shown = json.loads(data)['mode_shapes']
    assert len(shown['geometry']['points_m']) > 14
    for mode in shown['modes']:
        assert len(mode['moved_real']) == len(shown['geometry']['points_m'])
    pose = json.loads((out / 'modes.json').read_text())['windows'][0]['pose']
    assert len(pose['position']) == 6
