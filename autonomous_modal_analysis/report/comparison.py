"""The report of a comparison: what changed between recordings, and whether scatter explains it."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from markupsafe import Markup

from autonomous_modal_analysis.compared.mode_courses import mode_courses
from autonomous_modal_analysis.compared.mode_levels import ModeLevels
from autonomous_modal_analysis.compared.operating_state import OperatingState, UNKNOWN_STATE
from autonomous_modal_analysis.report.courses import courses_shown
from autonomous_modal_analysis.report.levels import levels_shown
from autonomous_modal_analysis.report.overlay import (
    damping_of_both,
    shapes_of_both,
    spectra_of_both,
    StateDrawn,
)
from autonomous_modal_analysis.report.still_pictures import draw_mac
from modal_core.files.atomic_file import write_text
from modal_core.mode import Mode, ModeSet
from modal_reports import (
    Cell,
    count,
    DAMPING,
    error_mark,
    fixed,
    FREQUENCY,
    MAC,
    measured,
    number,
    Page,
    percent,
    Quantity,
    render,
    Row,
    Table,
    tags,
    text,
)
from oma_identifier.compare import ModeChange, ModeComparison

TEMPLATE = Path(__file__).parent / 'templates' / 'comparison.html.j2'
# More would not be read.
MOST_IN_MAC = 20
NOT_DRAWN = StateDrawn()


@dataclass(frozen=True, slots=True)
class ComparedState:
    """A recording beside the first.

    Parameters
    ----------
    name : str
        Of the recording.
    modes : ModeSet
        Its modes.
    found : ModeComparison
        The first, then this one.
    at : OperatingState
        Joint speed, pose and load while it was made.
    drawn : StateDrawn
        Its spectrum, and its modes on the arm of the first.
    """

    name: str
    modes: ModeSet
    found: ModeComparison
    drawn: StateDrawn = NOT_DRAWN
    at: OperatingState = UNKNOWN_STATE


def write_comparison(
    path: Path,
    first: str,
    modes: ModeSet,
    others: Sequence[ComparedState],
    drawn: StateDrawn = NOT_DRAWN,
    at: OperatingState = UNKNOWN_STATE,
    levels: Sequence[ModeLevels] | None = None,
) -> None:
    """Write the report of recordings beside the first, whole or not at all.

    Parameters
    ----------
    path : Path
        An .html file.
    first : str
        Name of the first.
    modes : ModeSet
        Its modes.
    others : sequence of ComparedState
        The others, in their order.
    drawn : StateDrawn
        Spectrum of the first, and its modes on the arm.
    at : OperatingState
        Joint speed, pose and load of the first.
    levels : sequence of ModeLevels or None
        Its modes over the level of their motion; None: not asked for.
    """
    spectra = [
        spectra_of_both((first, modes, drawn), (each.name, each.modes, each.drawn))
        for each in others
    ]
    shapes = [shapes_of_both(each.found, modes, each.modes, drawn, each.drawn) for each in others]
    charts = {'compared_spectra': spectra, 'mode_shapes': shapes}
    names = ', '.join(each.name for each in others)
    courses = mode_courses(modes, [each.found for each in others])
    states = [at, *(each.at for each in others)]
    named = [first, *(each.name for each in others)]
    values = {
        'first': first,
        'courses': courses_shown(named, states, courses),
        'levels': None if levels is None else levels_shown(named, levels),
        'states': [
            {
                'name': each.name,
                'headline': headline(each.found),
                'table': _table(each.found),
                'mac': _cross_mac(modes, each),
                'damping': damping_of_both(modes, each.modes),
                'spectra': spectra[index],
                'shapes': shapes[index],
            }
            for index, each in enumerate(others)
        ],
    }
    page = Page('Modal comparison', f'{first}, then {names}', TEMPLATE, values, charts)
    write_text(path, render(page))


def headline(found: ModeComparison) -> str:
    """Say in one line what changed."""
    if not found.changes:
        return 'no mode is in both'
    changed = sum(change.is_significant for change in found.changes)
    turned = sum(change.is_shape_changed for change in found.changes)
    return (
        f'{changed} of {count(len(found.changes), "mode")} changed in frequency or damping by'
        f' more than three standard deviations; {turned} changed in shape'
    )


def _table(found: ModeComparison) -> Table:
    columns = (*_both(FREQUENCY), number('Change %'), Cell('In σ', span=2))
    damping = (*_both(DAMPING), Cell('Change in σ', span=2))
    rest = (number(MAC.heading), number('By chance ≥'), text(''))
    rows = [(change.first.frequency_hz, _change_row(change)) for change in found.changes]
    rows += [(mode.frequency_hz, _alone(mode, is_first=True)) for mode in found.only_first]
    rows += [(mode.frequency_hz, _alone(mode, is_first=False)) for mode in found.only_second]
    rows.sort(key=lambda row: row[0])
    headings = [*columns, *damping, *rest]
    return Table('Modes of both', headings, [row for _, row in rows], empty='no modes')


def _both(quantity: Quantity) -> tuple[Cell, Cell]:
    first = Cell(f'First: {quantity.heading}', 'number', 2)
    return first, replace(first, content=f'Then: {quantity.heading}')


def _change_row(change: ModeChange) -> Row:
    first, second = change.first, change.second
    return Row(
        [
            *measured(FREQUENCY, first.frequency_hz, first.frequency_std_hz),
            *measured(FREQUENCY, second.frequency_hz, second.frequency_std_hz),
            number(percent(change.frequency_change, 2, sign=True).removesuffix(' %')),
            *_in_sigma(change.frequency_surprise),
            *measured(DAMPING, first.damping_ratio, first.damping_ratio_std),
            *measured(DAMPING, second.damping_ratio, second.damping_ratio_std),
            *_in_sigma(change.damping_surprise),
            number(fixed(change.mac, 3)),
            number(fixed(change.expected_mac.least, 3)),
            tags(
                ('changed' if change.is_significant else '', 'bad'),
                ('shape changed' if change.is_shape_changed else '', 'doubt'),
            ),
        ]
    )


def _in_sigma(surprise: float) -> tuple[Cell, Cell]:
    return Cell(error_mark(surprise), 'chart'), number(fixed(surprise, 1, sign=True))


def _alone(mode: Mode, *, is_first: bool) -> Row:
    """Return the row of a mode that one recording alone has."""
    frequency = measured(FREQUENCY, mode.frequency_hz, mode.frequency_std_hz)
    damping = measured(DAMPING, mode.damping_ratio, mode.damping_ratio_std)
    none = (number(''), Cell('', 'sigma'))
    aside = (number(''), Cell('', 'chart'), number(''))
    return Row(
        [
            *(frequency if is_first else none),
            *(none if is_first else frequency),
            *aside,
            *(damping if is_first else none),
            *(none if is_first else damping),
            *aside[1:],
            number(''),
            number(''),
            tags(('first alone' if is_first else 'second alone', '')),
        ],
        'aside',
    )


def _cross_mac(first: ModeSet, state: ComparedState) -> Markup:
    """Return the MAC of each mode with each of the other recording, over channels both have."""
    second = state.modes
    names = [name for name in first.channel_names if name in second.channel_names]
    if len(names) < 2 or not 1 <= min(len(first), len(second)):
        return Markup()
    if max(len(first), len(second)) > MOST_IN_MAC:
        return Markup()
    rows, columns = (
        (
            [fixed(mode.frequency_hz, 1) for mode in modes],
            modes.shapes[[modes.channel_names.index(name) for name in names]],
        )
        for modes in (first, second)
    )
    return draw_mac('MAC', rows, columns)
