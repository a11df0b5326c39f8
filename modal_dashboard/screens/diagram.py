"""Spectrum and stabilisation diagram of a window."""

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modal_core.mode import Mode
from modal_core.poles import PoleStatus, PoleTable
from modal_dashboard.screens.board import Update
from modal_dashboard.screens.plain_tables import plain_table
from modal_reports import (
    Cell,
    number,
    Row,
    Spectrum,
    stabilisation_data,
    STATUS_WORDS,
    Table,
    text,
)


@dataclass(frozen=True, slots=True)
class Diagram:
    """Poles of a window and the spectrum behind them.

    Parameters
    ----------
    index : int
        Of the window.
    poles : PoleTable
        Without shapes; ``mode_id`` as the modes are tracked.
    spectrum : Spectrum
        Singular values.
    """

    index: int
    poles: PoleTable
    spectrum: Spectrum


def pole_table(
    frequency_hz: NDArray[np.float64],
    damping_ratio: NDArray[np.float64],
    model_order: NDArray[np.int64],
    status: NDArray[np.uint8],
    mode_id: NDArray[np.int64],
) -> PoleTable:
    """Return poles out of what a message says of them, each (n_poles,).

    Raises
    ------
    ValueError
        Lengths that differ, a reason that is none, or a pole that no structure has.
    """
    n_poles = len(frequency_hz)
    if {len(each) for each in (damping_ratio, model_order, status, mode_id)} != {n_poles}:
        raise ValueError('poles of different numbers')
    if not np.isin(status, list(PoleStatus)).all():
        raise ValueError('an unknown reason of a pole')
    if not ((frequency_hz > 0.0) & np.isfinite(frequency_hz + damping_ratio)).all():
        raise ValueError('a pole of no frequency or damping')
    damping = np.clip(damping_ratio, -1.0, 1.0)
    turn = -damping + 1j * np.sqrt(1.0 - damping**2)
    shape = np.empty((0, n_poles), complex)
    return PoleTable(model_order, 2.0 * np.pi * frequency_hz * turn, shape, status, mode_id)


def diagram_update(diagram: Diagram, lines: Iterable[Mode]) -> Update:
    """Return what the screens of spectrum and poles show.

    Parameters
    ----------
    diagram : Diagram
        Of a window.
    lines : iterable of Mode
        That window's modes and lines of machines.
    """
    data = stabilisation_data(diagram.poles, diagram.spectrum, lines)
    return Update.of('diagram', {**data, 'index': diagram.index, 'reasons': _reasons(diagram)})


def _reasons(diagram: Diagram) -> dict[str, object]:
    """Return a table of how many poles were kept, and turned down for what."""
    counts = Counter(diagram.poles.status.tolist())
    rows = [
        Row((number(str(count)), text(STATUS_WORDS[PoleStatus(status)])))
        for status, count in counts.most_common()
    ]
    heads = (number('Poles'), Cell('What became of them'))
    return plain_table(Table('Poles by reason', heads, rows))
