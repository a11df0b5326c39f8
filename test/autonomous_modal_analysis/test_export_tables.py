"""Results in files of other programs: read back, the tables are what was found."""

import json
import math

import numpy as np
import pytest
import pyuff
from scipy.io import loadmat, netcdf_file
from typer.testing import CliRunner

import autonomous_modal_analysis as ama
from autonomous_modal_analysis.cli import app
from autonomous_modal_analysis.export import export_table, Table, TABLE_ENDINGS
from modal_core.errors import SettingsError
from test.autonomous_modal_analysis.test_compare import response
from test.support.exported_rows import number, rows_of

ROBOT = 'irb6660_205_190'
SEED = 3


def run(*arguments):
    return CliRunner().invoke(app, [str(each) for each in arguments])


def columns(n_rows=5):
    """Return a column of each kind; some names and numbers are hard."""
    rng = np.random.default_rng(SEED)
    return {
        'name': ['α, "β"', '', 'c\nd', 'e', 'f'][:n_rows],
        'frequency_hz': [*rng.normal(size=4), math.nan][:n_rows],
        'count': [1, 2**31, 3, 4, 5][:n_rows],
        'sure': [True, False, True, False, False][:n_rows],
        'angle_deg.joint_1': [1e-12, 1e300, -0.0, 2.0, None][:n_rows],
        '1/x': [1.0, 2.0, 3.0, 4.0, 5.0][:n_rows],
    }


def test_a_name_that_is_an_ending_alone_is_one(tmp_path):
    export_table(tmp_path / '.csv', Table.of(columns(), {}))
    (tmp_path / '.csv').rename(tmp_path / 'table.csv')
    assert len(rows_of(tmp_path / 'table.csv')) == 5


@pytest.mark.parametrize('ending', TABLE_ENDINGS)
@pytest.mark.parametrize('n_rows', [5, 1, 0])
def test_every_kind_of_column_comes_back(tmp_path, ending, n_rows):
    print('seed', SEED)
    if ending == '.parquet':
        pytest.importorskip('pyarrow')
    truth, file = columns(n_rows), tmp_path / f'table{ending}'
    export_table(file, Table.of(truth, {'software': 'test', 'recording': 'α'}))
    rows = rows_of(file)
    assert len(rows) == n_rows
    names = [name.replace('/', '_') if ending == '.nc' else name for name in truth]
    for row, values in zip(rows, zip(*truth.values(), strict=True), strict=True):
        assert list(row) == names
        name, frequency, count, sure, *others = row.values()
        assert name == values[0]
        assert number(frequency) == pytest.approx(values[1], rel=1e-15, nan_ok=True)
        assert float(count) == values[2]
        assert str(sure) in (
            (str(values[3]),) if ending in ('.csv', '.parquet') else ('0.0', '1.0')
        )
        wanted = [math.nan if value is None else value for value in values[4:]]
        assert [number(x) for x in others] == pytest.approx(wanted, rel=1e-15, nan_ok=True)


def test_units_and_origin_are_in_the_files_that_have_a_place_for_them(tmp_path):
    about = {'software': 'test 1'}
    for ending in ('.nc', '.mat'):
        export_table(tmp_path / f'a{ending}', Table.of(columns(), about))
    with netcdf_file(tmp_path / 'a.nc', mmap=False) as file:
        assert file.software == b'test 1'
        assert file.variables['frequency_hz'].units == b'Hz'
        assert file.variables['angle_deg.joint_1'].units == b'deg'
        assert file.variables['count'].units == b'1'
    found = loadmat(tmp_path / 'a.mat', simplify_cells=True)
    assert found['about']['software'] == 'test 1'
    assert list(found['column_units']) == ['1', 'Hz', '1', '1', 'deg', '1']
    assert list(found['column_names']) == list(columns())


@pytest.mark.parametrize(
    ('name', 'said'),
    [
        ('a.uff', 'a kind of file that cannot hold this result'),
        ('a.docx', 'unknown kind of file'),
        ('a', 'unknown kind of file'),
    ],
)
def test_a_table_is_no_universal_file(tmp_path, name, said):
    with pytest.raises(SettingsError, match=said) as raised:
        export_table(tmp_path / name, Table.of(columns(), {}))
    assert '.mat, .nc, .parquet, .csv' in str(raised.value)
    assert not list(tmp_path.iterdir())


