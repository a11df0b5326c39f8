"""Adds results to a history."""

from collections.abc import Sequence
from dataclasses import dataclass
import json
import math
from pathlib import Path

from modal_core.mode import Mode, ModeSet
from modal_history.history_file import HistoryFile, OpenHistory
from modal_history.kept import Circumstances, KeptWindow
from modal_history.packing import pack_deviations, pack_shapes
from modal_history.schema import SCALARS
from modal_history.shared_ids import SharedIds

WINDOW = (
    'INSERT INTO window (run, layout, number, start_ns, end_ns, position, position_range,'
    ' temperature_c, load_kg, identifiable, reason, flags, channel_flags)'
    f' VALUES ({", ".join("?" * 13)})'
)
MODE = (
    f'INSERT INTO mode (window, place, id, own_id, {", ".join(item.name for item in SCALARS)})'
    f' VALUES ({", ".join("?" * (4 + len(SCALARS)))})'
)


@dataclass(frozen=True, slots=True)
class Added:
    """What became of windows.

    Parameters
    ----------
    modes : tuple of ModeSet
        Of each window, with ids that last over runs; empty for one that was there before.
    n_new : int
        How many were written.
    """

    modes: tuple[ModeSet, ...]
    n_new: int


class HistoryWriter(OpenHistory):
    """Adds windows to a history, each as a whole; what was added is on the disk.

    Parameters
    ----------
    path : path
        The file, made when missing.

    Raises
    ------
    HistoryError
        It cannot be written, is damaged, or of a newer version.
    """

    def __init__(self, path: str | Path) -> None:
        self.file = HistoryFile(path, write=True)
        self._ids = SharedIds(self.file)

    def add(self, circumstances: Circumstances, windows: Sequence[KeptWindow]) -> Added:
        """Add windows in order of time; what is there already is not added again.

        Parameters
        ----------
        circumstances : Circumstances
            Of all of them.
        windows : sequence of KeptWindow
            All are written, or none.

        Raises
        ------
        HistoryError
            They cannot be written; the file is as it was.
        """
        try:
            with self.file.change():
                run = self._run(circumstances)
                new = [window for window in windows if not self._is_there(run, window)]
                linked = {
                    id(window): self._ids.link(circumstances.robot, window) for window in new
                }
                for window in new:
                    self._insert(run, window, linked[id(window)])
                if new:
                    self._ids.save(circumstances.robot)
        except BaseException:
            self._ids.forget()
            raise
        none = ModeSet((), ())
        return Added(tuple(linked.get(id(window), none) for window in windows), len(new))

    def _run(self, values: Circumstances) -> int:
        rows = self.file.rows
        settings = values.settings_hash
        if settings:
            rows.execute(
                'INSERT OR IGNORE INTO settings VALUES (?, ?)', (settings, values.settings)
            )
        rows.execute(
            'INSERT OR IGNORE INTO run (key, robot, tool, software, settings_hash, recording,'
            ' recording_hash) VALUES (?, ?, ?, ?, ?, ?, ?)',
            (
                values.key,
                values.robot,
                values.tool,
                values.software,
                settings,
                values.recording,
                values.recording_hash,
            ),
        )
        return int(rows.execute('SELECT id FROM run WHERE key = ?', (values.key,)).fetchone()[0])

    def _is_there(self, run: int, window: KeptWindow) -> bool:
        found = self.file.rows.execute(
            'SELECT 1 FROM window WHERE run = ? AND number = ? AND start_ns = ?',
            (run, window.index, window.start_ns),
        )
        return found.fetchone() is not None

    def _layout(self, window: KeptWindow) -> int:
        joints = window.pose.joint_names if window.pose else ()
        names = [json.dumps(part) for part in (window.modes.channel_names, joints)]
        key = (window.modes.method, *names)
        rows = self.file.rows
        rows.execute(
            'INSERT OR IGNORE INTO layout (method, channels, joints) VALUES (?, ?, ?)', key
        )
        found = rows.execute(
            'SELECT id FROM layout WHERE method = ? AND channels = ? AND joints = ?', key
        )
        return int(found.fetchone()[0])

    def _insert(self, run: int, window: KeptWindow, linked: ModeSet) -> None:
        rows, pose, quality = self.file.rows, window.pose, window.quality
        cursor = rows.execute(
            WINDOW,
            (
                run,
                self._layout(window),
                window.index,
                window.start_ns,
                window.end_ns,
                pose.position.astype('<f8').tobytes() if pose else None,
                pose.position_range.astype('<f8').tobytes() if pose else None,
                _known(window.temperature_c),
                _known(window.load_kg),
                quality.identifiable,
                quality.reason,
                json.dumps(quality.flags),
                json.dumps({each.name: each.flags for each in quality.channels if each.flags}),
            ),
        )
        number = cursor.lastrowid
        owns = sorted(window.modes, key=lambda mode: mode.harmonic)
        rows.executemany(
            MODE,
            [
                (number, place, mode.id, own.id, *_scalars(mode))
                for place, (mode, own) in enumerate(zip(linked, owns, strict=True))
            ],
        )
        if len(linked):
            shapes = (pack_shapes(linked.shapes), pack_deviations(linked.shapes_std))
            rows.execute('INSERT INTO shape VALUES (?, ?, ?)', (number, *shapes))


def _scalars(mode: Mode) -> list[float | None]:
    return [_known(getattr(mode, item.name)) for item in SCALARS]


def _known(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None
