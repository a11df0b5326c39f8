"""`ama compare`: a change is told from scatter."""

import json
import sys

import numpy as np
import pytest
from scipy.signal import lfilter

from autonomous_modal_analysis import cli
from autonomous_modal_analysis.report import ComparedState, headline, write_comparison
from modal_core.errors import LayoutError
from modal_core.mode import Mode, ModeSet
from oma_identifier.compare import compare_modes

RATE_HZ, SEED = 100.0, 23
SHAPES = np.array([[1.0, 0.6], [0.5, -1.0], [-0.3, 0.4]])


def response(frequencies_hz, seed):
    """Return 200 s of two modes of 2 % damping under white noise."""
    rng = np.random.default_rng([SEED, seed])
    total = np.zeros((20_000, 3))
    for frequency_hz, shape in zip(frequencies_hz, SHAPES.T, strict=True):
        root = np.exp(2 * np.pi * frequency_hz * (-0.02 + 1j * np.sqrt(1 - 0.0004)) / RATE_HZ)
        force = rng.normal(size=len(total))
        total += np.outer(lfilter([1.0, -1.0], np.poly([root, root.conj()]).real, force), shape)
    return total + 0.02 * total.std() * rng.normal(size=total.shape)


@pytest.fixture(scope='module')
def states(tmp_path_factory):
    """Write the robot at rest, and at work: its upper mode is 4 % lower there."""
    folder = tmp_path_factory.mktemp('states')
    for number, (name, upper_hz) in enumerate((('rest', 9.0), ('work', 8.64))):
        np.save(folder / f'{name}.npy', response((4.0, upper_hz), number))
        (folder / f'{name}.npy.yaml').write_text('sample_rate_hz: 100\nunit: m/s^2\n')
    return folder


def test_the_mode_that_changed_is_told_and_the_other_is_not(ama, states):
    run = ama('compare', states / 'rest.npy', states / 'work.npy', '--json')
    assert run.returncode == 0, run.stderr
    found = json.loads(run.stdout)
    same, lower = found['changes']
    assert not same['significant'], f'seed {SEED}'
    assert lower['significant'] and lower['frequency_surprise'] < -3.0, f'seed {SEED}'
    assert lower['frequency_change'] == pytest.approx(-0.04, abs=0.01), f'seed {SEED}'
    assert lower['mac'] > 0.99
    assert found['only_first'] == found['only_second'] == []


@pytest.mark.slow
def test_kept_results_stand_for_their_recording(ama, states, tmp_path):
    kept = tmp_path / 'rest'
    assert ama('identify', states / 'rest.npy', '--out', kept).returncode == 0
    table = ama('compare', kept, states / 'work.npy')
    assert table.returncode == 0, table.stderr
    assert '1 of 2 modes changed' in table.stdout
    # Of 80 columns nothing is cut off.
    assert '…' not in table.stdout and all(len(line) <= 120 for line in table.stdout.splitlines())
    again = ama('compare', kept / 'modes.json', kept, '--json')
    assert all(change['frequency_change'] == 0.0 for change in json.loads(again.stdout)['changes'])


@pytest.mark.slow
def test_several_are_compared_with_the_first_and_leave_a_report(ama, states, tmp_path):
    kept = tmp_path / 'rest'
    assert ama('identify', states / 'rest.npy', '--out', kept).returncode == 0
    run = ama('compare', kept, kept, states / 'work.npy', '--out', tmp_path / 'out', '--json')
    assert run.stderr.count('the same recording twice') == 1
    assert run.returncode == 0, run.stderr
    same, other = json.loads(run.stdout)['comparisons']
    assert [change['significant'] for change in same['changes']] == [False, False]
    assert [change['significant'] for change in other['changes']] == [False, True]
    page = (tmp_path / 'out' / 'comparison.html').read_text()
    assert '0 of 2 modes changed' in page and '1 of 2 modes changed' in page
    assert page.count('MAC of all modes</summary>') == 2
    assert 'src=' not in page and "default-src 'none'" in page
    # Spectra were kept with the results, and lie over each other.
    assert page.count('data-chart="compared_spectra"') == 2


def test_one_recording_alone_is_nothing_to_compare(ama, states):
    run = ama('compare', states / 'rest.npy')
    assert run.returncode == 2 and 'nothing to compare with' in run.stderr


def test_modes_of_one_recording_alone_stand_aside_and_names_are_only_text(tmp_path):
    def modes(*frequencies_hz):
        shapes = np.eye(3, dtype=complex)
        found = [Mode(hz, 0.01, shapes[:, k], 0.01, 0.001) for k, hz in enumerate(frequencies_hz)]
        return ModeSet(tuple(found), ('a', 'b', 'c'))

    first, second = modes(4.0, 9.0), modes(4.0, 30.0)
    state = ComparedState('<b>second</b>', second, compare_modes(first, second))
    write_comparison(tmp_path / 'c.html', '<i>first</i>', first, [state])
    page = (tmp_path / 'c.html').read_text()
    assert 'first alone' in page and 'second alone' in page
    assert '<b>second' not in page and '<i>first' not in page


