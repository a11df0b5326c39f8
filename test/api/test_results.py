"""Results show themselves: text, table, picture."""

import importlib
import sys

import numpy as np
import pytest

import autonomous_modal_analysis as ama
from autonomous_modal_analysis.api.modal_plots import plot_on_geometry
from autonomous_modal_analysis.api.placed_shapes import placed_shapes
from modal_core.channel import SensorLayout
from modal_core.errors import LayoutError
from modal_core.mode import Mode, ModeSet
from test.support.frame import FLOORS

LAYOUT = {
    'sensors': [
        {'name': floor, 'frame_id': 'world', 'position_m': [0.0, 0.0, 3.0 * height], 'axes': ['x']}
        for height, floor in enumerate(('ground', 'middle', 'roof'), start=1)
    ]
}


def test_the_text_is_short_and_has_every_mode(frame, identified):
    lines = repr(identified).splitlines()
    assert len(lines) == 5 and max(map(len, lines)) < 100
    assert lines[0].startswith('3 modes of array by ssi_cov')
    assert all('±' in line for line in lines[2:])
    for line, frequency_hz in zip(lines[2:], frame.frequencies_hz, strict=True):
        assert float(line.split()[0]) == pytest.approx(frequency_hz, rel=0.01)


def test_noise_alone_has_no_modes_and_says_so():
    nothing = ama.identify(np.random.default_rng(3).normal(size=(6000, 2)), 100.0)
    assert len(nothing) == 0 and repr(nothing).startswith('0 modes of array by ssi_cov: ')
    assert nothing.frequencies_hz.shape == nothing.damping_ratios_std.shape == (0,)
    assert nothing.shapes.shape == nothing.shapes_std.shape == (2, 0)
    assert '<table' not in nothing._repr_html_()


def test_names_in_html_are_letters(frame):
    nasty = ['<script>alert(1)</script>', 'b', 'c']
    shown = ama.identify(frame.acceleration, 100.0, channel_names=nasty)._repr_html_()
    assert '<script' not in shown and shown.count('<tr>') == 4


def test_the_table_has_one_row_per_mode(identified):
    pytest.importorskip('pandas')
    table = identified.to_dataframe()
    assert (table['frequency_hz'] == identified.frequencies_hz).all()
    assert (table['damping_ratio_std'] == identified.damping_ratios_std).all()
    for row, name in enumerate(FLOORS):
        assert (table[f'shape.{name}'] == identified.shapes[row]).all()


@pytest.mark.parametrize(
    ('package', 'ask'),
    [
        ('pandas', lambda result: result.to_dataframe()),
        ('matplotlib', lambda result: result.plot_spectrum()),
        ('matplotlib', lambda result: result.plot_shapes()),
    ],
)
def test_a_package_that_is_not_there_is_named(identified, package, ask, monkeypatch):
    for name in [name for name in sys.modules if name.split('.')[0] == package]:
        monkeypatch.delitem(sys.modules, name)

    class Absent:
        def find_spec(self, name, path=None, target=None):
            if name.split('.')[0] == package:
                raise ModuleNotFoundError(f'No module named {name!r}', name=name)

    monkeypatch.setattr(sys, 'meta_path', [Absent(), *sys.meta_path])
    importlib.invalidate_caches()
    with pytest.raises(ama.ModalAnalysisError, match=f'{package} is not installed') as caught:
        ask(identified)
    assert f'pip install {package}' in str(caught.value) and '\n' not in str(caught.value)


@pytest.mark.usefixtures('no_window')
def test_the_spectrum_peaks_at_the_modes(identified):
    ax = identified.plot_spectrum()
    frequency_hz, level_db = ax.lines[0].get_data()
    for place in identified.frequencies_hz:
        near = np.abs(frequency_hz - place) < 0.3
        assert level_db[near].max() > np.median(level_db) + 10.0
    marks = [line.get_xdata()[0] for line in ax.lines[-3:]]
    assert marks == pytest.approx(identified.frequencies_hz)


@pytest.mark.usefixtures('no_window')
def test_the_stabilisation_diagram_has_all_poles(identified):
    ax = identified.plot_stabilisation()
    drawn = sum(len(points.get_offsets()) for points in ax.collections)
    assert drawn == len(identified.found.whole.poles)
    kept = np.concatenate([p.get_offsets()[:, 0] for p in ax.collections[1:]])
    nearest = np.abs(kept[:, None] - identified.frequencies_hz).min(axis=1)
    assert nearest.max() < 0.3
    assert identified.plot_stabilization().get_ylabel() == 'model order'


@pytest.mark.usefixtures('no_window')
def test_tracks_are_the_modes_of_the_windows(identified):
    import matplotlib.pyplot as plt

    _, given = plt.subplots()
    ax = identified.plot_tracks(ax=given)
    assert ax is given
    tracks = [container.lines[0] for container in ax.containers]
    assert len(tracks) == 3
    assert sum(np.isfinite(t.get_ydata()).sum() for t in tracks) == sum(
        len(window.modes) for window in identified.windows
    )


@pytest.mark.usefixtures('no_window')
def test_shapes_are_bars_without_places(identified):
    axes = identified.plot_shapes()
    assert len(axes) == len(axes[0].figure.axes) == 3
    for ax, mode in zip(axes, identified.modes, strict=True):
        heights = [patch.get_height() for patch in ax.patches]
        assert heights == pytest.approx(mode.shape.real)


@pytest.mark.usefixtures('no_window')
def test_shapes_are_drawn_where_the_layout_places_the_sensors(frame):
    found = ama.identify(frame.acceleration, 100.0, channel_names=FLOORS, layout=LAYOUT)
    axes = found.plot_shapes(lines=[('ground', 'middle', 'roof')])
    assert [ax.name for ax in axes] == ['3d'] * 3
    geometry, moved = placed_shapes(found.layout, found.modes)
    assert geometry.points_m[:, 2] == pytest.approx([3.0, 6.0, 9.0])
    for mode, points in zip(found.modes, moved, strict=True):
        assert points[:, 0] == pytest.approx(mode.shape)
        assert not points[:, 1:].any()
    assert len(plot_on_geometry(found.modes, geometry, moved)) == 3
    with pytest.raises(LayoutError, match='no such sensor'):
        found.plot_shapes(lines=[('ground', 'cellar')])


def test_gyroscopes_are_at_no_place_and_move_nothing():
    """Sensors turned by a third of a turn: their x reads motion along y."""
    turned = {'frame_id': 'base', 'axes': ['x'], 'rotation_quaternion': [0.5, 0.5, 0.5, 0.5]}
    sensors = [
        {'name': 'low', 'position_m': [0.0, 0.0, 1.0], **turned},
        {'name': 'high', 'position_m': [0.0, 0.0, 2.0], **turned},
        {'name': 'tilt', 'position_m': [0.0, 0.0, 2.0], 'unit': 'deg/s', **turned},
    ]
    layout = SensorLayout.from_mapping({'sensors': sensors})
    names = ('low.x', 'high.x', 'tilt.x', 'high.gyro_x')
    modes = ModeSet((Mode(3.0, 0.01, np.array([0.5, 1.0, 0.3, 0.2j])),), names)
    geometry, moved = placed_shapes(layout, modes, others={'tilt.x', 'high.gyro_x'})
    assert geometry.points_m[:, 2] == pytest.approx([1.0, 2.0])
    assert moved[0] == pytest.approx(np.array([[0.0, 0.5, 0.0], [0.0, 1.0, 0.0]]))
    assert placed_shapes(layout, modes) is None
