"""What changed between two sets of modes, for people and for programs."""

from collections.abc import Sequence

from rich.markup import escape

from autonomous_modal_analysis.report import ComparedState, headline
from autonomous_modal_analysis.results import mode_json, plain
from autonomous_modal_analysis.terminal import narrow_table, OUTPUT
from modal_core.mode import Mode
from modal_reports import DAMPING, fixed, FREQUENCY, percent
from oma_identifier.compare import ModeChange, ModeComparison

HEADINGS = (
    'first Hz',
    'second Hz',
    'Δ %',
    '/σ',
    'first %',
    'second %',
    '/σ',
    'MAC',
    '',
    'by chance ≥',
)
WIDE = 92
"""Columns of a terminal that shows, beside the MAC, what it is at least by chance."""


def show_changes(comparison: ModeComparison, first: str, second: str) -> None:
    """Print one row per pair of modes, and the modes of one side alone."""
    table = narrow_table(escape(f'natural frequency and damping ratio: {first}, then {second}'))
    shown = len(HEADINGS) if OUTPUT.width >= WIDE else len(HEADINGS) - 1
    for heading in HEADINGS[:shown]:
        table.add_column(heading, justify='right', no_wrap=True)
    for change in comparison.changes:
        table.add_row(*_row(change)[:shown])
    OUTPUT.print(table)
    for name, alone in ((first, comparison.only_first), (second, comparison.only_second)):
        if alone:
            OUTPUT.print(f'{name} alone: {_listed(alone)}', soft_wrap=True, markup=False)
    OUTPUT.print(f'{headline(comparison)} (* and ~)', soft_wrap=True)


def changes_json(first: str, states: Sequence[ComparedState]) -> dict[str, object]:
    """Return what changed from the first as plain values; of one other without a list."""
    found = [
        {'first_name': first, 'second_name': state.name, **_changes(state.found)}
        for state in states
    ]
    return found[0] if len(found) == 1 else {'comparisons': found}


def _changes(comparison: ModeComparison) -> dict[str, object]:
    return {
        'changes': [
            {
                'first': mode_json(change.first),
                'second': mode_json(change.second),
                'frequency_change': plain(change.frequency_change),
                'frequency_surprise': plain(change.frequency_surprise),
                'damping_change': plain(change.damping_change),
                'damping_surprise': plain(change.damping_surprise),
                'mac': plain(change.mac),
                'expected_mac': plain(change.expected_mac.mean),
                'least_mac': plain(change.expected_mac.least),
                'shape_changed': bool(change.is_shape_changed),
                'significant': bool(change.is_significant),
            }
            for change in comparison.changes
        ],
        'only_first': [mode_json(mode) for mode in comparison.only_first],
        'only_second': [mode_json(mode) for mode in comparison.only_second],
    }


def _row(change: ModeChange) -> tuple[str, ...]:
    first, second = change.first, change.second
    return (
        FREQUENCY.number(first.frequency_hz, first.frequency_std_hz),
        FREQUENCY.number(second.frequency_hz, second.frequency_std_hz),
        percent(change.frequency_change, 2, sign=True).removesuffix(' %'),
        fixed(change.frequency_surprise, 1, sign=True),
        DAMPING.number(first.damping_ratio, first.damping_ratio_std),
        DAMPING.number(second.damping_ratio, second.damping_ratio_std),
        fixed(change.damping_surprise, 1, sign=True),
        fixed(change.mac, 3),
        '*' * change.is_significant + '~' * change.is_shape_changed,
        fixed(change.expected_mac.least, 3),
    )


def _listed(modes: Sequence[Mode]) -> str:
    return ', '.join(FREQUENCY.text(mode.frequency_hz, mode.frequency_std_hz) for mode in modes)
