"""Checks of the cell's nodes, and the alarms of its history among them."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from enum import IntEnum

from modal_dashboard.screens.board import Update
from modal_dashboard.screens.plain_tables import plain_table
from modal_reports import Cell, Row, Table, text

MOST_CHECKS = 200
"""Names come from anywhere."""
MOST_LETTERS = 600
STALE_S = 5.0
"""Checks come every second; what is older counts as silent (as diagnostic_aggregator has it)."""
ALARMS = ': alarms'
"""How the name of a history's check ends."""


class CheckStep(IntEnum):
    """How bad it is; numbers of diagnostic_msgs/DiagnosticStatus."""

    OK = 0
    WARNING = 1
    ERROR = 2
    STALE = 3


@dataclass(frozen=True, slots=True)
class Check:
    """One check of a node.

    Parameters
    ----------
    name : str
        Full name of the node, a colon, what is checked.
    step : CheckStep
        How bad it is.
    message : str
        Begins with the code of the worst finding.
    values : mapping of str to str
        Codes with their text, and counters.
    """

    name: str
    step: CheckStep
    message: str
    values: Mapping[str, str] = field(default_factory=dict)


class Checks:
    """The newest of every check.

    Parameters
    ----------
    namespace : str
        Of the cell: checks of other cells are left out; '/' for none.
    """

    def __init__(self, namespace: str) -> None:
        self._namespace = namespace.rstrip('/')
        self._newest: dict[str, Check] = {}
        self._heard_s: dict[str, float] = {}

    def take(self, checks: Iterable[Check], now_s: float) -> list[Check]:
        """Keep checks; return those that are other than before, and those that fell silent.

        Parameters
        ----------
        checks : iterable of Check
            As they came.
        now_s : float [s]
            Of a clock that only goes forward.
        """
        changed = [check for check in checks if self._is_new(check, now_s)]
        for name, heard_s in self._heard_s.items():
            check = self._newest[name]
            if now_s - heard_s > STALE_S and check.step != CheckStep.STALE:
                silent = f'not heard for {STALE_S:.0f} s; before: {check.message}'
                self._newest[name] = replace(check, step=CheckStep.STALE, message=silent)
                changed.append(self._newest[name])
        return changed

    def updates(self) -> list[Update]:
        """Return what the page says of all, and of the alarms by themselves."""
        rows = [_row(check) for _, check in sorted(self._newest.items())]
        heads = (text('Check'), text('State'), text('Finding'), text('Details'))
        history = [check for check in self._newest.values() if check.name.endswith(ALARMS)]
        alarms = [f'{name}: {said}' for check in history for name, said in check.values.items()]
        alarms += [check.message for check in history if check.step == CheckStep.STALE]
        table = Table('Checks', heads, rows, empty='No node has told anything yet.')
        told = {'alarms': alarms, 'history': bool(history)}
        return [Update.of('checks', plain_table(table)), Update.of('alarms', told)]

    def _is_new(self, check: Check, now_s: float) -> bool:
        """Keep a check of this cell; return whether it says something else than before."""
        node, known = check.name.partition(':')[0], self._newest.get(check.name)
        is_full = known is None and len(self._newest) >= MOST_CHECKS
        if is_full or node.rpartition('/')[0] != self._namespace:
            return False
        self._newest[check.name], self._heard_s[check.name] = check, now_s
        if known is None:
            return check.step != CheckStep.OK
        return known.message != check.message


def _row(check: Check) -> Row:
    details = '; '.join(f'{name}: {words}' for name, words in check.values.items())
    if len(details) > MOST_LETTERS:
        details = f'{details[: MOST_LETTERS - 1]}…'
    bad = check.step != CheckStep.OK
    state = Cell(check.step.name.lower(), 'bad' if bad else '')
    cells = (text(check.name), state, Cell(check.message, 'free'), Cell(details, 'free wide'))
    return Row(cells)
