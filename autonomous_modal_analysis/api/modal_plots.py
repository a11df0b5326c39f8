"""Pictures of identified modes, by matplotlib."""

from collections.abc import Sequence
import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from autonomous_modal_analysis.api.optional import optional
from autonomous_modal_analysis.identified.results import IdentifiedWindow
from modal_core.measurements import NANOSECONDS_PER_SECOND
from modal_core.mode import ModeSet
from modal_core.numbers.indicators import rotate_to_real
from modal_core.poles import PoleStatus
from modal_reports import DAMPING, FREQUENCY, Geometry
from modal_reports.palette import on_white
from oma_identifier.result import WindowResult

MODE, HARMONIC, REST, BEHIND = (
    on_white(role) for role in ('accent', 'harmonic', 'faint', 'unstable')
)
CURVES = tuple(on_white(role) for role in ('spectrum', 'faint', 'unphysical'))
POLES = (
    (PoleStatus.KEPT, 'of a mode', MODE, 16),
    (PoleStatus.HARMONIC, 'harmonic', HARMONIC, 10),
)
DRAWN_SHARE = 0.15
"""Largest displacement that is drawn, of the largest side of the structure."""
AXES_PER_ROW = 4


def new_axes(ax: Any, width_in: float = 8.0, height_in: float = 4.0) -> Any:
    """Return the axes given, or those of a new figure."""
    if ax is not None:
        return ax
    pyplot = optional('matplotlib.pyplot')
    return pyplot.subplots(figsize=(width_in, height_in), layout='constrained')[1]


def plot_spectrum(result: WindowResult, ax: Any = None) -> Any:
    """Draw the singular values, and the frequencies of modes and harmonic lines."""
    ax = new_axes(ax)
    _draw_spectrum(ax, result)
    _mark_modes(ax, result)
    ax.set_ylabel('singular values of the CSD [dB re 1 (SI unit)²/Hz]')
    ax.set_xlabel('frequency [Hz]')
    return ax


def plot_stabilisation(result: WindowResult, ax: Any = None) -> Any:
    """Draw the poles over the model order, the largest singular value behind them."""
    ax = new_axes(ax)
    poles = result.poles
    named = {status for status, *_ in POLES}
    rest = ~np.isin(poles.status, [int(status) for status in named])
    ax.scatter(
        poles.frequency_hz[rest], poles.model_order[rest], s=5, c=REST, label='rejected', lw=0
    )
    for status, label, colour, size in POLES:
        chosen = poles.status == status
        if chosen.any():
            ax.scatter(
                poles.frequency_hz[chosen],
                poles.model_order[chosen],
                s=size,
                c=colour,
                label=label,
                lw=0,
            )
    _mark_modes(ax, result)
    behind = ax.twinx()
    behind.set_zorder(ax.get_zorder() - 1)
    ax.patch.set_visible(False)
    _draw_spectrum(behind, result, n_values=1, colour=BEHIND)
    behind.set_ylabel('largest singular value [dB]')
    ax.set_xlabel('frequency [Hz]')
    ax.set_ylabel('model order')
    ax.legend(loc='upper right', fontsize='small')
    return ax


def _draw_spectrum(
    ax: Any, result: WindowResult, n_values: int | None = None, colour: str | None = None
) -> None:
    spectrum = result.spectrum
    values = spectrum.singular_value[:, :n_values]
    level_db = 10.0 * np.log10(np.maximum(values, np.finfo(float).tiny))
    for number, column in enumerate(level_db.T):
        ax.plot(
            spectrum.frequency_hz,
            column,
            lw=1.0 if number == 0 else 0.7,
            c=colour or CURVES[min(number, 2)],
        )
    ax.margins(x=0)


def _mark_modes(ax: Any, result: WindowResult) -> None:
    for modes, colour in ((result.modes, MODE), (result.harmonics, HARMONIC)):
        for mode in modes:
            ax.axvline(mode.frequency_hz, c=colour, lw=0.8, alpha=0.6)


