"""`ama impact`: taps in files, modes with masses out."""

from dataclasses import replace
import json
import subprocess
import sys

import numpy as np
import pytest
import pyuff
from scipy.io import savemat

import autonomous_modal_analysis as ama
from modal_core.errors import RecordingError
from test.support.hammer_bench import bench, taps

SEED = 43
HEAD = 'time [s],hammer@m3 [N],m1 [m/s^2],m2 [m/s^2],m3 [m/s^2]'


def written(path, record, head=HEAD):
    time = np.arange(len(record.force_n)) / record.rate_hz
    columns = {'time': time, 'hammer': record.force_n}
    columns |= {f'm{n + 1}': row for n, row in enumerate(record.responses.acceleration.T)}
    chosen = [columns[each.split(' ')[0].split('@')[0]] for each in head.split(',')]
    np.savetxt(path, np.column_stack(chosen), '%.8g', ',', header=head, comments='')
    return path


@pytest.fixture(scope='module')
def recorded(tmp_path_factory):
    """Return a file of five taps, the second of which is double."""
    folder = tmp_path_factory.mktemp('taps')
    times = 0.5 + 4.0 * np.arange(5)
    rng = np.random.default_rng(SEED)
    record = taps(bench(), 2, times, rng, noise=0.01, second=[(1, 0.05, 0.4)])
    return record, written(folder / 'tcp.csv', record)


def run(*arguments):
    command = [sys.executable, '-m', 'autonomous_modal_analysis', *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, check=False)


def test_the_command_writes_modes_frfs_and_a_report(recorded, tmp_path):
    _, file = recorded
    out = tmp_path / 'out'
    said = run('impact', file, '--out', out, '--export', tmp_path / 'modes.uff')
    assert said.returncode == 0, said.stderr
    assert 'tap 2 left out: double hit' in said.stdout
    found = json.loads((out / 'modes.json').read_text())
    frequencies = [mode['frequency_hz'] for mode in found['modes']]
    assert frequencies == pytest.approx([4.49854, 10.81339, 16.04881], rel=1e-3)
    masses = [mode['modal_mass_kg'] for mode in found['modes']]
    assert masses == pytest.approx([12.548, 14.147, 14.608], rel=0.01)
    sets = pyuff.UFF(str(out / 'frf.uff'))
    assert list(sets.get_set_types()) == [58.0] * 3
    driving = sets.read_sets(2)
    true = bench().frf(driving['x'])[:, 2, 2]
    used = (driving['x'] > 3.0) & (driving['x'] < 100.0)
    assert np.abs(driving['data'] - true)[used].max() < 0.05 * np.abs(true[used]).max()
    assert {55, 164} <= {
        int(kind) for kind in pyuff.UFF(str(tmp_path / 'modes.uff')).get_set_types()
    }
    page = (out / 'report.html').read_text()
    for words in ('double hit', 'Frequency responses', 'coherence', 'modal mass'.capitalize()):
        assert words in page
    assert len((out / 'modes.csv').read_text().splitlines()) == 4


def test_python_takes_files_and_records_alike(recorded):
    record, file = recorded
    of_file, of_record = ama.impact(file), ama.impact(record)
    assert of_file.frequencies_hz == pytest.approx(of_record.frequencies_hz, rel=1e-6)
    assert of_file.modal_masses_kg == pytest.approx(of_record.modal_masses_kg, rel=1e-4)
    assert '3 modes' in of_file.headline()
    assert of_file.to_dict()['points'][0]['taps'][1]['good'] is False


def test_the_force_is_found_by_its_unit_or_named(recorded, tmp_path):
    record, _ = recorded
    head = 'time [s],hammer,m1 [m/s^2],m2 [m/s^2],m3 [m/s^2]'
    plain = written(tmp_path / 'plain.csv', record, head)
    named = ama.impact(plain, force='hammer', at='m3')
    assert named.modal_masses_kg == pytest.approx([12.548, 14.147, 14.608], rel=0.01)
    assert np.isnan(named.modal_masses_std_kg).all()
    assert any('no unit of the force' in remark for remark in named.remarks)
    blind = ama.impact(plain)
    assert np.isnan(blind.modal_masses_kg).all()


@pytest.mark.parametrize(('unit', 'newtons'), [('kN', 1e3), ('lbf', 4.4482216), ('kgf', 9.80665)])
def test_forces_in_other_units_give_the_same_masses(recorded, tmp_path, unit, newtons):
    record, _ = recorded
    other = replace(record, force_n=record.force_n / newtons)
    file = written(tmp_path / 'unit.csv', other, HEAD.replace('[N]', f'[{unit}]'))
    masses = ama.impact(file).modal_masses_kg
    assert masses == pytest.approx([12.548, 14.147, 14.608], rel=0.01)


def test_masses_in_units_that_nobody_stated_have_no_deviation(recorded, tmp_path):
    record, file = recorded
    head = 'time [s],hammer@m3 [N],m1,m2,m3'
    plain = written(tmp_path / 'plain.csv', record, head)
    test, told = ama.impact(plain), ama.impact(plain, unit='m/s^2')
    assert np.isnan(test.modal_masses_std_kg).all()
    assert any('no unit of the responses is stated (plain)' in each for each in test.remarks)
    for one in (told, ama.impact(file)):
        assert np.isfinite(one.modal_masses_std_kg).all()
        assert not any('no unit' in each for each in one.remarks)


