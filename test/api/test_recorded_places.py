"""Shapes at the nodes of the universal file that was identified, or where a layout has sensors."""

import json
from pathlib import Path
import re

import numpy as np
import pytest
import pyuff

import autonomous_modal_analysis as ama
from autonomous_modal_analysis.api.recorded_places import recorded_places
from modal_core.errors import RecordingError
from modal_core.mode import ModeSet
from modal_recordings.universal.universal_geometry import read_geometry
from modal_recordings.universal.universal_shapes import read_shapes
from test.support.frame import shaken_frame

RATE_HZ, N_NODES = 100.0, 5
UNITS = {
    **{'type': 164, 'units_code': 5, 'units_description': 'mm', 'temp_mode': 1},
    **{'length': 1000.0, 'force': 1000.0, 'temp': 1.0, 'temp_offset': 273.15},
}
NODES = {
    **{'type': 15, 'node_nums': [70, 10, 20, 30, 71], 'def_cs': [0] * 5, 'disp_cs': [0] * 5},
    **{'color': [1] * 5, 'x': [0.0] * 5, 'y': [0.0] * 5, 'z': [0.0, 1e3, 2e3, 3e3, 4e3]},
}
# The pen is lifted between 30 and 71.
LINES = {**{'type': 82, 'trace_num': 1, 'n_nodes': 7, 'color': 1, 'id': 'mast'},
         'nodes': np.array([70, 10, 20, 30, 0, 30, 71])}  # fmt: skip


def mast(path: Path, *more: dict, motion: np.ndarray | None = None) -> Path:
    """Write nodes 70 to 71 above one another; 10, 20 and 30 are measured along -Y."""
    values = np.zeros((300, 3)) if motion is None else motion
    time_s = np.arange(len(values)) / RATE_HZ
    records = [
        {
            **{'type': 58, 'binary': 1, 'func_type': 1, 'rsp_node': 10 * (n + 1), 'rsp_dir': -2},
            **{'ref_node': 0, 'ref_dir': 0, 'data': column, 'x': time_s, 'num_pts': len(time_s)},
            **{'abscissa_spacing': 1, 'abscissa_inc': 1.0 / RATE_HZ, 'abscissa_min': 0.0},
            **{'ordinate_spec_data_type': 12, 'ordinate_axis_units_lab': 'm/s^2', 'id1': 'a'},
            **{'abscissa_spec_data_type': 17, 'orddenom_spec_data_type': 0},
        }
        for n, column in enumerate(values.T)
    ]
    pyuff.UFF(str(path)).write_sets([UNITS, *more, *records], 'add')
    return path


@pytest.fixture(scope='module')
def found(tmp_path_factory):
    path = tmp_path_factory.mktemp('mast') / 'mast.uff'
    moved = shaken_frame(3, duration_s=30.0).acceleration
    return ama.open(mast(path, NODES, LINES, motion=moved)).identify()


def shapes_in(report: Path) -> dict:
    """Return what the report draws shapes from."""
    text = report.read_text(encoding='utf-8')
    parts = re.findall(r'<script type="application/json"[^>]*>(.*?)</script>', text, re.DOTALL)
    return next(data['mode_shapes'] for data in map(json.loads, parts) if 'mode_shapes' in data)


def test_shapes_are_drawn_at_the_nodes_of_the_file(found, tmp_path):
    found.save(tmp_path)
    drawn = shapes_in(tmp_path / 'report.html')
    assert np.allclose(drawn['geometry']['points_m'], np.outer(np.arange(5), [0.0, 0.0, 1.0]))
    assert drawn['geometry']['lines'] == [[0, 1, 2, 3], [3, 4]]
    assert drawn['geometry']['sensors'] == [1, 2, 3]


def test_what_was_measured_comes_back_at_its_nodes_and_nothing_more(found, tmp_path):
    found.export(tmp_path / 'modes.uff')
    geometry = read_geometry(tmp_path / 'modes.uff')
    assert geometry is not None and geometry.numbers == (70, 10, 20, 30, 71)
    assert geometry.lines == ((70, 10, 20, 30), (30, 71))
    back = read_shapes(tmp_path / 'modes.uff')
    # Nodes 70 and 71 were not measured: nothing is said of them.
    assert back.channel_names == ('10:+Y', '20:+Y', '30:+Y')
    for mode, shape in zip(back, found.shapes.T, strict=True):
        both = np.abs(np.vdot(mode.shape, shape)) / np.linalg.norm(shape)
        assert both == pytest.approx(np.linalg.norm(mode.shape), rel=1e-4)


def test_sensors_of_a_layout_are_drawn_without_a_robot(tmp_path):
    sensors = [
        f'  - {{name: s{n}, frame_id: world, position_m: [0.0, 0.0, {n}.0], axes: [x]}}\n'
        for n in (1, 2, 3)
    ]
    (tmp_path / 'layout.yaml').write_text('sensors:\n' + ''.join(sensors))
    moved = shaken_frame(3, duration_s=30.0).acceleration
    names = ('s1.x', 's2.x', 's3.x')
    result = ama.identify(moved, RATE_HZ, channel_names=names, layout=tmp_path / 'layout.yaml')
    result.save(tmp_path / 'out')
    drawn = shapes_in(tmp_path / 'out' / 'report.html')
    assert [point[2] for point in drawn['geometry']['points_m']] == [1.0, 2.0, 3.0]


def test_nodes_with_axes_of_their_own_and_files_without_nodes_place_nothing(tmp_path):
    assert read_geometry(mast(tmp_path / 'a.uff')) is None
    path = mast(tmp_path / 'b.uff', NODES)
    path.write_bytes(path.read_bytes() + b'    -1\n  2420\n         1\n    -1\n')
    assert read_geometry(path) is None


def test_a_geometry_that_cannot_be_read_is_said_and_costs_no_modes(tmp_path, caplog):
    other = {**LINES, 'nodes': np.array([70, 99]), 'n_nodes': 2}
    with pytest.raises(RecordingError, match=r'a line through no node .found 99'):
        read_geometry(mast(tmp_path / 'a.uff', NODES, other))
    path = mast(tmp_path / 'b.uff', NODES)
    before, kind, nodes = path.read_bytes().partition(b'    15\n')
    path.write_bytes(before + kind + nodes.replace(b'0.0', b'0x0', 1))
    with pytest.raises(RecordingError, match='damaged dataset 15'):
        read_geometry(path)
    modes = ModeSet((), ('10:-Y', '20:-Y'))
    assert recorded_places(path, modes) is None
    assert 'shapes are drawn channel by channel' in caplog.text
