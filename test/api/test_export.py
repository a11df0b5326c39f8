"""Modes in files of other programs: read back by other libraries, they are what was identified."""

import csv
import math

import numpy as np
import pytest
import pyuff
from scipy.io import loadmat, netcdf_file

import autonomous_modal_analysis as ama
from modal_core.errors import SettingsError
from test.support.frame import FLOORS, shaken_frame

RATE_HZ = 100.0
LAYOUT = """
sensors:
  - {name: low, frame_id: world, position_m: [0.0, 0.0, 1.0], axes: [x]}
  - {name: middle, frame_id: world, position_m: [0.0, 0.0, 2.0], axes: [x]}
  - {name: top, frame_id: world, position_m: [0.5, 0.0, 3.0], axes: [y]}
"""


def poles(result: ama.ModalResult) -> np.ndarray:
    omega, zeta = 2.0 * np.pi * result.frequencies_hz, result.damping_ratios
    return omega * (-zeta + 1j * np.sqrt(1.0 - zeta**2))


def sets_of(path, kind: int) -> list[dict]:
    found = pyuff.UFF(str(path)).read_sets()
    return [each for each in found if each['type'] == kind]


def test_a_universal_file_has_poles_and_shapes(identified, tmp_path):
    identified.export(tmp_path / 'modes.uff')
    modes = sets_of(tmp_path / 'modes.uff', 55)
    assert [mode['eig'] for mode in modes] == pytest.approx(poles(identified), rel=1e-5)
    for mode, shape in zip(modes, identified.shapes.T, strict=True):
        assert list(mode['node_nums']) == [1, 2, 3]
        assert mode['r1'] == pytest.approx(shape, abs=1e-5)
        assert not mode['r2'].any()
    (units,) = sets_of(tmp_path / 'modes.uff', 164)
    assert units['length'] == 1.0


def test_a_layout_gives_nodes_their_places_and_shapes_their_directions(tmp_path):
    (tmp_path / 'layout.yaml').write_text(LAYOUT)
    frame = shaken_frame(3, duration_s=60.0)
    names = ('low.x', 'middle.x', 'top.y')
    found = ama.identify(
        frame.acceleration, RATE_HZ, channel_names=names, layout=tmp_path / 'layout.yaml'
    )
    found.export(tmp_path / 'modes.unv')
    (nodes,) = sets_of(tmp_path / 'modes.unv', 15)
    assert list(nodes['z']) == [1.0, 2.0, 3.0]
    assert list(nodes['x']) == [0.0, 0.0, 0.5]
    for mode, shape in zip(sets_of(tmp_path / 'modes.unv', 55), found.shapes.T, strict=True):
        moved = np.array([mode['r1'][0], mode['r1'][1], mode['r2'][2]])
        assert abs(np.vdot(moved, shape)) == pytest.approx(
            np.linalg.norm(moved) * np.linalg.norm(shape), rel=1e-4
        )
        assert not mode['r3'].any()


def test_channels_of_a_universal_file_come_back_at_their_nodes(tmp_path):
    """Two directions of node 7, one of them reversed, and node 3."""
    frame = shaken_frame(3, duration_s=60.0)
    found = ama.identify(frame.acceleration, RATE_HZ, channel_names=('7:+X', '7:-Z', '3:+Y'))
    found.export(tmp_path / 'modes.uff')
    for mode, shape in zip(sets_of(tmp_path / 'modes.uff', 55), found.shapes.T, strict=True):
        assert list(mode['node_nums']) == [3, 7]
        back = [mode['r1'][1], -mode['r3'][1], mode['r2'][0]]
        assert back == pytest.approx(shape, abs=1e-5)


def test_a_matlab_file_has_all_numbers(identified, tmp_path):
    identified.export(tmp_path / 'modes.mat')
    found = loadmat(tmp_path / 'modes.mat', simplify_cells=True)
    assert np.array_equal(found['frequency_hz'], identified.frequencies_hz)
    assert np.array_equal(found['damping_ratio_std'], identified.damping_ratios_std)
    assert np.array_equal(found['shapes'], identified.shapes)
    assert list(found['channels']) == list(FLOORS)
    assert 'autonomous_modal_analysis' in found['about']['software']


def test_a_netcdf_file_has_units_and_shapes(identified, tmp_path):
    identified.export(tmp_path / 'modes.nc')
    with netcdf_file(tmp_path / 'modes.nc', mmap=False) as found:
        frequency = found.variables['frequency_hz']
        assert np.array_equal(frequency[:], identified.frequencies_hz)
        assert frequency.units == b'Hz'
        shapes = found.variables['shape_real'][:] + 1j * found.variables['shape_imag'][:]
        assert np.array_equal(shapes, identified.shapes)
        names = [b''.join(row).decode().strip() for row in found.variables['channel_name'][:]]
    assert names == list(FLOORS)


def test_a_table_has_a_row_a_mode(identified, tmp_path):
    identified.export(tmp_path / 'modes.csv')
    with (tmp_path / 'modes.csv').open() as file:
        rows = list(csv.DictReader(file))
    assert [float(row['frequency_hz']) for row in rows] == list(identified.frequencies_hz)
    for row, shape in zip(rows, identified.shapes.T, strict=True):
        assert float(row[f'shape_real.{FLOORS[1]}']) == shape[1].real


def test_a_parquet_file_has_a_row_a_mode(identified, tmp_path):
    pandas = pytest.importorskip('pandas')
    pytest.importorskip('pyarrow')
    identified.export(tmp_path / 'modes.parquet')
    found = pandas.read_parquet(tmp_path / 'modes.parquet')
    assert np.array_equal(found['frequency_hz'], identified.frequencies_hz)


def test_an_ending_that_means_nothing_is_refused(identified, tmp_path):
    with pytest.raises(SettingsError, match='unknown kind of file') as raised:
        identified.export(tmp_path / 'modes.docx')
    assert '.uff' in str(raised.value)
    assert not list(tmp_path.iterdir())


def test_a_number_that_is_not_known_is_empty_in_a_table(tmp_path):
    """Without deviations: method EFDD has none of damping; the cell stays empty, not zero."""
    frame = shaken_frame(3, duration_s=60.0)
    found = ama.identify(frame.acceleration, RATE_HZ, method='efdd')
    found.export(tmp_path / 'modes.csv')
    with (tmp_path / 'modes.csv').open() as file:
        rows = list(csv.DictReader(file))
    for row, mode in zip(rows, found.modes, strict=True):
        assert (row['damping_ratio_std'] == '') == math.isnan(mode.damping_ratio_std)


def test_the_command_exports_as_often_as_it_is_told_to(tmp_path, ama_command):
    np.save(tmp_path / 'frame.npy', shaken_frame(3, duration_s=60.0).acceleration)
    files = [tmp_path / 'out' / 'modes.uff', tmp_path / 'modes.mat']
    options = [word for file in files for word in ('--export', file)]
    ama_command('identify', tmp_path / 'frame.npy', '--sample-rate-hz', 100, *options)
    assert len(sets_of(files[0], 55)) == len(loadmat(files[1])['frequency_hz']) == 3
