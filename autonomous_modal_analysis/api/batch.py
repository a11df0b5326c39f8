"""Many recordings at once."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Unpack

from autonomous_modal_analysis.api.result import Columns, Result
from autonomous_modal_analysis.api.settings import checked_settings, Settings
from autonomous_modal_analysis.batch.row import Row
from autonomous_modal_analysis.batch.run import BatchRequest, run_batch
from autonomous_modal_analysis.batch.table import headline
from autonomous_modal_analysis.console.option_groups import Identifier, Reading
from autonomous_modal_analysis.console.terminal import no_progress, ProgressCallback
from autonomous_modal_analysis.identified.keeping import Keeping


@dataclass(frozen=True, eq=False, repr=False)
class Batch(Result):
    """What became of many recordings, a row each.

    Parameters
    ----------
    rows : tuple of Row
        In the order they were named.
    folder : Path
        With the manifest and a folder of results per recording.
    """

    rows: tuple[Row, ...]
    folder: Path

    def headline(self) -> str:
        """Say how many were identified."""
        return headline(self.rows)

    def columns(self) -> Columns:
        """Return one row per recording."""
        values = [row.values() for row in self.rows]
        return {name: [each[name] for each in values] for name in values[0]}

    def shown(self) -> Columns:
        """Return the rows as people read them."""
        return {
            'recording': [Path(row.recording).name for row in self.rows],
            'modes': ['' if row.error else str(row.n_modes) for row in self.rows],
            'length [s]': ['' if row.error else f'{row.duration_s:.6g}' for row in self.rows],
            'error': [row.error for row in self.rows],
        }

    def to_dict(self) -> dict[str, Any]:
        """Return what ``ama batch --json`` prints."""
        return {'recordings': [row.values() for row in self.rows]}


def batch(
    recordings: Sequence[str | Path],
    out: str | Path,
    *,
    resume: bool = False,
    workers: int | None = None,
    scheduler: str | None = None,
    history: str | Path | None = None,
    layout: str | Path | None = None,
    robot: str | None = None,
    reading: Mapping[str, Any] | None = None,
    export: Sequence[str] = (),
    progress: ProgressCallback = no_progress,
    **settings: Unpack[Settings],
) -> Batch:
    """Identify many recordings, each into a folder of its own, as ``ama batch`` does.

    Work is handed to processes by Dask distributed (``pip install distributed``), which start
    by importing the program that calls this: call it under ``if __name__ == '__main__':``.

    Parameters
    ----------
    recordings : sequence of path
        Files or folders, as for :func:`autonomous_modal_analysis.open`.
    out : path
        Folder for ``manifest.jsonl``, ``manifest.csv`` and a folder of results per recording.
    resume : bool
        Go on with what is there: what is done, unchanged and asked the same is not done again.
    workers : int or None
        Processes on this machine; None: one per processor.
    scheduler : str or None
        Address of a Dask scheduler whose workers see the same files.
    history : path or None
        History that gets the results.
    layout : path or None
        Places and directions of the channels.
    robot : str or None
        Name or folder of the robot.
    reading : mapping or None
        ``topic``, ``sample_rate_hz``, ``unit``, ``channels``, ``mark``, as options of the
        command.
    export : sequence of str
        Endings of files of other programs with the modes, ``.uff``, beside each one's results.
    progress : callable
        Told the fraction done, 0..1.
    **settings
        As for :func:`autonomous_modal_analysis.identify`.

    Returns
    -------
    Batch

    Raises
    ------
    ModalAnalysisError
        The folder holds another batch, or nobody can work on it.
    """
    request = BatchRequest(
        recordings=tuple(Path(each) for each in recordings),
        out=Path(out),
        reading=Reading(**(reading or {})),
        identifier=Identifier(
            settings=checked_settings(settings), layout=_path(layout), robot=robot
        ),
        keeping=Keeping(history=_path(history)),
        resume=resume,
        scheduler=scheduler,
        n_workers=workers,
        endings=tuple(export),
    )
    rows = run_batch(request, progress)
    return Batch(tuple(rows), request.out)


def _path(given: str | Path | None) -> Path | None:
    return None if given is None else Path(given)