def plot_tracks(windows: Sequence[IdentifiedWindow], ax: Any = None) -> Any:
    """Draw the natural frequency of every mode over the windows with its standard deviation."""
    ax = new_axes(ax)
    begin_ns = min((window.start_ns for window in windows), default=0)
    middle_ns = [(window.start_ns + window.end_ns) / 2.0 - begin_ns for window in windows]
    time_s = np.divide(middle_ns, NANOSECONDS_PER_SECOND)
    tracks: dict[int, NDArray[np.float64]] = {}
    for place, window in enumerate(windows):
        for mode in window.modes:
            # NaN breaks the line where a window does not show the mode.
            track = tracks.setdefault(mode.id, np.full((2, len(windows)), np.nan))
            track[:, place] = mode.frequency_hz, mode.frequency_std_hz
    for number, (frequency_hz, std_hz) in sorted(tracks.items()):
        ax.errorbar(time_s, frequency_hz, std_hz, fmt='o-', ms=4, lw=1, label=f'mode {number}')
    ax.set_xlabel('middle of the window [s]')
    ax.set_ylabel('natural frequency [Hz]')
    if tracks:
        ax.legend(loc='center left', bbox_to_anchor=(1.0, 0.5), fontsize='small')
    return ax


def plot_bars(modes: ModeSet) -> Any:
    """Draw each shape as bars over the channels."""
    names = modes.channel_names
    axes = _grid(modes, {'sharey': True}, width_in=1.2 + 0.25 * len(names))
    for ax, mode in zip(axes, modes, strict=True):
        std = None if mode.shape_std is None else mode.shape_std.real
        place = np.arange(len(names))
        ax.bar(place, mode.shape.real, yerr=std, color=MODE, ecolor=on_white('ink'), capsize=2)
        ax.plot(place, mode.shape.imag, 'o', ms=3, c=on_white('candidate'))
        ax.axhline(0.0, c=on_white('soft'), lw=0.8)
        ax.set_xticks(place, names, rotation=90 if len(names) > 3 else 0, fontsize='small')
    return axes


def plot_on_geometry(
    modes: ModeSet, geometry: Geometry, displacements: Sequence[NDArray[np.complex128]]
) -> Any:
    """Draw each shape on points and lines: at rest in grey, moved in colour."""
    axes = _grid(modes, {'subplot_kw': {'projection': '3d'}}, width_in=2.8)
    size_m = max(float(np.ptp(geometry.points_m, axis=0).max()), 1e-9)
    for ax, displacement in zip(axes, displacements, strict=True):
        moved = rotate_to_real(displacement.reshape(-1, 1)).real.reshape(-1, 3)
        largest = max(float(np.linalg.norm(moved, axis=1).max()), 1e-12)
        shifted = geometry.points_m + DRAWN_SHARE * size_m / largest * moved
        for points, colour, width in ((geometry.points_m, REST, 1.0), (shifted, MODE, 2.0)):
            for line in geometry.lines:
                ax.plot(*points[list(line)].T, c=colour, lw=width)
            ax.scatter(*points[list(geometry.sensors)].T, c=colour, s=8, depthshade=False)
        ax.set_aspect('equal')
        for axis in (ax.xaxis, ax.yaxis, ax.zaxis):
            axis.set_ticklabels([])
    return axes


def _grid(modes: ModeSet, options: dict[str, Any], width_in: float) -> Any:
    """Return an array with one titled axes per mode, all in one figure; empty without modes."""
    pyplot = optional('matplotlib.pyplot')
    if not len(modes):
        return np.empty(0, dtype=object)
    n_columns = min(AXES_PER_ROW, len(modes))
    n_rows = math.ceil(len(modes) / n_columns)
    _, grid = pyplot.subplots(
        n_rows,
        n_columns,
        figsize=(n_columns * max(width_in, 2.2), 2.6 * n_rows),
        squeeze=False,
        layout='constrained',
        **options,
    )
    axes = grid.flatten()
    for ax, mode in zip(axes, modes, strict=False):
        ax.set_title(
            f'{FREQUENCY.text(mode.frequency_hz)}, {DAMPING.text(mode.damping_ratio)}', fontsize=9
        )
    for ax in axes[len(modes) :]:
        ax.remove()
    return axes[: len(modes)]
