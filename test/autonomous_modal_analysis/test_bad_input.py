"""Bad input on the command line: one line that names it, exit status 2, nothing half written."""

import json
from pathlib import Path
import subprocess
import sys

import numpy as np
import pytest

from autonomous_modal_analysis import cli
from modal_core.measurements import StampedSamples
from modal_recordings import RecordingWriter
from modal_recordings.messages import encode

RATE = ('--sample-rate-hz', '100', '--unit', 'm/s^2')
SEED = 1


@pytest.fixture(scope='module')
def inputs(tmp_path_factory):
    folder = tmp_path_factory.mktemp('inputs')
    noise = np.random.default_rng(SEED).standard_normal((6000, 3))
    np.save(folder / 'good.npy', noise)
    np.save(folder / 'nan.npy', np.full_like(noise, np.nan))
    np.save(folder / 'cube.npy', noise.reshape(10, 200, 9))
    np.save(folder / 'text.npy', np.array([['a', 'b']]))
    good = (folder / 'good.npy').read_bytes()
    (folder / 'cut.npy').write_bytes(good[:5000])
    for name in ('empty.npy', 'empty.mcap', 'empty.csv'):
        (folder / name).write_bytes(b'')
    for name in ('junk.mcap', 'junk.bag', 'junk.db3'):
        (folder / name).write_bytes(b'hello' * 100)
    (folder / 'words.csv').write_text('a,b\n1,2\n3,x\n')
    (folder / 'ragged.csv').write_text('1,2\n3\n')
    (folder / 'link.yaml').write_text('sensors:\n - {name: a, frame_id: link_77}\n')
    (folder / 'other.yaml').write_text('sensors:\n - {name: zz, frame_id: link_1}\n')
    (folder / 'three.yaml').write_text('sensors: 3\n')
    (folder / 'syntax.yaml').write_text('sensors: [\n')
    return folder


def run(arguments, monkeypatch, capsys):
    monkeypatch.setattr(sys, 'argv', ['ama', *arguments])
    with pytest.raises(SystemExit) as ended:
        cli.main()
    return ended.value.code, capsys.readouterr()


def check(code, errors, words):
    assert code == 2, errors
    assert len(errors.strip().splitlines()) == 1, errors
    assert 'Traceback' not in errors
    for word in words:
        assert word in errors, errors


@pytest.mark.parametrize('command', ['identify', 'info'])
@pytest.mark.parametrize(
    ('name', 'words'),
    [
        ('missing.mcap', ('missing.mcap', 'No such file')),
        ('empty.mcap', ('empty.mcap', 'empty')),
        ('junk.mcap', ('junk.mcap', 'MCAP')),
        ('junk.bag', ('junk.bag', 'other first bytes', '#ROSBAG V2.0')),
        ('junk.db3', ('junk.db3', 'other first bytes', 'SQLite')),
        ('empty.npy', ('empty.npy', 'empty')),
        ('empty.csv', ('empty.csv', 'empty')),
        ('cut.npy', ('cut.npy', 'found 203 whole rows', 'expected 6000 rows')),
        ('cube.npy', ('cube.npy', '(10, 200, 9)', 'samples, channels')),
        ('text.npy', ('text.npy', 'numbers')),
        ('words.csv', ('words.csv', 'line 3', 'column 2')),
        ('ragged.csv', ('ragged.csv', 'line 2', 'expected 2')),
    ],
)
def test_files(inputs, monkeypatch, capsys, command, name, words):
    options = RATE if name.endswith(('.npy', '.csv')) else ()
    code, said = run([command, str(inputs / name), *options], monkeypatch, capsys)
    check(code, said.err, words)
    assert not said.out


