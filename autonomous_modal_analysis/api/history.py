"""A history of results: which runs it holds, and how modes moved over months."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from autonomous_modal_analysis.api.result import Columns, Result
from autonomous_modal_analysis.api.robot import read_robot
from autonomous_modal_analysis.identified.results import plain
from modal_core.measurements import NANOSECONDS_PER_SECOND
from modal_history.alarm import (
    Alarm,
    AlarmCheck,
    alarms_of,
    BaselineSettings,
    Change,
    Checked,
    keep_alarms,
    RobotParts,
    WatchSettings,
)
from modal_history.reader import HistoryReader, Run
from modal_history.selection import FIRST_NS, LAST_NS, Selection, time_ns, time_text
from modal_history.trend import COLUMNS, Trend
from modal_reports import count, DAMPING, FREQUENCY, listed

MOST_NAMED = 3
"""Channels of a group named one by one: those of a sensor of three axes."""


@dataclass(frozen=True, eq=False, repr=False)
class Trends(Result):
    """Modes of one robot over time, one row per estimate.

    Parameters
    ----------
    robot : str
        Whose.
    trends : tuple of Trend
        By id, each with arrays of times, frequencies, damping, σ, temperature, load, joints.
    channel_groups : tuple of tuple of str
        Channels whose shapes can be held against one another.
    """

    robot: str
    trends: tuple[Trend, ...]
    channel_groups: tuple[tuple[str, ...], ...] = ()

    def headline(self) -> str:
        """Say how many modes there are, and where no shape tells that they are the same."""
        n = sum(map(len, self.trends))
        said = f'{count(len(self.trends), "mode")} of {self.robot or "a robot"}, {n} estimates'
        if len(self.channel_groups) < 2:
            return said
        groups = '; '.join(listed(group, MOST_NAMED) for group in self.channel_groups)
        return (
            f'{said}\nnote: recordings with no channel in common ({groups}): modes are the same by'
            ' frequency alone; another structure wants a history, or a name, of its own'
        )

    def columns(self) -> Columns:
        """Return one row per estimate, mode by mode; times in seconds since 1970."""
        found: dict[str, list[Any]] = {'id': [], 'start_time_s': [], 'end_time_s': []}
        n_joints = max((trend.position.shape[1] for trend in self.trends), default=0)
        for trend in self.trends:
            found['id'] += [trend.id] * len(trend)
            found['start_time_s'] += (trend.start_ns / NANOSECONDS_PER_SECOND).tolist()
            found['end_time_s'] += (trend.time_ns / NANOSECONDS_PER_SECOND).tolist()
            for name in COLUMNS:
                found.setdefault(name, []).extend(getattr(trend, name).tolist())
            for joint in range(n_joints):
                known = joint < trend.position.shape[1]
                values = trend.position[:, joint] if known else np.full(len(trend), np.nan)
                found.setdefault(f'position_{joint + 1}_rad', []).extend(values.tolist())
        return found

    def shown(self) -> Columns:
        """Return one row per mode."""
        ends = [(time_text(int(t.time_ns[0])), time_text(int(t.time_ns[-1]))) for t in self.trends]
        return {
            'mode': [str(trend.id) for trend in self.trends],
            'seen': [str(len(trend)) for trend in self.trends],
            FREQUENCY.label: [_middle(FREQUENCY, t.frequency_hz) for t in self.trends],
            DAMPING.label: [_middle(DAMPING, t.damping_ratio) for t in self.trends],
            'first': [first for first, _ in ends],
            'last': [last for _, last in ends],
        }

    def to_dict(self) -> dict[str, Any]:
        """Return what ``ama history trends --json`` prints."""
        found: Any = plain({'robot': self.robot, 'trends': [asdict(t) for t in self.trends]})
        return dict(found)


@dataclass(frozen=True, eq=False, repr=False)
class Alarms(Result):
    """Modes that changed beyond chance, pose, load and temperature.

    Parameters
    ----------
    alarms : tuple of Alarm
        Those that are kept, then those just found (number 0).
    checked : mapping of str to Checked
        By robot, what was held against a baseline and what is still being learnt.
    """

    alarms: tuple[Alarm, ...]
    checked: dict[str, Checked]

    def headline(self) -> str:
        """Say how many are open, and what could be told at all."""
        n_open = sum(alarm.is_open for alarm in self.alarms)
        said = [f'{count(n_open, "open alarm")}']
        for robot, found in self.checked.items():
            of = f'{robot}: ' if robot else ''
            told = [
                f'mode {each.id} from {100.0 * each.detectable:.2g} %'
                for each in found.watched
                if each.change is None and each.detectable == each.detectable
            ]
            if told:
                said.append(f'{of}changes are told of {", ".join(told)}')
            if found.learning:
                said.append(f'{of}{count(len(found.learning), "mode")} still being learnt')
        return '\nnote: '.join(said)

    def columns(self) -> Columns:
        """Return one row per alarm; times in seconds since 1970."""
        changes = [alarm.change for alarm in self.alarms]
        return {
            'number': [alarm.number for alarm in self.alarms],
            'robot': [alarm.robot for alarm in self.alarms],
            'id': [change.id for change in changes],
            'raised_time_s': [change.raised_ns / NANOSECONDS_PER_SECOND for change in changes],
            'since_time_s': [change.since_ns / NANOSECONDS_PER_SECOND for change in changes],
            'share': [change.share for change in changes],
            'share_std': [change.share_std for change in changes],
            'surprise': [change.surprise for change in changes],
            'bound': [change.bound for change in changes],
            'kind': [change.kind for change in changes],
            'part': [_part(alarm) for alarm in self.alarms],
            'open': [alarm.is_open for alarm in self.alarms],
        }

    def shown(self) -> Columns:
        """Return one row per alarm as texts."""
        changes = [alarm.change for alarm in self.alarms]
        return {
            'alarm': [str(alarm.number or 'new') for alarm in self.alarms],
            'robot': [alarm.robot for alarm in self.alarms],
            'mode': [str(change.id) for change in changes],
            'frequency [%]': [_moved(change) for change in changes],
            'part': [_part(alarm) or '-' for alarm in self.alarms],
            'since': [time_text(change.since_ns) for change in changes],
            'state': ['open' if alarm.is_open else 'acknowledged' for alarm in self.alarms],
        }

    def to_dict(self) -> dict[str, Any]:
        """Return what ``ama history alarms --json`` prints."""
        columns = self.columns()
        rows = [
            dict(zip(columns, values, strict=True))
            for values in zip(*columns.values(), strict=True)
        ]
        watched = {
            robot: [
                {'id': each.id, 'n': each.n, 'detectable_share': each.detectable}
                for each in found.watched
            ]
            for robot, found in self.checked.items()
        }
        learning = {robot: found.learning for robot, found in self.checked.items()}
        found: Any = plain({'alarms': rows, 'watched': watched, 'learning': learning})
        return dict(found)


@dataclass(frozen=True, eq=False, repr=False)
class History(Result):
    """Results kept in one file; :func:`autonomous_modal_analysis.history` returns it.

    The file is opened for each question, so that it can be asked while a node writes it.

    Parameters
    ----------
    path : Path
        The file.
    """

    path: Path

    @cached_property
    def runs(self) -> tuple[Run, ...]:
        """Runs by time, as they are at the first use."""
        with HistoryReader(self.path) as reader:
            return reader.runs()

    def trends(
        self,
        robot: str | None = None,
        ids: Sequence[int] = (),
        since: str | None = None,
        until: str | None = None,
        whole: bool = False,
    ) -> Trends:
        """Return modes over time.

        Parameters
        ----------
        robot : str or None
            Whose; None: the only one.
        ids : sequence of int
            Which modes; empty: all.
        since, until : str or None
            Times of ISO 8601, UTC where no zone is given.
        whole : bool
            Whole recordings in place of their windows.

        Raises
        ------
        ModalAnalysisError
            There is no such robot, or the file is damaged.
        """
        with HistoryReader(self.path) as reader:
            name = reader.robot(robot)
            asked = selection(name, ids, since, until, whole)
            return Trends(name, reader.trends(asked), reader.channel_groups(asked))

    def alarms(
        self,
        robot: str | None = None,
        *,
        baseline_days: float = BaselineSettings.days,
        false_a_month: float = WatchSettings.false_a_month,
        model: str | Path | None = None,
        keep: bool = False,
    ) -> Alarms:
        """Hold modes against their baselines; see :doc:`/explanation/alarms`.

        Parameters
        ----------
        robot : str or None
            Whose; None: all robots.
        baseline_days : float [days]
            How long what is usual is learnt, from a mode's first result on.
        false_a_month : float
            How many alarms may be false.
        model : str, path or None
            Robot, its folder or its model file: which part has changed.  None: the shipped robot
            of the name in the history, where there is one.
        keep : bool
            Keep new alarms in the file until they are acknowledged.

        Raises
        ------
        ModalAnalysisError
            There is no such robot, or the file is damaged or cannot be written.
        """
        if model is not None:
            # What is named must be there; what is guessed need not.
            read_robot(model)
        check = AlarmCheck(
            BaselineSettings(days=baseline_days),
            WatchSettings(false_a_month=false_a_month),
            RobotParts(str(model or '')),
        )
        with HistoryReader(self.path) as reader:
            robots = reader.robots() if robot is None else (reader.robot(robot),)
            checked = {name: check.check(reader, name) for name in robots}
            new = tuple(alarm for found in checked.values() for alarm in found.new)
            told = tuple(alarm for found in checked.values() for alarm in found.told)
        if keep and (new or told):
            keep_alarms(self.path, (*new, *told))
            new = told = ()
        with HistoryReader(self.path) as reader:
            known = tuple(alarm for alarm in alarms_of(reader.file) if alarm.robot in robots)
        more = {alarm.number: alarm for alarm in told}
        return Alarms((*(more.get(alarm.number, alarm) for alarm in known), *new), checked)

    def export(
        self,
        file: str | Path,
        robot: str | None = None,
        since: str | None = None,
        until: str | None = None,
        whole: bool = False,
    ) -> int:
        """Write modes with their shapes as .csv, .parquet, .mat or .nc, one row each.

        The first two are written a part at a time, however long the history.

        Parameters
        ----------
        file : path
            Written whole or not at all.
        robot, since, until, whole
            As for :meth:`trends`.

        Returns
        -------
        int
            Rows written.

        Raises
        ------
        ModalAnalysisError
            Another kind of file, no such robot, or a package is not installed.
        """
        from autonomous_modal_analysis.export.history_table import export_history

        with HistoryReader(self.path) as reader:
            asked = selection(reader.robot(robot), (), since, until, whole)
            return export_history(Path(file), reader, asked)

    def headline(self) -> str:
        """Say how much it holds."""
        n = sum(run.n_windows for run in self.runs)
        return f'History {self.path.name}: {count(len(self.runs), "run")}, {n} windows'

    def columns(self) -> Columns:
        """Return the runs."""
        runs = self.runs
        return {
            **{
                name: [getattr(run.circumstances, name) for run in runs]
                for name in ('robot', 'tool', 'software', 'recording', 'recording_hash')
            },
            'settings_hash': [run.circumstances.settings_hash for run in runs],
            'n_windows': [run.n_windows for run in runs],
            'n_modes': [run.n_modes for run in runs],
            'first_time_s': [run.first_ns / NANOSECONDS_PER_SECOND for run in runs],
            'last_time_s': [run.last_ns / NANOSECONDS_PER_SECOND for run in runs],
        }

    def shown(self) -> Columns:
        """Return the runs as texts."""
        runs = self.runs
        return {
            'robot': [run.circumstances.robot for run in runs],
            'tool': [run.circumstances.tool for run in runs],
            'recording': [run.circumstances.recording or 'live' for run in runs],
            'windows': [str(run.n_windows) for run in runs],
            'modes': [str(run.n_modes) for run in runs],
            'first': [time_text(run.first_ns) for run in runs],
            'last': [time_text(run.last_ns) for run in runs],
        }

    def to_dict(self) -> dict[str, Any]:
        """Return what ``ama history list --json`` prints."""
        columns = self.columns()
        rows = [
            dict(zip(columns, values, strict=True)) | {'settings': run.circumstances.settings}
            for run, values in zip(self.runs, zip(*columns.values(), strict=True), strict=True)
        ]
        found: Any = plain({'runs': rows})
        return dict(found)


def history(path: str | Path) -> History:
    """Open a history that ``ama identify --history`` or the node ``modal_history`` wrote.

    Parameters
    ----------
    path : path
        The file; it is not changed.

    Returns
    -------
    History

    Raises
    ------
    ModalAnalysisError
        It is missing, damaged, of a newer version, or no history.
    """
    found = History(Path(path))
    with HistoryReader(found.path):
        return found


def selection(
    robot: str,
    ids: Sequence[int] = (),
    since: str | None = None,
    until: str | None = None,
    whole: bool = False,
) -> Selection:
    """Return what is asked for, of times as people write them.

    Raises
    ------
    SettingsError
        No time.
    """
    first = FIRST_NS if since is None else time_ns(since, 'since')
    last = LAST_NS if until is None else time_ns(until, 'until')
    return Selection(robot, tuple(ids), first, last, whole)


def _moved(change: Change) -> str:
    if change.kind == 'lost':
        return 'not found any more'
    return f'{100.0 * change.share:+.2f} ± {100.0 * change.share_std:.2f}'


def _part(alarm: Alarm) -> str:
    return alarm.part.words() if alarm.part is not None else ''


def _middle(quantity: Any, values: Any) -> str:
    """Return the median with the scatter of the single estimates."""
    middle = float(np.median(values))
    return str(quantity.number(middle, 1.4826 * float(np.median(np.abs(values - middle)))))
