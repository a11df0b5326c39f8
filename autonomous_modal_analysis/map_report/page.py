"""One HTML file that shows a modal map: slices over two axes with σ, and the measured poses."""

from pathlib import Path

from markupsafe import Markup
import numpy as np
from numpy.typing import NDArray

from modal_core.files.version import software
from modal_reports import Cell, fixed, heat_map, number, Page, render, Row, Table
from modal_reports.palette import HeatScale
from structural_model.description import shown, SLIDING, value_words
from workspace_map import LARGEST_STD, WorkspaceMap

Array = NDArray[np.float64]
TEMPLATES = Path(__file__).parent / 'templates'
TEMPLATE, STYLE = TEMPLATES / 'map.html.j2', TEMPLATES / 'map.css'
N_ROWS, N_COLUMNS, MOST_MODES = 11, 11, 9
PART_OF_RANGE = 0.95
"""Of each axis; at its very ends no pose is inside the coupled ranges."""


def render_map(known: WorkspaceMap, pose: Array, axes: tuple[int, int]) -> str:
    """Return the report as one HTML document.

    Parameters
    ----------
    known : WorkspaceMap
        The map.
    pose : (n_joints,) array [rad]
        Serial joints; what the other axes are at.
    axes : (int, int)
        Controller axes that are varied, rows and columns.
    """
    model = known.arm.model
    others = [
        f'{name} {value_words(value, slides, 0)} {_sign(slides)}'
        for number, (name, value, slides) in enumerate(
            zip(model.axis_names, model.shown_axes(pose), model.sliding, strict=True)
        )
        if number not in axes
    ]
    tool = known.arm.tool
    values = {
        'name': model.robot_name,
        'facts': [
            f'{len(known.measured)} poses measured',
            f'modes below {known.highest_hz:g} Hz',
            f'tool at {tool.link}, {", ".join(f"{part:g}" for part in tool.position_m)} m',
        ],
        'across': f'{model.axis_names[axes[0]]} and {model.axis_names[axes[1]]}',
        'others': ', '.join(others),
        'bound': f'{100 * LARGEST_STD:g} %',
        'drawings': slices(known, pose, axes),
        'poses': _poses(known),
        'provenance': {'software': software()},
    }
    return render(Page('Modal map', 'Modes over the workspace', TEMPLATE, values, styles=(STYLE,)))


def slices(known: WorkspaceMap, pose: Array, axes: tuple[int, int]) -> list[Markup]:
    """Draw frequency and σ of each mode over two axes, (row, column)."""
    model = known.arm.model
    grids = [_grid(known, axis, n) for axis, n in zip(axes, (N_ROWS, N_COLUMNS), strict=True)]
    slides = [model.sliding[axis] for axis in axes]
    names = [
        [value_words(value, slide, 0) for value in shown(grid, [slide])]
        for grid, slide in zip(grids, slides, strict=True)
    ]
    frequency = np.full((MOST_MODES, N_ROWS, N_COLUMNS), np.nan)
    std = np.full_like(frequency, np.nan)
    for row, column in np.ndindex(N_ROWS, N_COLUMNS):
        controller = model.to_controller(pose)
        controller[list(axes)] = grids[0][row], grids[1][column]
        q = model.to_serial(controller)
        if model.limits.position_violation(q) is not None:
            continue
        found = known.predict(q)
        n = min(len(found), MOST_MODES)
        relative = found.frequency_std_hz[:n] / found.frequency_hz[:n]
        sure = relative <= LARGEST_STD
        frequency[:n, row, column] = np.where(sure, found.frequency_hz[:n], np.nan)
        std[:n, row, column] = np.where(sure, found.frequency_std_hz[:n], np.nan)
    return [
        _drawing(f'mode {mode + 1}', names, frequency[mode], std[mode])
        for mode in range(MOST_MODES)
        if np.isfinite(frequency[mode]).any()
    ]


def _grid(known: WorkspaceMap, axis: int, count: int) -> Array:
    limits = known.arm.model.limits
    low = max(float(limits.controller_low[axis]), -np.pi)
    high = min(float(limits.controller_high[axis]), np.pi)
    middle, half = 0.5 * (low + high), 0.5 * PART_OF_RANGE * (high - low)
    return np.linspace(middle - half, middle + half, count)


def _drawing(title: str, names: list[list[str]], frequency: Array, std: Array) -> Markup:
    drawn = []
    for label, values, digits in (
        (f'{title} / Hz', frequency, 1),
        ('σ / %', 100.0 * std / frequency, 2),
    ):
        low, high = float(np.nanmin(values)), float(np.nanmax(values))
        scale = HeatScale(low, max(high, low + 1e-6))

        def words(value: float, digits: int = digits) -> str:
            return fixed(value, digits)

        drawn.append(heat_map(label, names[0], names[1], [(label, values)], scale, words))
    return Markup('').join(drawn)


def _sign(slides: bool) -> str:
    return SLIDING if slides else '°'


def _poses(known: WorkspaceMap) -> Table:
    model = known.arm.model
    rows = []
    for place, pose in enumerate(known.measured, 1):
        angles = model.shown_axes(pose.q)
        there = known.predict(pose.q)
        measured = np.median(pose.frequency_std_hz / pose.frequency_hz) if len(pose) else np.nan
        mapped = np.median(there.frequency_std_hz / there.frequency_hz)
        rows.append(
            Row(
                [
                    number(str(place)),
                    *(number(value_words(*it)) for it in zip(angles, model.sliding, strict=True)),
                    number(str(len(pose))),
                    number(f'{100 * measured:.2f} %'),
                    number(f'{100 * mapped:.2f} %'),
                ]
            )
        )
    headings: list[Cell] = [
        number('pose'),
        *(
            number(f'{name} / {_sign(slides)}')
            for name, slides in zip(model.axis_names, model.sliding, strict=True)
        ),
        number('modes'),
        number('σ measured'),
        number('σ of the map'),
    ]
    return Table('Measured poses', headings, rows)
