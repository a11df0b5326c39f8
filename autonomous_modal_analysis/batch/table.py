"""What people see of a batch."""

from collections.abc import Iterator, Sequence

from autonomous_modal_analysis.batch.row import Row
from modal_reports import count

MOST_NAMED = 20
"""Recordings named on the terminal; the manifest has all."""


def headline(rows: Sequence[Row]) -> str:
    """Say in one line what a batch came to."""
    right = [row for row in rows if not row.error]
    n_modes = sum(row.n_modes for row in right)
    length_s = sum(row.duration_s for row in right)
    return (
        f'{len(right)} of {count(len(rows), "recording")} identified:'
        f' {count(n_modes, "mode")} in {length_s:.6g} s of data'
    )


def failures(rows: Sequence[Row]) -> Iterator[str]:
    """Yield a line for each recording without a result, for people; of many the first."""
    failed = [row for row in rows if row.error]
    for row in failed[:MOST_NAMED]:
        said = row.error if row.recording in row.error else f'{row.recording}: {row.error}'
        yield f'failed: {said}'
    if len(failed) > MOST_NAMED:
        yield f'... {len(failed) - MOST_NAMED} more, see the manifest'
