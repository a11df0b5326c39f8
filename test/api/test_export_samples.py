"""Samples for other programs: read back, also by other libraries, they are what was recorded."""

import numpy as np
import pytest
import pyuff
from scipy.io import loadmat

import autonomous_modal_analysis as ama
from modal_core.errors import ModalAnalysisError, SettingsError
from test.api.test_recording import ROWS, write_mcap
from test.support.frame import FLOORS, shaken_frame

RATE_HZ, N_ROWS = 160.0, 900
VALUES = np.round(np.random.default_rng(16).normal(size=(N_ROWS, 3)), 6)


def recorded(folder, names='12:+X [g],12:-Z [mm/s],7:+Y [mm]'):
    rows = '\n'.join(','.join(map(repr, row)) for row in VALUES.tolist())
    (folder / 'arm.csv').write_text(f'{names}\n{rows}\n')
    return ama.open(folder / 'arm.csv', sample_rate_hz=RATE_HZ)


@pytest.mark.parametrize('ending', ['uff', 'unv', 'mat', 'nc', 'csv'])
def test_what_is_written_is_read_back(tmp_path, ending):
    recording = recorded(tmp_path)
    assert recording.export(tmp_path / f'out.{ending}') == ()
    back = ama.open(tmp_path / f'out.{ending}')
    assert np.allclose(back.to_array(), recording.to_array(), rtol=1e-9)
    # Universal files print the time step with six digits.
    assert back.sample_rate_hz == pytest.approx(RATE_HZ, rel=3e-6)
    if ending != 'mat':
        assert back.channel_names == ('12:+X', '12:-Z', '7:+Y')
        assert back.samples.units == ('m/s^2', 'm/s', 'm')


def test_other_libraries_read_what_is_written(tmp_path):
    recording = recorded(tmp_path)
    for ending in ('uff', 'mat'):
        recording.export(tmp_path / f'out.{ending}')
    sets = [
        each for each in pyuff.UFF(str(tmp_path / 'out.uff')).read_sets() if each['type'] == 58
    ]
    assert [(each['rsp_node'], each['rsp_dir']) for each in sets] == [(12, 1), (12, -3), (7, 2)]
    assert [each['ordinate_spec_data_type'] for each in sets] == [12, 11, 8]
    assert [each['id1'] for each in sets] == ['12:+X', '12:-Z', '7:+Y']
    assert np.array_equal(np.column_stack([each['data'] for each in sets]), recording.to_array())
    found = loadmat(tmp_path / 'out.mat', simplify_cells=True)
    assert found['fs'] == RATE_HZ and list(found['units']) == ['m/s^2', 'm/s', 'm']
    assert list(found['channels']) == ['12:+X', '12:-Z', '7:+Y']


def test_channels_without_nodes_are_nodes_by_their_order(tmp_path):
    recorded(tmp_path, 'base [g],12:-Z [g],top [g]').export(tmp_path / 'out.uff')
    assert ama.open(tmp_path / 'out.uff').channel_names == ('1:+X', '2:+X', '3:+X')


def test_a_parquet_file_has_a_row_a_sample(tmp_path):
    pandas = pytest.importorskip('pandas')
    pytest.importorskip('pyarrow')
    recorded(tmp_path, 'a,b,c').export(tmp_path / 'out.parquet')
    table = pandas.read_parquet(tmp_path / 'out.parquet')
    assert list(table.columns) == ['time [s]', 'a [m/s^2]', 'b [m/s^2]', 'c [m/s^2]']
    assert np.array_equal(table.to_numpy()[:, 1:], VALUES)


def test_a_channel_that_is_flat_is_left_out_and_named(tmp_path, ama_command):
    values = shaken_frame(2, duration_s=30.0).acceleration
    values[:, 1] = 0.5
    path = write_mcap(tmp_path / 'flat.mcap', values, 100.0)
    assert ama.open(path).export(tmp_path / 'flat.uff') == (FLOORS[1],)
    assert ama.open(tmp_path / 'flat.uff').to_array().shape == (len(values), 2)
    ama_command('info', path, '--export', tmp_path / 'flat.csv')
    assert (tmp_path / 'flat.csv').read_text().startswith('time [s],ground.x [m/s^2],roof.x')


def test_what_cannot_be_written_is_one_line(tmp_path):
    recording = recorded(tmp_path)
    with pytest.raises(SettingsError, match=r'unknown kind of file .found \.xls, expected \.uff'):
        recording.export(tmp_path / 'out.xls')
    lost = write_mcap(
        tmp_path / 'gap.mcap', shaken_frame(2, duration_s=30.0).acceleration, 100.0,
        without=set(range(1000, 2000, ROWS)),
    )  # fmt: skip
    with pytest.raises(ModalAnalysisError, match='one uninterrupted stretch'):
        ama.open(lost).export(tmp_path / 'gap.uff')
    assert not (tmp_path / 'gap.uff').exists()