def test_records_that_share_no_mode_are_told_so():
    mode = Mode(4.0, 0.01, np.ones(2, dtype=complex), 0.01, 0.001)
    some, none = ModeSet((mode,), ('a', 'b')), ModeSet((), ('a', 'b'))
    for pair in ((some, none), (none, some), (none, none)):
        assert headline(compare_modes(*pair)) == 'no mode is in both'


def test_modes_without_a_common_channel_are_not_compared_and_by_one_without_a_mac():
    def modes(*names):
        found = [Mode(hz, 0.01, np.ones(2, dtype=complex), 0.01, 0.001) for hz in (4.0, 9.0)]
        return ModeSet(tuple(found), names)

    with pytest.raises(LayoutError, match='share no channel'):
        compare_modes(modes('a', 'b'), modes('c', 'd'))
    changes = compare_modes(modes('a', 'b'), modes('b', 'c')).changes
    assert len(changes) == 2 and all(np.isnan(change.mac) for change in changes)
    assert not any(change.is_shape_changed for change in changes)


@pytest.mark.parametrize(
    ('text', 'words'),
    [
        (None, ('cannot be read', 'No such file')),
        ('{', ('not the results', 'JSON')),
        ('{"modes": []}', ('not the results', 'shape_channels')),
        ('[1]', ('not the results', 'ama identify')),
    ],
)
def test_what_are_no_results_is_named(states, tmp_path, monkeypatch, capsys, text, words):
    path = tmp_path / 'other.json'
    if text is not None:
        path.write_text(text)
    monkeypatch.setattr(sys, 'argv', ['ama', 'compare', str(path), str(states / 'work.npy')])
    with pytest.raises(SystemExit) as ended:
        cli.main()
    said = capsys.readouterr().err
    assert ended.value.code == 2
    assert len(said.strip().splitlines()) == 1
    for word in ('other.json', *words):
        assert word in said


@pytest.fixture(scope='module')
def levels(tmp_path_factory):
    """Write the same linear structure at three levels, each twice the one before."""
    folder = tmp_path_factory.mktemp('levels')
    for number, level in enumerate((1.0, 2.0, 4.0)):
        np.save(folder / f'{level:.0f}.npy', level * response((4.0, 9.0), 10 + number))
        (folder / f'{level:.0f}.npy.yaml').write_text('sample_rate_hz: 100\nunit: m/s^2\n')
    return folder


@pytest.mark.slow
def test_levels_tell_that_a_linear_structure_is_one(ama, levels):
    run = ama('compare', *sorted(levels.glob('*.npy')), '--levels', '--json')
    assert run.returncode == 0, run.stderr
    found = json.loads(run.stdout)['levels']
    assert len(found) == 2
    for each in found:
        law = each['law']
        assert law['stiffness_law'] == law['damping_law'] == 'constant', f'seed {SEED}: {law}'
        assert abs(law['cubic_stiffness']) < 3.5 * law['cubic_stiffness_std']
        moves = [point['displacement_m'] for point in each['points']]
        assert moves[2] / moves[0] == pytest.approx(4.0, rel=0.3)
    table = ama('compare', *sorted(levels.glob('*.npy')), '--levels').stdout
    assert 'over the level of their motion' in table
    assert all(len(line) <= 120 for line in table.splitlines())


@pytest.mark.parametrize('given', ['few', 'kept'])
@pytest.mark.slow
def test_what_tells_no_law_is_refused_in_one_line(ama, levels, tmp_path, given):
    files = sorted(levels.glob('*.npy'))
    if given == 'kept':
        assert ama('identify', files[0], '--out', tmp_path / 'kept').returncode == 0
        run = ama('compare', tmp_path / 'kept', *files[1:], '--levels')
    else:
        run = ama('compare', *files[:2], '--levels')
    assert run.returncode == 2
    assert len(run.stderr.strip().splitlines()) == 1 and '--levels' in run.stderr


def test_levels_that_hardly_differ_say_so(ama, levels):
    first = levels / '1.npy'
    run = ama('compare', first, first, first, '--levels')
    assert run.returncode == 0, run.stderr
    assert 'no law, its levels differ by a factor of 1.0' in run.stdout


def test_how_plain_arrays_are_read_is_told_as_to_identify(ama, tmp_path):
    """Seed 31: arrays without a file beside them, in g, of twice the rate that is usual here."""
    for number, name in enumerate(('first', 'second')):
        np.save(tmp_path / f'{name}.npy', response((4.0, 9.0), 31 + number) / 9.80665)
    files = [tmp_path / 'first.npy', tmp_path / 'second.npy']
    told = ('--sample-rate-hz', 100.0, '--unit', 'g', '--channels', 'a,b,c')
    run = ama('compare', *files, *told, '--json')
    assert run.returncode == 0, f'seed 31: {run.stderr}'
    courses = json.loads(run.stdout)['courses']
    found = sorted(course[0]['frequency_hz'] for course in courses)
    assert found == pytest.approx([4.0, 9.0], rel=0.01), f'seed 31: {found}'
