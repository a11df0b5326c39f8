"""Curves of one number over another, both with their units: hover and zoom."""

from collections.abc import Sequence
from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import NDArray

from modal_reports.charts.plain_numbers import number

Array = NDArray[np.float64]
MOST_POINTS = 1500
"""Of a curve: as many as zooming in four times still resolves."""
DIGITS = 5


@dataclass(frozen=True, slots=True)
class Axis:
    """What an axis counts.

    Parameters
    ----------
    name, unit : str
        Said beside it; no unit where there is none.
    """

    name: str
    unit: str = ''

    @property
    def words(self) -> str:
        """Name with the unit in brackets."""
        return f'{self.name} [{self.unit}]' if self.unit else self.name


@dataclass(frozen=True, slots=True)
class Trace:
    """One curve.

    Parameters
    ----------
    kind : str
        Its colour: ``measured``, ``before``, ``after``.
    x, y : (n,) array
        In the order in which they are joined, which need not be that of x.
    name : str
        Said when it is pointed at; the kind where there is none.
    """

    kind: str
    x: Array
    y: Array
    name: str = ''


@dataclass(frozen=True, slots=True)
class Curves:
    """A chart of curves.

    Parameters
    ----------
    title : str
        Above it.
    across, up : Axis
        Of x and y.
    traces : sequence of Trace
        From back to front.
    logarithmic : bool
        Decades of y; its values are positive.
    level : float
        A dashed line, the noise; NaN: none.
    """

    title: str
    across: Axis
    up: Axis
    traces: Sequence[Trace]
    logarithmic: bool = False
    level: float = math.nan


def curves_data(chart: Curves) -> dict[str, object]:
    """Return what the chart draws."""
    return {
        'title': chart.title,
        'across': {'words': chart.across.words, 'unit': chart.across.unit},
        'up': {'words': chart.up.words, 'unit': chart.up.unit},
        'logarithmic': chart.logarithmic,
        'level': number(chart.level),
        'traces': [_trace(trace, positive=chart.logarithmic) for trace in chart.traces],
    }


def _trace(trace: Trace, *, positive: bool) -> dict[str, object]:
    step = -(-len(trace.x) // MOST_POINTS) or 1
    y = np.asarray(trace.y[::step], dtype=float)
    return {
        'kind': trace.kind,
        'name': trace.name or trace.kind,
        'x': _short(np.asarray(trace.x[::step], dtype=float)),
        'y': _short(np.where(y > 0.0, y, np.nan) if positive else y),
    }


def _short(values: Array) -> list[float | None]:
    known = (number(value) for value in values.tolist())
    return [None if value is None else float(f'{value:.{DIGITS}g}') for value in known]
