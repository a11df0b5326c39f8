"""Many recordings, each identified where a worker is free; what is done stays done."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
import hashlib
from pathlib import Path
from typing import Any

from autonomous_modal_analysis.api.optional import optional
from autonomous_modal_analysis.batch.job import BatchJob, identify_job, Outcome
from autonomous_modal_analysis.batch.manifest import Manifest, open_manifest
from autonomous_modal_analysis.batch.row import Row
from autonomous_modal_analysis.batch.workers import connected
from autonomous_modal_analysis.console.option_groups import Identifier, Reading
from autonomous_modal_analysis.console.terminal import ProgressCallback
from autonomous_modal_analysis.export import check_endings, ending_of, ENDINGS
from autonomous_modal_analysis.identified.keeping import Keeping
from modal_core.errors import SettingsError
from modal_core.files.real_path import real_path


@dataclass(frozen=True, slots=True)
class BatchRequest:
    """What is asked of many recordings.

    Parameters
    ----------
    recordings : tuple of Path
        Files or folders.
    out : Path
        Folder for the manifest and a folder of results each.
    reading : Reading
        How each is read.
    identifier : Identifier
        How each is identified.
    keeping : Keeping
        Where results are kept for years.
    resume : bool
        Go on with a batch that was stopped; what is done and unchanged is not done again.
    scheduler : str or None
        Address of a Dask scheduler; None: processes on this machine.
    n_workers : int or None
        How many of these; None: one per processor.
    endings : tuple of str
        Of files of other programs that the modes are written into, ``.uff``.

    Raises
    ------
    SettingsError
        There is no recording, or something is asked that holds for one recording only.
    """

    recordings: tuple[Path, ...]
    out: Path
    reading: Reading = field(default_factory=Reading)
    identifier: Identifier = field(default_factory=Identifier)
    keeping: Keeping = field(default_factory=Keeping)
    resume: bool = False
    scheduler: str | None = None
    n_workers: int | None = None
    endings: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        """Refuse what cannot be meant."""
        if not self.recordings:
            raise SettingsError('no recording is named', where='ama batch')
        if self.keeping.at is not None:
            raise SettingsError('recordings began at different times', where='--at')
        if self.n_workers is not None and self.n_workers < 1:
            raise SettingsError(
                'out of range', where='--workers', found=self.n_workers, expected='1 or more'
            )

        check_endings(map(Path, self.endings), ENDINGS)

    def jobs(self, done: dict[str, Row]) -> list[BatchJob]:
        """Return one job per recording, each with a folder of its own."""
        paths = list(dict.fromkeys(map(real_path, self.recordings)))
        stems = [path.stem for path in paths]
        taken = {row.folder: row.recording for row in done.values()}
        return [
            BatchJob(
                recording=path,
                folder=real_path(self.out / _folder(path, stems, done, taken)),
                reading=self.reading,
                identifier=self.identifier,
                keeping=self.keeping,
                done=done.get(str(path)),
                endings=tuple(ending_of(Path(each)) for each in self.endings),
            )
            for path in paths
        ]


def run_batch(request: BatchRequest, progress: ProgressCallback) -> list[Row]:
    """Identify recordings; return a row each, in the order they were named.

    Results appear as they come: a folder each, a line of the manifest, an entry of the history.
    ``progress`` is told the fraction of recordings done, 0..1.

    Raises
    ------
    BatchError
        The folder holds another batch, or nobody can work on it.
    HistoryError, OSError
        Results cannot be kept; what is in the manifest stays done.
    """
    with open_manifest(request.out, request.resume) as manifest:
        jobs = request.jobs(manifest.rows)
        _run(jobs, request, manifest, progress)
        manifest.write_table()
        return [manifest.rows[str(job.recording)] for job in jobs]


def _run(
    jobs: Sequence[BatchJob],
    request: BatchRequest,
    manifest: Manifest,
    progress: ProgressCallback,
) -> None:
    distributed = optional('distributed')
    progress(0.0)
    with connected(request.scheduler, request.n_workers) as client:
        by_key = {}
        for job in jobs:
            future = client.submit(identify_job, job, pure=False)
            by_key[future] = job
        # Results are fetched side by side: one that died with its worker is computed again, and
        # the rows of all that are done meanwhile must not wait for it.
        done = distributed.as_completed(list(by_key), with_results=True, raise_errors=False)
        for n_done, (future, found) in enumerate(done, 1):
            outcome = _outcome(found, by_key.pop(future), distributed)
            if outcome.is_new:
                _keep(outcome, request.keeping, manifest)
            progress(n_done / len(jobs))


def _outcome(found: Any, job: BatchJob, distributed: Any) -> Outcome:
    """Return what became of a job; workers that die of one recording again and again tell so."""
    if isinstance(found, Outcome):
        return found
    # A recording that cannot be handed over is a row: type, error and trace, or the error alone.
    error = found[1] if isinstance(found, tuple) else found
    if isinstance(error, distributed.KilledWorker):
        deaths = f'{error.allowed_failures + 1} workers ended from outside while they worked on it'
    else:
        deaths = f'{type(error).__name__}: {error}'
    return Outcome(replace(job.row, error=deaths))


def _keep(outcome: Outcome, keeping: Keeping, manifest: Manifest) -> None:
    """Keep results in the history, then in the manifest: what that names is done wholly."""
    if outcome.circumstances is not None:
        keeping.add_kept(outcome.circumstances, outcome.windows, 0)
    manifest.add(outcome.row)


def _folder(path: Path, stems: Sequence[str], done: dict[str, Row], taken: dict[str, str]) -> str:
    """Return the name of a recording's folder: its own name, and a hash where two share that."""
    if str(path) in done:
        return done[str(path)].folder
    if stems.count(path.stem) == 1 and path.stem not in taken:
        return path.stem
    return f'{path.stem}-{hashlib.sha256(str(path).encode()).hexdigest()[:8]}'