@pytest.mark.parametrize(
    ('options', 'words'),
    [
        ((), ('good.npy', '--sample-rate-hz')),
        (('--sample-rate-hz', '0'), ('sample_rate_hz', '0.0', '0.001')),
        (('--sample-rate-hz', '-5'), ('sample_rate_hz', '-5', '0.001')),
        (('--sample-rate-hz', 'nan'), ('sample_rate_hz', 'nan', '0.001')),
        (('--sample-rate-hz', '1e-9'), ('sample_rate_hz', '1e-09', '0.001')),
        (('--sample-rate-hz', '100', '--unit', 'furlong'), ('unit', 'furlong', 'm/s^2')),
        ((*RATE, '--channels', 'a,b'), ('channels', 'found 2', 'expected 3')),
        ((*RATE, '--channels', 'a,b,a'), ('channels', 'unique')),
        ((*RATE, '--topic', '/imu'), ('topics', '/imu')),
        ((*RATE, '--window-s', '0'), ('window_s', '0.0', '1 to 86400')),
        ((*RATE, '--window-s', 'nan'), ('window_s', 'nan', '1 to 86400')),
        ((*RATE, '--window-s', '1000'), ('good.npy', '59.99 s', '1000 s', '--window-s')),
        ((*RATE, '--hop-s', '100'), ('hop_s', '100', '60')),
        ((*RATE, '--max-frequency-hz', '80'), ('max_frequency_hz', '80', '<= 50')),
        ((*RATE, '--max-frequency-hz', '-1'), ('max_frequency_hz', '-1', '0.01')),
        ((*RATE, '--min-frequency-hz', '60'), ('good.npy', '60 Hz', 'expected <')),
        ((*RATE, '--layout', 'nowhere.yaml'), ('nowhere.yaml', 'No such file')),
        ((*RATE, '--layout', '{}/three.yaml'), ('three.yaml', 'sensors')),
        ((*RATE, '--layout', '{}/syntax.yaml'), ('syntax.yaml', 'YAML', 'line 2')),
        ((*RATE, '--layout', '{}/other.yaml'), ('good.npy', 'other.yaml', 'zz.x')),
        (
            (*RATE, '--layout', '{}/link.yaml', '--robot', 'irb6660_205_190'),
            ('link.yaml', 'link_77', 'link_1'),
        ),
        ((*RATE, '--robot', 'nope'), ('nope', 'irb6660_205_190')),
    ],
)
def test_options_of_identify(inputs, tmp_path, monkeypatch, capsys, options, words):
    given = [option.format(inputs) for option in options]
    out = tmp_path / 'results'
    arguments = ['identify', str(inputs / 'good.npy'), *given, '--out', str(out)]
    code, said = run(arguments, monkeypatch, capsys)
    check(code, said.err, words)
    assert not said.out
    assert not out.exists() or not list(out.iterdir())


@pytest.mark.parametrize(
    ('options', 'words'),
    [
        (('--namespace', '1 cell'), ('--namespace', '1 cell')),
        (('--parameter', 'port=6511'), ('--parameter', 'port=6511', 'node.name=value')),
        (('--parameter', 'robot_bridge.port'), ('--parameter', 'robot_bridge.port')),
        (('--parameter', 'robot_bridge.port=[1'), ('--parameter', 'robot_bridge.port=[1')),
        (('--parameter', 'bridge.port=6511'), ('bridge', 'robot_bridge')),
    ],
)
def test_options_of_up(monkeypatch, capsys, options, words):
    pytest.importorskip('rclpy')
    pytest.importorskip('oma_msgs')
    code, said = run(['up', *options], monkeypatch, capsys)
    check(code, said.err, words)


def test_the_installed_command_does_the_same(inputs):
    ama = Path(sys.executable).with_name('ama')
    done = subprocess.run(
        [ama, 'identify', inputs / 'nan.npy', *RATE, '--json'],
        capture_output=True,
        text=True,
        check=False,
    )
    check(done.returncode, done.stderr, ('nan.npy', 'values that are not numbers in ch1'))
    assert not done.stdout


@pytest.mark.parametrize('share', [1.0, 0.7])
def test_the_json_says_what_of_the_recording_was_lost(tmp_path, monkeypatch, capsys, share):
    path = tmp_path / 'arm.mcap'
    stamps = np.arange(6000, dtype=np.int64) * 10_000_000
    noise = np.random.default_rng(SEED).standard_normal((6000, 3))
    with RecordingWriter(path) as writer:
        for m in encode(StampedSamples('/imu', 'link_1', stamps, noise), '/imu'):
            writer.write(m.topic, m.message_type, m.log_time_ns, m.data)
    whole = path.read_bytes()
    cut = int(share * len(whole))
    path.write_bytes(whole[:cut])
    out = tmp_path / 'results'
    arguments = ['identify', str(path), '--json', '--out', str(out)]
    code, said = run(arguments, monkeypatch, capsys)
    assert code == 0, said.err
    stated = json.loads(said.out)['data_quality']['damage']
    assert json.loads((out / 'modes.json').read_text())['data_quality']['damage'] == stated
    if share == 1.0:
        assert stated == []
        assert 'damaged' not in said.err
        return
    (statement,) = stated
    assert f'file ends at byte {cut} inside a chunk' in statement
    assert [line for line in said.err.splitlines() if line.startswith('damaged')] == [
        f'damaged: {statement}'
    ]


@pytest.mark.parametrize(
    ('options', 'words'),
    [
        (('--robot', 'nope'), ('nope', 'generic_arm_6')),
        (('--pose', 'Q'), ('Q', 'P1, P2, P3')),
        (('--robot', 'generic_arm_6', '--pose', 'P1'), ('P1', 'home, ready')),
    ],
)
def test_the_demo_names_robots_and_poses_it_can_take(
    tmp_path, monkeypatch, capsys, options, words
):
    code, said = run(['demo', *options, '--out', str(tmp_path / 'out')], monkeypatch, capsys)
    check(code, said.err, words)
    assert not (tmp_path / 'out').exists()
