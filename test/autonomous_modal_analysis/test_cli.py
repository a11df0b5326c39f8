"""The command line on small inputs."""

import json
import subprocess
import sys

import numpy as np
import pytest
from rich.text import Text
from scipy.signal import lfilter
import typer

from autonomous_modal_analysis.cli import app
from modal_core.numbers.indicators import mac


@pytest.fixture(scope='module')
def two_modes(tmp_path_factory):
    """Write 120 s of a known two-mode system under white noise, and return its truth."""
    rate_hz, seed = 100.0, 11
    rng = np.random.default_rng(seed)
    shapes = np.array([[1.0, 0.6], [0.5, -1.0], [-0.3, 0.4]])
    truth = ((4.0, 0.02), (9.0, 0.015))
    n_samples = 24_000
    response = np.zeros((n_samples, 3))
    for (frequency_hz, damping), shape in zip(truth, shapes.T, strict=True):
        pole = 2 * np.pi * frequency_hz * (-damping + 1j * np.sqrt(1 - damping**2)) / rate_hz
        root = np.exp(pole)
        force = rng.normal(size=n_samples)
        response += np.outer(lfilter([1.0, -1.0], np.poly([root, root.conj()]).real, force), shape)
    response += 0.02 * response.std() * rng.normal(size=response.shape)
    path = tmp_path_factory.mktemp('array') / 'beam.npy'
    np.save(path, response)
    return path, truth, shapes, seed


@pytest.mark.slow
def test_verbose_says_why_poles_were_turned_down(ama, two_modes):
    path, *_ = two_modes
    options = ('identify', path, '--sample-rate-hz', 100, '--unit', 'm/s^2', '--json')
    silent, verbose = ama(*options), ama('-v', *options)
    assert silent.returncode == verbose.returncode == 0, verbose.stderr
    assert json.loads(verbose.stdout) == json.loads(silent.stdout)
    reasons = [line for line in verbose.stderr.splitlines() if 'oma_identifier.' in line]
    assert any('Hz: refined' in line for line in reasons), verbose.stderr
    assert 'oma_identifier.' not in silent.stderr


def test_identify_prints_one_object_with_the_modes(ama, two_modes):
    path, truth, shapes, seed = two_modes
    run = ama(
        'identify',
        path,
        '--sample-rate-hz',
        100,
        '--unit',
        'm/s^2',
        '--channels',
        'a,b,c',
        '--json',
    )
    assert run.returncode == 0, run.stderr
    result = json.loads(run.stdout)
    assert {'modes', 'windows', 'channels', 'data_quality', 'settings'} <= result.keys()
    assert [channel['name'] for channel in result['channels']] == ['a', 'b', 'c']
    modes = result['modes']
    assert len(modes) == 2, f'seed {seed}: {modes}'
    for mode, (frequency_hz, damping), shape in zip(modes, truth, shapes.T, strict=True):
        assert abs(mode['frequency_hz'] - frequency_hz) < 4 * mode['frequency_std_hz'], seed
        assert abs(mode['damping_ratio'] - damping) < 4 * mode['damping_ratio_std'], seed
        found = np.array(mode['shape_real']) + 1j * np.array(mode['shape_imag'])
        assert mac(found, shape).item() > 0.99, seed
        assert mode['harmonic'] is False
        assert {'id', 'mpc', 'mpd'} <= mode.keys()
    for window in result['windows']:
        assert window['end_time_s'] > window['start_time_s']


def test_a_sidecar_names_rate_unit_and_channels(ama, two_modes):
    path, *_ = two_modes
    sidecar = path.with_name(path.name + '.yaml')
    sidecar.write_text('sample_rate_hz: 100\nunit: g\nchannels: [n, e, u]\n')
    try:
        run = ama('info', path, '--json')
    finally:
        sidecar.unlink()
    assert run.returncode == 0, run.stderr
    assert json.loads(run.stdout)['channels'] == ['n', 'e', 'u']


def test_out_writes_results_and_report(ama, two_modes, tmp_path):
    path, *_ = two_modes
    run = ama('identify', path, '--sample-rate-hz', 100, '--out', tmp_path / 'results')
    assert run.returncode == 0, run.stderr
    names = {file.name for file in (tmp_path / 'results').iterdir()}
    assert names == {'modes.json', 'modes.csv', 'report.html'}


@pytest.mark.slow
def test_the_same_seed_gives_the_same_plan_and_another_seed_another(ama):
    def plan(seed):
        run = ama('plan', '--duration-s', 10, '--seed', seed, '--json')
        assert run.returncode == 0, run.stderr
        return json.loads(run.stdout)

    first, again, other = plan(3), plan(3), plan(4)
    assert first['plan_hash'] == again['plan_hash'] != other['plan_hash']
    assert first['torque_projection_rank'] == 3
    assert first['peak_point_speed'] <= 0.25
    assert len(first['flange_range_m']) == 3 and 0.0 < max(first['flange_range_m']) < 0.05


