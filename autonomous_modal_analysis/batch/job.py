"""One recording of a batch: identified, saved, and told in a row. Runs where the worker is."""

from dataclasses import dataclass, replace
import hashlib
import logging
from pathlib import Path
import time
from typing import TYPE_CHECKING

from autonomous_modal_analysis.batch.row import Row
from autonomous_modal_analysis.console.option_groups import Identifier, Reading
from autonomous_modal_analysis.console.terminal import no_progress
from autonomous_modal_analysis.identified.keeping import file_hash, Keeping, settings_text
from autonomous_modal_analysis.views.output import JSON_NAME
from modal_core.errors import ModalAnalysisError
from modal_core.files.version import software, suite_version

if TYPE_CHECKING:
    from modal_history.kept import Circumstances, KeptWindow

log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class BatchJob:
    """One recording to identify.

    Parameters
    ----------
    recording : Path
        Absolute.
    folder : Path
        Where its results go, absolute.
    reading : Reading
        How it is read.
    identifier : Identifier
        How it is identified.
    keeping : Keeping
        What its results in a history need to be told.
    done : Row or None
        What an earlier batch found of it.
    endings : tuple of str
        Of files of other programs that its modes are written into, ``.uff``.
    """

    recording: Path
    folder: Path
    reading: Reading
    identifier: Identifier
    keeping: Keeping
    done: Row | None = None
    endings: tuple[str, ...] = ()

    @property
    def asked(self) -> str:
        """What is asked of the recording, and by which software: the same text, the same work."""
        text = settings_text((self.reading, self.identifier)) + suite_version()
        text += ''.join(self.endings)
        return hashlib.sha256(text.encode()).hexdigest()

    @property
    def row(self) -> Row:
        """What is known of the recording before it is read."""
        return Row(
            recording=str(self.recording),
            folder=self.folder.name,
            asked=self.asked,
            software=software(),
        )


@dataclass(frozen=True, slots=True)
class Outcome:
    """What became of a job.

    Parameters
    ----------
    row : Row
        For the manifest.
    is_new : bool
        The recording was identified now; False where an earlier batch had done it.
    circumstances : Circumstances or None
        For the history, where one is kept.
    windows : tuple of KeptWindow
        For the history, times of the calendar.
    """

    row: Row
    is_new: bool = True
    circumstances: 'Circumstances | None' = None
    windows: 'tuple[KeptWindow, ...]' = ()


def identify_job(job: BatchJob) -> Outcome:
    """Identify a recording and save its results; what it lacks becomes a row, never an error."""
    start_s = time.monotonic()
    row = job.row
    try:
        row = replace(row, sha256=file_hash(job.recording))
        if job.done is not None and job.done.holds(row) and (job.folder / JSON_NAME).is_file():
            return Outcome(job.done, is_new=False)
        outcome = _identified(job, row)
    except ModalAnalysisError as error:
        outcome = Outcome(replace(row, error=str(error)))
    except OSError as error:
        outcome = Outcome(replace(row, error=error.strerror or str(error)))
    except MemoryError:
        outcome = Outcome(replace(row, error='memory ran out'))
    except Exception as error:
        # Whatever this recording does, the others go on, and it is said in its row.
        log.debug('%s', job.recording, exc_info=True)
        outcome = Outcome(replace(row, error=f'{type(error).__name__}: {error}'))
    return replace(outcome, row=replace(outcome.row, seconds=time.monotonic() - start_s))


def _identified(job: BatchJob, row: Row) -> Outcome:
    recording = job.reading.open_file(job.recording)
    keeping = job.keeping
    is_kept = keeping.history is not None
    shift_ns = keeping.shift_ns(recording.info.start_ns, recording.name) if is_kept else 0
    result = job.identifier.identify(recording, no_progress)
    result.save(job.folder)
    for ending in job.endings:
        result.export((job.folder / JSON_NAME).with_suffix(ending))
    row = replace(
        row,
        n_modes=len(result.modes),
        n_windows=len(result.windows),
        duration_s=recording.duration_s,
        remarks=(*result.damage, *result.remarks),
    )
    if not is_kept:
        return Outcome(row)
    from autonomous_modal_analysis.identified.plan_record import recorded_robot_name
    from modal_history.kept import KeptWindow

    kept = [*map(KeptWindow.of, result.windows), KeptWindow.of(result.found.whole)]
    robot = job.identifier.robot or recorded_robot_name(recording.source)
    settings = result.found.identification.settings
    return Outcome(
        row,
        circumstances=keeping.circumstances(robot, settings, job.recording, row.sha256),
        windows=tuple(keeping.told(window, shift_ns) for window in kept),
    )