def test_other_endings_are_refused_before_the_work(tmp_path):
    """By every command, though what it should work on is not even there."""
    none = tmp_path / 'none.npy'
    for command in (
        ('identify', none),
        ('merge', none, none),
        ('impact', none),
        ('model', ROBOT),
        ('map', 'predict', '--map', none, '--pose-deg', 'P1'),
        ('gap', none, '--model', ROBOT),
        ('compare', none, none),
        ('lobes', none),
        ('campaign', '--out', tmp_path / 'out'),
        ('batch', none, '--out', tmp_path / 'out'),
    ):
        found = run(*command, '--export', tmp_path / 'a.docx')
        assert isinstance(found.exception, SettingsError), command
        assert 'unknown kind of file' in str(found.exception), command
    for command in (('gap', none, '--model', ROBOT), ('compare', none, none), ('lobes', none)):
        found = run(*command, '--export', tmp_path / 'a.uff')
        assert 'cannot hold this result' in str(found.exception), command
    assert not list(tmp_path.iterdir())


def test_modes_of_a_model_go_into_all_files(tmp_path):
    files = [tmp_path / f'arm{ending}' for ending in ('.uff', '.mat', '.nc', '.csv')]
    told = run('model', ROBOT, '--pose-deg', 'P1', '--max-frequency-hz', 30,
               *(word for file in files for word in ('--export', file)))  # fmt: skip
    assert told.exit_code == 0, told.exception
    truth = ama.model(ROBOT, 'P1', max_frequency_hz=30)
    for file in files[1:]:
        rows = [] if file.suffix == '.mat' else rows_of(file) if file.suffix == '.csv' else None
        if file.suffix == '.csv':
            assert [float(row['frequency_hz']) for row in rows] == list(truth.frequencies_hz)
    found = loadmat(files[1], simplify_cells=True)
    assert np.array_equal(found['frequency_hz'], truth.frequencies_hz)
    for shape, true in zip(found['shapes'].T, truth.shapes.T, strict=True):
        assert abs(np.vdot(shape, true)) == pytest.approx(
            np.linalg.norm(shape) * np.linalg.norm(true)
        )
    sets = pyuff.UFF(str(files[0])).read_sets()
    modes = [each for each in sets if each['type'] == 55]
    (nodes,) = (each for each in sets if each['type'] == 15)
    assert len(modes) == len(truth.frequencies_hz)
    assert len(nodes['node_nums']) == len(modes[0]['node_nums'])
    assert [each for each in sets if each['type'] == 82]
    omega = 2 * np.pi * truth.frequencies_hz
    assert [abs(mode['eig']) for mode in modes] == pytest.approx(omega, rel=1e-5)


def test_a_robot_without_sensors_has_no_shapes_to_write(tmp_path):
    from structural_model import load_robot

    with pytest.raises(SettingsError, match='no sensors'):
        ama.model(load_robot(ROBOT), 'P1').export(tmp_path / 'a.uff')
    assert not list(tmp_path.iterdir())


def test_modes_that_a_map_predicts_go_into_files(tmp_path):
    from benchmarks.workspace_map.hidden_arms import hidden_arm, known_arm
    from structural_model import load_layout
    from workspace_map import save_map, WorkspaceMap

    arm = known_arm()
    near = hidden_arm(101).measured(arm.model.pose('P1'))
    file = tmp_path / 'map.json'
    save_map(file, WorkspaceMap(arm, 60.0, (near,) * 2), load_layout(ROBOT))
    command = ('map', 'predict', '--map', file, '--pose-deg', 'P1')
    names = ('m.uff', 'm.mat')
    told = run(*command, '--json', *(w for n in names for w in ('--export', tmp_path / n)))
    assert told.exit_code == 0, told.exception
    modes = json.loads(told.stdout)['modes']
    found = loadmat(tmp_path / 'm.mat', simplify_cells=True)
    for name in ('frequency_hz', 'frequency_std_hz', 'damping_ratio', 'damping_ratio_std'):
        assert list(found[name]) == [mode[name] for mode in modes]
    assert found['shapes'].shape == (len(found['channels']), len(modes))
    assert np.abs(found['shapes']).max(axis=0) == pytest.approx(1.0)
    sets = pyuff.UFF(str(tmp_path / 'm.uff')).read_sets()
    assert len([each for each in sets if each['type'] == 55]) == len(modes)


