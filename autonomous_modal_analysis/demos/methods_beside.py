"""All methods on the same samples, beside what is true: a table and a page."""

from collections.abc import Sequence
from dataclasses import dataclass
import math
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from rich.table import Table as TerminalTable

from autonomous_modal_analysis.console.terminal import OUTPUT, StageCallback
from autonomous_modal_analysis.identified.identification import IdentifiedRecording
from autonomous_modal_analysis.report import TrueMode
from modal_core.errors import ModalAnalysisError
from modal_core.files.atomic_file import write_text
from modal_core.mode import Mode
from modal_reports import FREQUENCY, number, Page, render, Row, Table, text
from oma_identifier.methods import CATALOGUE, identify_by

METHODS_PAGE = 'methods.html'
TEMPLATE = Path(__file__).parent / 'templates' / 'methods.html.j2'
TAKES_S = {
    'ssi_data': 8.0, 'plscf': 10.0, 'var': 5.0, 'rvar': 4.0, 'notch': 22.0, 'vmd': 16.0,
    'psdtm': 4.0, 'efdd': 15.0, 'fdd': 3.0,
}  # fmt: skip
"""Of two minutes of 42 channels on a machine at work with other things: only their ratios count,
for what is left."""
USUAL_S = 10.0
"""Of a method that is not among these."""
ON_LINE = 2e-3
"""Of its frequency: a mode so near a line stands on it."""


@dataclass(frozen=True, slots=True)
class MethodBeside:
    """What one method made of the samples.

    Parameters
    ----------
    name : str
    found : tuple of Mode or None
        Of each true mode, in their order; None: missed.
    on_lines, others : tuple of float [Hz]
        Modes where the process has a line, and other modes that are none.
    refused : str
        Why there is nothing; else empty.
    """

    name: str
    found: tuple[Mode | None, ...]
    on_lines: tuple[float, ...] = ()
    others: tuple[float, ...] = ()
    refused: str = ''


def every_method(
    identified: IdentifiedRecording,
    truth: Sequence[TrueMode],
    arm_hz: NDArray[np.float64],
    lines_hz: NDArray[np.float64],
    progress: StageCallback = lambda *_: None,
) -> tuple[MethodBeside, ...]:
    """Identify the samples of a recording by every method that needs nothing more.

    Parameters
    ----------
    identified : IdentifiedRecording
        With its samples; its own modes are those of the first row.
    truth : sequence of TrueMode
        What is asked for.
    arm_hz, lines_hz : array [Hz]
        All modes of the arm, and the lines of the process.
    progress : callable
        Takes the fraction done, and which method is at work.
    """
    own = identified.identification.modes
    results = [judged(own.method, list(own), truth, arm_hz, lines_hz)]
    others = [
        method for method in CATALOGUE if not method.needs_inputs and method.name != own.method
    ]
    takes_s = np.array([TAKES_S.get(method.name, USUAL_S) for method in others])
    done = np.concatenate([[0.0], np.cumsum(takes_s) / takes_s.sum()])
    for at, method in enumerate(others):
        progress(float(done[at]), f'{method.name}, {at + 1} of {len(others)}')
        try:
            modes = list(identify_by(method.name, identified.parts[0]).modes)
        except ModalAnalysisError as error:
            nothing = (None,) * len(truth)
            results.append(MethodBeside(method.name, nothing, refused=str(error)))
            continue
        results.append(judged(method.name, modes, truth, arm_hz, lines_hz))
    return tuple(results)


def judged(
    name: str,
    modes: Sequence[Mode],
    truth: Sequence[TrueMode],
    arm_hz: NDArray[np.float64],
    lines_hz: NDArray[np.float64],
) -> MethodBeside:
    """Pair modes with true ones by frequency, each within the half-width of the true one."""
    left = [mode for mode in modes if not mode.harmonic]
    found: list[Mode | None] = []
    for true in truth:
        near = [
            mode
            for mode in left
            if abs(mode.frequency_hz / true.frequency_hz - 1.0) < true.damping_ratio
        ]
        best = min(near, key=lambda mode: abs(mode.frequency_hz - true.frequency_hz), default=None)
        if best is not None:
            left.remove(best)
        found.append(best)
    highest = 1.1 * max(true.frequency_hz for true in truth) if truth else math.inf
    rest = [mode.frequency_hz for mode in left if mode.frequency_hz < highest]
    on_lines = [hz for hz in rest if (np.abs(hz / lines_hz - 1.0) < ON_LINE).any()]
    others = [
        hz for hz in rest if hz not in on_lines and not (np.abs(hz / arm_hz - 1.0) < 0.01).any()
    ]
    return MethodBeside(name, tuple(found), tuple(on_lines), tuple(others))


def show_methods(methods: Sequence[MethodBeside], n_asked: int) -> None:
    """Print one row per method."""
    table = TerminalTable(title='every method on the same samples', title_justify='left')
    for heading in ('method', 'modes found', 'lines as modes', 'other false modes'):
        table.add_column(heading, justify='left' if heading == 'method' else 'right')
    for one in methods:
        if one.refused:
            table.add_row(one.name, 'refused', '', '')
            continue
        n_found = sum(mode is not None for mode in one.found)
        counts = (f'{n_found} of {n_asked}', str(len(one.on_lines)), str(len(one.others)))
        table.add_row(one.name, *counts)
    OUTPUT.print(table)


def write_methods(path: Path, truth: Sequence[TrueMode], methods: Sequence[MethodBeside]) -> None:
    """Write the page: a row per method, a column per true mode."""
    headings = [
        text('Method'),
        *(number(f'{true.frequency_hz:.3f} Hz') for true in truth),
        number('Lines as modes'),
        number('Other false modes'),
    ]
    rows = [Row([text('truth: ζ %'), *(number(f'{100 * one.damping_ratio:.2f}') for one in truth),
                 number(''), number('')])]  # fmt: skip
    for one in methods:
        cells = [number('' if one.refused else _cell(mode)) for mode in one.found]
        ends = ('refused', '') if one.refused else (_listed(one.on_lines), _listed(one.others))
        rows.append(Row([text(one.name), *cells, *map(number, ends)]))
    refused = [f'{one.name}: {one.refused}' for one in methods if one.refused]
    table = Table('Every method on the same samples', headings, rows, empty='no methods')
    values = {'table': table, 'refused': refused}
    page = Page('Methods beside the truth', 'the milling arm', TEMPLATE, values)
    write_text(path, render(page))


def _cell(mode: Mode | None) -> str:
    if mode is None:
        return 'missed'
    frequency = FREQUENCY.number(mode.frequency_hz, mode.frequency_std_hz)
    zeta = '' if math.isnan(mode.damping_ratio) else f', {100 * mode.damping_ratio:.2f} %'
    return f'{frequency}{zeta}'


def _listed(hz: Sequence[float]) -> str:
    return ', '.join(f'{each:.2f}' for each in hz) if hz else '0'
