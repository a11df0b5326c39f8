"""Reads a history."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
import json
from pathlib import Path
from typing import Any

import numpy as np

from modal_core.errors import SettingsError
from modal_core.mode import Mode, ModeSet
from modal_core.quality import ChannelQuality, DataQuality
from modal_core.window import Pose
from modal_history.history_file import HistoryFile, OpenHistory
from modal_history.kept import Circumstances, KeptWindow
from modal_history.packing import unpack_deviations, unpack_shapes
from modal_history.schema import SCALARS
from modal_history.selection import Selection
from modal_history.trend import COLUMNS, nothing, Trend, trend_of

OF_FILE = (ValueError, TypeError, KeyError, OverflowError, AttributeError)
"""What values raise that no program of the suite has written."""


@dataclass(frozen=True, slots=True)
class Run:
    """Windows of the same circumstances.

    Parameters
    ----------
    circumstances : Circumstances
        Robot, tool, software, settings, recording.
    n_windows, n_modes : int
        Windows kept, whole recordings not counted; modes seen in them, by id.
    first_ns, last_ns : int [ns]
        Begin of the first and end of the last.
    """

    circumstances: Circumstances
    n_windows: int
    n_modes: int
    first_ns: int
    last_ns: int


class HistoryReader(OpenHistory):
    """An open history, to read.

    Parameters
    ----------
    path : path
        The file; it is not changed, and others may write it meanwhile.

    Raises
    ------
    HistoryError
        It is missing, damaged, of a newer version, or no history.
    """

    def __init__(self, path: str | Path) -> None:
        self.file = HistoryFile(path)

    def robots(self) -> tuple[str, ...]:
        """Return the robots, by name."""
        return tuple(row[0] for row in self._rows('SELECT DISTINCT robot FROM run ORDER BY robot'))

    def robot(self, name: str | None) -> str:
        """Return the robot that is meant: without a name the only one.

        Raises
        ------
        SettingsError
            There is no such robot, or more than one.
        """
        there = self.robots()
        if name in there or (name is None and len(there) <= 1):
            return name or (there[0] if there else '')
        raise SettingsError(
            'no such robot' if name is not None else 'more than one robot',
            where=self.file.path,
            found=name,
            expected=', '.join(map(repr, there)),
            advice='name one with robot (--robot)',
        )

    def runs(self) -> tuple[Run, ...]:
        """Return the runs by time."""
        rows = self._rows(
            'SELECT run.robot, run.tool, run.software, coalesce(settings.text, ""), run.recording,'
            ' run.recording_hash, sum(window.number >= 0), min(window.start_ns),'
            ' max(window.end_ns), run.id FROM run JOIN window ON window.run = run.id'
            ' LEFT JOIN settings ON settings.hash = run.settings_hash'
            ' GROUP BY run.id ORDER BY min(window.start_ns)'.replace('""', "''")
        )
        counts = dict(
            self._rows(
                'SELECT window.run, count(DISTINCT mode.id) FROM mode JOIN window'
                ' ON window.id = mode.window WHERE mode.id > 0 GROUP BY window.run'
            )
        )
        return tuple(
            Run(Circumstances(*row[:6]), row[6], counts.get(row[9], 0), row[7], row[8])
            for row in rows
        )

    def trends(self, selection: Selection) -> tuple[Trend, ...]:
        """Return modes over time, by id.

        Raises
        ------
        HistoryError
            The file is damaged.
        """
        where, values = selection.where()
        found = []
        for number in selection.ids or self.ids(selection):
            rows = self._rows(
                f'SELECT window.start_ns, window.end_ns, window.position, {", ".join(COLUMNS)}'
                ' FROM mode CROSS JOIN window ON window.id = mode.window'
                ' JOIN run ON run.id = window.run'
                f' WHERE mode.id = ? AND {where} ORDER BY window.end_ns',
                [number, *values],
            )
            try:
                found += [trend_of(number, rows)] if rows else []
            except OF_FILE as error:
                raise self.file.damaged(error) from error
        return tuple(found)

    def heard(self, selection: Selection) -> Trend:
        """Return windows in which any mode was found, without their modes, by time.

        Raises
        ------
        HistoryError
            The file is damaged.
        """
        where, values = selection.where()
        rows = self._rows(
            'SELECT window.start_ns, window.end_ns, window.position, NULL, NULL, NULL, NULL,'
            ' window.temperature_c, window.load_kg FROM window JOIN run ON run.id = window.run'
            ' WHERE EXISTS (SELECT 1 FROM mode WHERE mode.window = window.id AND mode.id > 0)'
            f' AND {where} ORDER BY window.end_ns',
            values,
        )
        try:
            return trend_of(0, rows) if rows else nothing(0)
        except OF_FILE as error:
            raise self.file.damaged(error) from error

    def windows(self, selection: Selection) -> Iterator[tuple[Circumstances, KeptWindow]]:
        """Yield windows in the order they were kept, with ids that last over runs.

        Raises
        ------
        HistoryError
            The file is damaged.
        """
        where, values = selection.where()
        # Few at a time, and no cursor left open: a writer need not wait for who reads a month.
        last = 0
        while rows := self._rows(
            'SELECT window.id, run.robot, run.tool, run.software, run.settings_hash,'
            ' run.recording, run.recording_hash, layout.method, layout.channels, layout.joints,'
            ' window.number, window.start_ns, window.end_ns, window.position,'
            ' window.position_range, window.temperature_c, window.load_kg, window.identifiable,'
            ' window.reason, window.flags, window.channel_flags, shape.shape, shape.shape_std'
            ' FROM window JOIN run ON run.id = window.run JOIN layout ON layout.id = window.layout'
            ' LEFT JOIN shape ON shape.window = window.id'
            f' WHERE window.id > ? AND {where} ORDER BY window.id LIMIT 500',
            [last, *values],
        ):
            last = rows[-1][0]
            modes = self._modes(rows[0][0], last)
            for row in rows:
                try:
                    yield self._circumstances(row), _window(row, modes.get(row[0], []))
                except OF_FILE as error:
                    raise self.file.damaged(f'window {row[0]}: {error}') from error

    def names(self, selection: Selection) -> tuple[tuple[str, ...], tuple[str, ...]]:
        """Return all channels and all joints of windows, in the order they appear."""
        where, values = selection.where()
        rows = self._rows(
            'SELECT channels, joints FROM layout WHERE id IN (SELECT window.layout FROM window'
            f' JOIN run ON run.id = window.run WHERE {where}) ORDER BY id',
            values,
        )
        try:
            found = [[json.loads(text) for text in column] for column in zip(*rows, strict=True)]
            channels, joints = (
                tuple(dict.fromkeys(str(name) for names in column for name in names))
                for column in found or ((), ())
            )
        except OF_FILE as error:
            raise self.file.damaged(error) from error
        return channels, joints

    def channel_groups(self, selection: Selection) -> tuple[tuple[str, ...], ...]:
        """Return channels of windows, those together that one set-up shares with another."""
        where, values = selection.where()
        rows = self._rows(
            'SELECT channels FROM layout WHERE id IN (SELECT window.layout FROM window'
            f' JOIN run ON run.id = window.run WHERE {where}) ORDER BY id',
            values,
        )
        groups: list[dict[str, None]] = []
        try:
            for (text,) in rows:
                group = dict.fromkeys(map(str, json.loads(text)))
                for other in [each for each in groups if each.keys() & group.keys()]:
                    groups.remove(other)
                    group = other | group
                groups.append(group)
        except OF_FILE as error:
            raise self.file.damaged(error) from error
        return tuple(tuple(group) for group in groups if group)

    def _circumstances(self, row: Sequence[Any]) -> Circumstances:
        robot, tool, software, settings_hash, recording, recording_hash = row[1:7]
        found = self._rows('SELECT text FROM settings WHERE hash = ?', [settings_hash])
        text = found[0][0] if found else ''
        return Circumstances(robot, tool, software, text, recording, recording_hash)

    def _modes(self, first: int, last: int) -> dict[int, list[dict[str, Any]]]:
        """Return the numbers of modes by window, in the order their shapes are kept."""
        there = self.file.columns('mode')
        names = ['id', *(item.name for item in SCALARS if item.name in there)]
        rows = self._rows(
            f'SELECT window, {", ".join(names)} FROM mode WHERE window BETWEEN ? AND ?'
            ' ORDER BY window, place',
            [first, last],
        )
        found: dict[int, list[dict[str, Any]]] = {}
        for window, *values in rows:
            found.setdefault(window, []).append(dict(zip(names, values, strict=True)))
        return found

    def ids(self, selection: Selection) -> list[int]:
        """Return the modes there are."""
        where, values = selection.where()
        rows = self._rows(
            'SELECT DISTINCT mode.id FROM mode JOIN window ON window.id = mode.window'
            f' JOIN run ON run.id = window.run WHERE mode.id > 0 AND {where} ORDER BY mode.id',
            values,
        )
        return [row[0] for row in rows]

    def _rows(self, words: str, values: Sequence[object] = ()) -> list[tuple[Any, ...]]:
        with self.file.told():
            return self.file.rows.execute(words, tuple(values)).fetchall()


def _window(row: Sequence[Any], modes: list[dict[str, Any]]) -> KeptWindow:
    method, channels, joints, number, start, end, position, spread = row[7:15]
    names = tuple(json.loads(channels))
    return KeptWindow(
        index=number,
        start_ns=start,
        end_ns=end,
        modes=ModeSet(_with_shapes(modes, row[21], row[22], len(names)), names, method),
        quality=DataQuality(
            identifiable=bool(row[17]),
            reason=row[18],
            flags=tuple(json.loads(row[19])),
            channels=tuple(
                ChannelQuality(name, flags=tuple(flags))
                for name, flags in json.loads(row[20]).items()
            ),
        ),
        pose=_pose(joints, position, spread),
        temperature_c=float('nan') if row[15] is None else float(row[15]),
        load_kg=float('nan') if row[16] is None else float(row[16]),
    )


def _with_shapes(
    modes: list[dict[str, Any]], shapes: bytes | None, deviations: bytes | None, n_channels: int
) -> tuple[Mode, ...]:
    """Return modes; shapes that were pruned are NaN."""
    size = (n_channels, len(modes))
    unknown = np.full(size, complex(np.nan, np.nan))
    found = unknown if shapes is None else unpack_shapes(shapes, *size)
    std = unknown if deviations is None else unpack_deviations(deviations, *size)
    return tuple(
        Mode(
            **{item.name: item.read(values, n_channels) for item in SCALARS},
            id=int(values['id']),
            shape=found[:, column],
            shape_std=None if np.isnan(std[:, column]).all() else std[:, column],
        )
        for column, values in enumerate(modes)
    )


def _pose(joints: str, position: bytes | None, spread: bytes | None) -> Pose | None:
    if position is None or spread is None:
        return None
    return Pose(
        tuple(json.loads(joints)), np.frombuffer(position, '<f8'), np.frombuffer(spread, '<f8')
    )