def test_a_force_beside_one_array_of_responses_is_read(recorded, tmp_path):
    record, _ = recorded
    file = tmp_path / 'taps.mat'
    time = np.arange(len(record.force_n)) / record.rate_hz
    arrays = {'time': time, 'hammer': record.force_n, 'm': record.responses.acceleration}
    savemat(file, arrays, oned_as='column')
    masses = ama.impact(file, at='m3', unit='m/s^2').modal_masses_kg
    assert masses == pytest.approx([12.548, 14.147, 14.608], rel=0.01)


@pytest.mark.parametrize(
    ('head', 'options', 'says'),
    [
        ('time [s],m1 [m/s^2],m2 [m/s^2]', (), 'no force channel'),
        ('time [s],hammer [N],m1 [m/s^2]', ('--force', 'tip'), 'no such column'),
        ('time [s],hammer [poundal],m1 [m/s^2]', (), 'unknown unit of a force'),
        ('time [s],hammer [N],m1 [m/s^2]', ('--max-frequency-hz', '1'), 'band too narrow'),
        ('time [s],hammer [N],m1 [m/s^2]', ('--segment-s', '30'), 'too few good taps'),
        ('time [s],hammer [N],m1 [m/s^2]', ('--window-end', '2'), 'out of range'),
        ('time [s],hammer [N],m1 [m/s^2]', ('--at', 'm1', '--at', 'm2'), 'differ in number'),
        ('time [s],hammer [N],m1 [m/m]', (), 'no motion along a line'),
    ],
)
def test_bad_input_gets_one_line(recorded, tmp_path, head, options, says):
    record, _ = recorded
    file = written(tmp_path / 'bad.csv', record, head)
    said = run('impact', file, *options)
    assert said.returncode == 2
    assert says in said.stderr
    assert len(said.stderr.strip().splitlines()) == 1


def test_of_a_tap_nothing_is_filled_in(recorded, tmp_path):
    record, _ = recorded
    for column, name in enumerate(('hammer', 'm1')):
        arrays = {
            'hammer': record.force_n.copy(),
            'm1': record.responses.acceleration[:, 0].copy(),
        }
        arrays[name][1234] = np.nan
        savemat(tmp_path / f'{column}.mat', arrays, oned_as='column')
        with pytest.raises(RecordingError, match=f'row 1235, {name}: a value that is no number'):
            ama.impact(tmp_path / f'{column}.mat', sample_rate_hz=record.rate_hz, unit='m/s^2')


def test_a_recording_of_messages_is_refused_in_one_line(tmp_path):
    said = run('impact', tmp_path / 'x.mcap')
    assert said.returncode == 2
    assert 'force in N' in said.stderr
    assert len(said.stderr.strip().splitlines()) == 1


def test_each_tap_may_have_a_file_or_a_run_in_one(tmp_path):
    """What a trigger cuts out of a recording, 10 s apart, gives what the recording gives."""
    times = 0.5 + 10.0 * np.arange(4)
    record = taps(bench(), 2, times, np.random.default_rng(SEED), noise=0.01, last_s=9.5)
    rows = np.loadtxt(written(tmp_path / 'whole.csv', record), delimiter=',', skiprows=1)
    runs = [rows[first : first + 3072] for first in (5120 * np.arange(4)).tolist()]
    files = []
    for number, run in enumerate(runs):
        run[:, 0] -= run[0, 0] + 0.5
        files.append(tmp_path / f'tap{number}.csv')
        np.savetxt(files[-1], run, '%.8g', ',', header=HEAD, comments='')
    together = tmp_path / 'runs.csv'
    np.savetxt(together, np.concatenate(runs), '%.8g', ',', header=HEAD, comments='')
    apart, one, true = ama.impact(files), ama.impact(together), ama.impact(record)
    assert apart.frequencies_hz == pytest.approx(one.frequencies_hz, rel=1e-5)
    assert apart.frequencies_hz == pytest.approx(true.frequencies_hz, rel=1e-3)
    assert apart.modal_masses_kg == pytest.approx(true.modal_masses_kg, rel=0.02)
    assert [tap['recording'] for tap in apart.to_dict()['points'][0]['taps']] == [
        f'tap{n}' for n in range(4)
    ]
    assert len(one.to_dict()['points']) == 1


def test_samples_lost_in_a_tap_take_that_tap_alone(recorded, tmp_path):
    _, whole = recorded
    rows = np.loadtxt(whole, delimiter=',', skiprows=1)
    lost = tmp_path / 'lost.csv'
    np.savetxt(lost, np.delete(rows, slice(5200, 5205), 0), '%.8g', ',', header=HEAD, comments='')
    found = ama.impact(lost)
    taps_found = found.to_dict()['points'][0]['taps']
    assert [bool(tap['good']) for tap in taps_found] == [True, False, False, True, True]
    assert 'record ends' in taps_found[2]['faults']
    assert found.frequencies_hz == pytest.approx([4.49854, 10.81339, 16.04881], rel=1e-3)
