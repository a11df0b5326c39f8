"""What changed between two sets of modes, for people and for programs."""

from collections.abc import Sequence

from autonomous_modal_analysis.console.terminal import OUTPUT
from autonomous_modal_analysis.identified.results import mode_json, plain
from autonomous_modal_analysis.report import ComparedState, headline
from modal_core.mode import Mode
from modal_reports import FREQUENCY
from oma_identifier.compare import ModeComparison


def show_summary(comparison: ModeComparison, first: str, second: str) -> None:
    """Print how many modes changed, and the modes of one side alone."""
    marks = ' (* and ~)' if comparison.changes else ''
    OUTPUT.print(f'{second}: {headline(comparison)}{marks}', markup=False)
    for name, alone in ((first, comparison.only_first), (second, comparison.only_second)):
        if alone:
            OUTPUT.print(f'{name} alone: {_listed(alone)}', soft_wrap=True, markup=False)


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


def _listed(modes: Sequence[Mode]) -> str:
    return ', '.join(FREQUENCY.text(mode.frequency_hz, mode.frequency_std_hz) for mode in modes)
