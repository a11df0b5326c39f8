"""Puts what a command identified into a history."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
import hashlib
import json
import math
from pathlib import Path
from typing import Annotated, TYPE_CHECKING

import typer

from modal_core.errors import SettingsError
from modal_core.files.version import software

if TYPE_CHECKING:
    from modal_core.window import ResultOfWindow
    from modal_history.kept import Circumstances, KeptWindow

CALENDAR_NS = 946_684_800 * 10**9
"""2000-01-01: stamps before it count from some beginning, and are no times of the calendar."""
CHUNK_BYTES = 1 << 20


@dataclass(frozen=True, slots=True)
class Keeping:
    """Where results are kept for years, and what the recording does not tell."""

    history: Annotated[
        Path | None, typer.Option(help='Add the results to this history (`ama history`).')
    ] = None
    tool: Annotated[str, typer.Option(help='For the history: what the robot carries.')] = ''
    temperature_c: Annotated[
        float | None, typer.Option(help='For the history: temperature [°C].')
    ] = None
    load_kg: Annotated[float | None, typer.Option(help='For the history: load \\[kg].')] = None
    at: Annotated[
        str | None,
        typer.Option(
            help='For the history: when the recording began (ISO 8601), where its stamps do not'
            ' tell.'
        ),
    ] = None

    def shift_ns(self, start_ns: int, name: str) -> int:
        """Return what makes the stamps of a recording times of the calendar.

        Raises
        ------
        SettingsError
            Nothing tells when it was made.
        """
        if self.at is not None:
            from modal_history.selection import time_ns

            return time_ns(self.at, '--at') - start_ns
        if start_ns < CALENDAR_NS:
            raise SettingsError(
                'its stamps do not tell when it was made',
                where=name,
                advice='say when it began: --at 2026-05-31T14:00',
            )
        return 0

    def add(
        self, circumstances: 'Circumstances', windows: 'Sequence[ResultOfWindow]', shift_ns: int
    ) -> int:
        """Add windows; return how many are new.

        Raises
        ------
        HistoryError
            They cannot be written; then none is.
        """
        from modal_history.kept import KeptWindow

        kept = [KeptWindow.of(window) for window in windows]
        return self.add_kept(circumstances, kept, shift_ns)

    def add_kept(
        self, circumstances: 'Circumstances', windows: 'Sequence[KeptWindow]', shift_ns: int
    ) -> int:
        """Add windows as they are kept; return how many are new.

        Raises
        ------
        HistoryError
            They cannot be written; then none is.
        """
        from modal_history.store import HistoryWriter

        if self.history is None:
            return 0
        with HistoryWriter(self.history) as writer:
            return writer.add(circumstances, [self.told(each, shift_ns) for each in windows]).n_new

    def told(self, window: 'KeptWindow', shift_ns: int) -> 'KeptWindow':
        """Return a window with what the recording does not tell."""
        return replace(
            window,
            start_ns=window.start_ns + shift_ns,
            end_ns=window.end_ns + shift_ns,
            temperature_c=math.nan if self.temperature_c is None else self.temperature_c,
            load_kg=math.nan if self.load_kg is None else self.load_kg,
        )

    def circumstances(
        self, robot: str, settings: object, recording: Path, known_hash: str = ''
    ) -> 'Circumstances':
        """Return what holds for all windows of a recording; it is read for its hash.

        Raises
        ------
        OSError
            It cannot be read.
        """
        from modal_history.kept import Circumstances

        return Circumstances(
            robot=Path(robot).name,
            tool=self.tool,
            software=software(),
            settings=settings_text(settings),
            recording=recording.name,
            recording_hash=known_hash or file_hash(recording),
        )


def settings_text(settings: object) -> str:
    """Return settings as text, the same for the same settings."""
    from autonomous_modal_analysis.identified.results import plain

    return json.dumps(plain(settings), sort_keys=True)


def file_hash(path: Path) -> str:
    """Return the SHA-256 of a file; of a folder that of its files, by name.

    Raises
    ------
    OSError
        It cannot be read.
    """
    if path.is_dir():
        files = sorted(file for file in path.rglob('*') if file.is_file())
        lines = [f'{file.relative_to(path)} {file_hash(file)}' for file in files]
        return hashlib.sha256('\n'.join(lines).encode()).hexdigest()
    found = hashlib.sha256()
    with path.open('rb') as file:
        while chunk := file.read(CHUNK_BYTES):
            found.update(chunk)
    return found.hexdigest()