@pytest.mark.slow
def test_an_approach_has_a_preview_and_a_hash_of_its_own(ama, tmp_path):
    way = ('plan', '--approach-from', '80,45,-10,90,-90,0', '--pose-deg', 'P1')
    run = ama(*way, '--rapid', tmp_path / 'approach.mod', '--json')
    assert run.returncode == 0, run.stderr
    told = json.loads(run.stdout)
    assert told['signal'] == 'approach' and told['start_pose_deg'][0] == pytest.approx(80.0)
    assert told['peak_point_speed'] <= 0.11
    assert told['plan_hash'] in (tmp_path / 'approach.mod').read_text()
    wrong = ama('plan', '--approach-from', 'P1', '--pose-deg', 'P1')
    assert wrong.returncode == 2 and 'there already' in wrong.stderr


def test_the_model_has_the_published_frequencies(ama):
    run = ama('model', 'irb6660_205_190', '--pose-deg', '0,45,-10,90,-90,0', '--json')
    assert run.returncode == 0, run.stderr
    frequencies_hz = np.array(json.loads(run.stdout)['frequencies_hz'])
    for published_hz in (11.1, 19.4, 29.3, 38.1):
        assert np.min(np.abs(frequencies_hz / published_hz - 1.0)) < 0.02


@pytest.mark.parametrize(
    'command',
    [
        'demo',
        'identify',
        'compare',
        'info',
        'replay',
        'plan',
        'model',
        'up',
        'watch',
        'campaign',
        'gap',
        '',
    ],
)
def test_every_command_explains_itself(ama, command):
    run = ama(*([command] if command else []), '--help')
    assert run.returncode == 0
    assert 'Usage' in run.stdout


def test_the_help_waits_for_no_numerical_library():
    show = "import sys; sys.argv = ['ama', '--help']\n"
    show += 'from autonomous_modal_analysis.__main__ import main\n'
    show += 'try:\n    main()\nexcept SystemExit:\n    print(*sys.modules, file=sys.stderr)\n'
    shown = subprocess.run([sys.executable, '-c', show], capture_output=True, text=True)
    assert 'natural frequencies' in shown.stdout
    loaded = set(shown.stderr.split())
    assert 'autonomous_modal_analysis.commands.identify' in loaded
    assert not loaded & {'numpy', 'scipy', 'rosbags', 'jinja2', 'rclpy'}


def _helps(command, name='ama'):
    yield name, command.help or ''
    yield from (
        (f'{name} {each.name}', getattr(each, 'help', '') or '') for each in command.params
    )
    for each, sub in getattr(command, 'commands', {}).items():
        yield from _helps(sub, f'{name} {each}')


def test_units_in_brackets_are_shown_in_the_help(ama):
    """What begins with a small letter in brackets is markup to the renderer, and would be gone."""
    words = ama('info', '--help').stdout.replace('│', ' ').split()
    assert '[ms],a' in words and '[g];' in words and '[rpm],' in words
    told = dict(_helps(typer.main.get_command(app)))
    shown = {name: Text.from_markup(text).plain for name, text in told.items()}
    lost = {name: told[name] for name in told if shown[name] != told[name].replace('\\[', '[')}
    assert len(told) > 300 and not lost


def test_two_readings_of_a_wrong_pose(ama):
    run = ama('model', 'irb6660_205_190', '--pose-deg', '0,45')
    assert run.returncode == 2
    assert 'found 2, expected 6' in run.stderr
    assert 'Traceback' not in run.stderr


def test_a_folder_that_cannot_be_written_is_named_before_the_work(ama, tmp_path):
    """The recording is none: reading it would fail with another error."""
    (tmp_path / 'a.mcap').write_bytes(b'not a recording')
    (tmp_path / 'out').write_text('a file')
    options = ('--model', 'irb6660_205_190', '--out', tmp_path / 'out')
    run = ama('gap', tmp_path, *options)
    assert run.returncode == 2
    assert 'out' in run.stderr and 'File exists' in run.stderr
    assert 'Traceback' not in run.stderr


@pytest.mark.parametrize(
    'options',
    [(), ('--remap', '/imu:=/imu2', '--rate', '2')],
    ids=['plain', 'all kinds of options'],
)
def test_replay_takes_its_options(ama, options):
    pytest.importorskip('rclpy')
    ended = ama('replay', 'not_there.mcap', *options)
    assert ended.returncode == 2, ended.stderr
    assert len(ended.stderr.strip().splitlines()) == 1, ended.stderr
    assert 'not_there.mcap' in ended.stderr
