"""A recording of taps: the force of the hammer and what the structure answers."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from modal_core.errors import RecordingError
from modal_core.samples import Samples
from modal_core.words.named import named

AGAINST = '-'
NAMED = 3
"""Recordings told one by one."""


@dataclass(frozen=True, slots=True)
class Run:
    """Rows that were recorded without a break.

    Parameters
    ----------
    name : str
        Of the recording, for people.
    first, end : int
        Rows: what was struck before the first is not heard after it.
    """

    name: str
    first: int
    end: int


@dataclass(frozen=True, slots=True)
class ImpactRecord:
    """Taps on one point in one direction.

    Parameters
    ----------
    force_n : (n_samples,) array [N]
        Of the hammer, on the grid of the responses.
    responses : Samples
        What the sensors read.
    hit : str
        Channel that would read the motion of the point in the direction of the force, ``-``
        before it where the hammer struck against it: ``elbow.x``, ``-elbow.x``.  It need not be
        among the responses; empty: not known.
    name : str
        Of the recording, for people.
    of_runs : tuple of Run
        Each recorded without a break, in order; empty: all rows are one.
    without_unit : tuple of str
        Whose unit was assumed, force or responses: masses have no scale then.
    """

    force_n: NDArray[np.float64]
    responses: Samples
    hit: str = ''
    name: str = 'recording'
    of_runs: tuple[Run, ...] = ()
    without_unit: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        """Refuse what cannot be a recording of taps.

        Raises
        ------
        RecordingError
            Lengths differ, or a force is not finite.
        """
        if self.force_n.shape != (len(self.responses.acceleration),):
            raise RecordingError(
                'force and responses differ in length',
                where=self.name,
                found=self.force_n.shape,
                expected=f'{len(self.responses.acceleration)} samples',
            )
        if not np.isfinite(self.force_n).all():
            row = int(np.argmin(np.isfinite(self.force_n)))
            raise RecordingError('force is not finite', where=f'{self.name}: row {row + 1}')

    @property
    def runs(self) -> tuple[Run, ...]:
        """What was recorded without a break, in order."""
        return self.of_runs or (Run(self.name, 0, len(self.force_n)),)

    def run_of(self, row: int) -> Run:
        """Return what a row was recorded with."""
        return next(each for each in reversed(self.runs) if each.first <= row)

    @property
    def point(self) -> str:
        """The channel at the point that was hit, without its sign."""
        return self.hit.removeprefix(AGAINST)

    @property
    def sign(self) -> float:
        """-1 where the hammer struck against the channel's direction."""
        return -1.0 if self.hit.startswith(AGAINST) else 1.0

    @property
    def rate_hz(self) -> float:
        """Sample rate [Hz]."""
        return self.responses.sample_rate_hz


def runs_of(record: ImpactRecord) -> list[ImpactRecord]:
    """Return the runs of a record, one by one."""
    return [
        replace(
            record,
            force_n=record.force_n[run.first : run.end],
            responses=record.responses.part(slice(run.first, run.end)),
            name=run.name,
            of_runs=(),
        )
        for run in record.runs
    ]


def together(records: Sequence[ImpactRecord]) -> ImpactRecord:
    """Return records of one point and the same sensors as one, each a run of its own."""
    if len(records) == 1:
        return records[0]
    runs = list[Run]()
    for record in records:
        first = runs[-1].end if runs else 0
        runs += (
            replace(each, first=first + each.first, end=first + each.end) for each in record.runs
        )
    rows = np.concatenate([each.responses.acceleration for each in records])
    return replace(
        records[0],
        force_n=np.concatenate([each.force_n for each in records]),
        responses=replace(records[0].responses, acceleration=rows),
        name=named(list(dict.fromkeys(each.name for each in records)), NAMED),
        of_runs=tuple(runs),
    )
