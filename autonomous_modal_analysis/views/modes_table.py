"""Tables of modes for people."""

from collections.abc import Sequence
import math

from rich.markup import escape
from rich.table import Table

from modal_core.mode import Mode
from modal_reports import (
    DAMPING,
    fixed,
    FREQUENCY,
    mark,
    MPC,
    MPD,
    SCATTERED,
    SCATTERED_MEANS,
)


def modes_table(modes: Sequence[Mode], title: str, notes: Sequence[str] = ()) -> Table:
    """Return a table of modes, and of lines marked as harmonic, for people, by frequency.

    Parameters
    ----------
    modes : sequence of Mode
        In any order.
    title : str
        Above the table.
    notes : sequence of str
        One per mode, where there is something to say of each.
    """
    table = Table(title=escape(title), title_justify='left')
    for heading in ('mode', FREQUENCY.label, DAMPING.label, MPC.label, MPD.label, ''):
        table.add_column(heading, justify='right')
    rows = zip(modes, notes or [''] * len(modes), strict=True)
    for mode, note in sorted(rows, key=lambda row: row[0].frequency_hz):
        table.add_row(
            str(mode.id) if mode.id else '',
            FREQUENCY.number(mode.frequency_hz, mode.frequency_std_hz),
            '' if mode.harmonic else DAMPING.number(mode.damping_ratio, mode.damping_ratio_std),
            fixed(mode.mpc, 3),
            fixed(math.degrees(mode.mpd), 1),
            ', '.join(filter(None, (note, mark(mode)))),
        )
    if any(SCATTERED in mark(mode) for mode in modes):
        table.caption = f'{SCATTERED}: {SCATTERED_MEANS}'
        table.caption_justify = 'left'
    return table