@pytest.mark.slow
def test_lobes_go_into_tables(tmp_path):
    from test.autonomous_modal_analysis.test_lobes import CUT, WECK

    tool, cut = tmp_path / 'tool.yaml', tmp_path / 'cut.yaml'
    tool.write_text(WECK)
    cut.write_text(CUT)
    files = [tmp_path / f'lobes{ending}' for ending in ('.csv', '.mat', '.nc')]
    told = run('lobes', tool, '--cut', cut, '--json', '--out', tmp_path / 'out',
               *(word for file in files for word in ('--export', file)))  # fmt: skip
    assert told.exit_code == 0, told.exception
    (chart,) = json.loads(told.stdout)['charts']
    for file in (*files, tmp_path / 'out' / 'lobes.csv'):
        rows = rows_of(file)
        for name in ('speed_rpm', 'limit_m', 'mean_limit_m', 'safe_depth_m', 'chatter_hz'):
            wanted = [math.nan if value is None else value for value in chart[name]]
            assert [number(row[name]) for row in rows] == pytest.approx(wanted, nan_ok=True)
    assert files[0].read_bytes() == (tmp_path / 'out' / 'lobes.csv').read_bytes()


def test_what_changed_goes_into_tables(tmp_path):
    """The upper mode is 4 % lower at work; seed of the responses as in the test of the command."""
    for seed, (name, upper_hz) in enumerate((('rest', 9.0), ('work', 8.64))):
        np.save(tmp_path / f'{name}.npy', response((4.0, upper_hz), seed))
        (tmp_path / f'{name}.npy.yaml').write_text('sample_rate_hz: 100\nunit: m/s^2\n')
    files = [tmp_path / f'changes{ending}' for ending in ('.csv', '.mat', '.nc')]
    told = run('compare', tmp_path / 'rest.npy', tmp_path / 'work.npy', '--load-kg', '0,20',
               '--json', *(word for file in files for word in ('--export', file)))  # fmt: skip
    assert told.exit_code == 0, told.exception
    changes = json.loads(told.stdout)['changes']
    for file in files:
        rows = rows_of(file)
        assert [row['recording'] for row in rows] == ['rest.npy', 'work.npy'] * 2
        assert [int(float(row['mode'])) for row in rows] == [1, 1, 2, 2]
        assert [float(row['load_kg']) for row in rows] == [0.0, 20.0] * 2
        for change, (first, second) in zip(changes, (rows[:2], rows[2:]), strict=True):
            assert float(first['frequency_hz']) == change['first']['frequency_hz']
            assert float(second['frequency_hz']) == change['second']['frequency_hz']
            assert float(second['frequency_change']) == change['frequency_change']
            assert float(second['mac']) == change['mac']
            assert math.isnan(number(first['frequency_change']))
        assert str(rows[3]['is_significant']) in ('True', '1.0')


def test_recordings_of_a_campaign_go_into_a_table(tmp_path):
    file = tmp_path / 'campaign.csv'
    told = run('campaign', '--out', tmp_path / 'out', '--pose-deg', 'P1', '--dry-run',
               '--duration-s', 6, '--export', file)  # fmt: skip
    assert told.exit_code == 0, told.exception
    loud, soft = rows_of(file)
    assert (loud['file'], soft['file']) == ('pose_01_level_1.mcap', 'pose_01_level_0.35.mcap')
    assert float(soft['acceleration_rms_rad_s2']) == pytest.approx(
        0.35 * float(loud['acceleration_rms_rad_s2'])
    )
    assert float(loud['duration_s']) == 6.0
    angles = [float(value) for name, value in loud.items() if name.startswith('axis_deg.')]
    assert angles == pytest.approx(ama.model(ROBOT, 'P1').pose_deg)


def test_where_there_is_no_table_it_is_said(tmp_path):
    (tmp_path / 'campaign').mkdir()
    found = run('campaign', '--next', tmp_path / 'campaign', '--export', tmp_path / 'a.csv')
    assert 'nothing is recorded' in str(found.exception)
    found = run('gap', tmp_path / 'campaign', '--model', ROBOT, '--quick',
                '--export', tmp_path / 'a.csv')  # fmt: skip
    assert 'no table of the gap by place' in str(found.exception)
