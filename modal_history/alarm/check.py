"""Looks for changes in a history, again and again."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from modal_history.alarm.baseline import Baseline, BaselineSettings, learn
from modal_history.alarm.latched import Alarm, alarms_of
from modal_history.alarm.locate import locate, LONGEST_NS
from modal_history.alarm.missing import Presence, presence_of
from modal_history.alarm.part import Part
from modal_history.alarm.robot_parts import RobotParts
from modal_history.alarm.watch import (
    Change,
    LOST,
    lost,
    needed_since,
    SOAKED_NS,
    watch,
    Watched,
    WatchSettings,
)
from modal_history.reader import HistoryReader
from modal_history.selection import FIRST_NS, Selection
from modal_history.trend import nothing, Trend

# Robot, mode, since when its baseline is learnt.
Key = tuple[str, int, int]


@dataclass(frozen=True, slots=True)
class Checked:
    """What a check found.

    Parameters
    ----------
    watched : tuple of Watched
        Modes that were held against their baseline.
    learning : tuple of int
        Modes whose baseline is not complete.
    new : tuple of Alarm
        Not kept yet.
    told : tuple of Alarm
        Kept ones of which more is known now: which part it is.
    """

    watched: tuple[Watched, ...]
    learning: tuple[int, ...]
    new: tuple[Alarm, ...]
    told: tuple[Alarm, ...] = ()


@dataclass(frozen=True, slots=True)
class Learnt:
    """A baseline, where its mode used to be found, and since when results must be known."""

    baseline: Baseline
    presence: Presence | None
    since_ns: int


class AlarmCheck:
    """Holds the modes of a history against their baselines, again and again.

    Parameters
    ----------
    baseline : BaselineSettings
        How long is learnt.
    watching : WatchSettings
        How often an alarm may be false.
    parts : RobotParts or None
        Models of the robots: which part has changed.
    """

    def __init__(
        self,
        baseline: BaselineSettings,
        watching: WatchSettings,
        parts: RobotParts | None = None,
    ) -> None:
        self._settings, self._watching, self._parts = baseline, watching, parts
        self._known: dict[Key, Learnt] = {}
        self._n_seen: dict[int, int] = {}

    def check(self, reader: HistoryReader, robot: str) -> Checked:
        """Return what is new; nothing is written.

        Raises
        ------
        HistoryError
            The file is damaged.
        """
        known = [alarm for alarm in alarms_of(reader.file) if alarm.robot == robot]
        begins = {a.change.id: a.change.since_ns for a in known if not a.is_open}
        opened = {alarm.change.id: alarm for alarm in known if alarm.is_open}
        keys = [(robot, n, begins.get(n, FIRST_NS)) for n in reader.ids(Selection(robot))]
        trends = {key: self._trend(reader, key) for key in keys if key[1] not in opened}
        learnt = {key: self._learn(reader, key, trend) for key, trend in trends.items()}
        ready = [key for key, found in learnt.items() if found is not None]
        watched = [self._watch(reader, key, trends[key], len(ready)) for key in ready]
        new = [Alarm(0, robot, each.change) for each in watched if each.change]
        kept = [alarm for alarm in opened.values() if self._is_longer(reader, alarm)]
        told = [replace(a, part=self._part(reader, keys, a.change)) for a in (*new, *kept)]
        return Checked(
            watched=tuple(watched),
            # A mode that was found no more, and is taken note of, is not waited for.
            learning=tuple(k[1] for k in learnt if learnt[k] is None and len(trends[k])),
            new=tuple(alarm for alarm in told if not alarm.number),
            told=tuple(a for a in told if a.number and a.part != opened[a.change.id].part),
        )

    def _trend(self, reader: HistoryReader, key: Key) -> Trend:
        """Return what of a mode is not known yet, and as much before as it takes."""
        robot, number, begin = key
        since = self._known[key].since_ns if key in self._known else begin
        (trend,) = reader.trends(Selection(robot, (number,), since)) or (nothing(number),)
        return trend.rows((trend.start_ns >= begin).nonzero()[0])

    def _learn(self, reader: HistoryReader, key: Key, trend: Trend) -> Learnt | None:
        """Return the baseline of a mode; None while it is too short."""
        if key in self._known:
            return self._known[key]
        baseline = learn(trend, self._settings)
        if baseline is None:
            return None
        heard = reader.heard(Selection(key[0], (), int(trend.time_ns[0]), baseline.end_ns))
        presence = presence_of(heard, trend, baseline.covariates)
        self._known[key] = Learnt(baseline, presence, int(trend.time_ns[0]))
        return self._known[key]

    def _watch(self, reader: HistoryReader, key: Key, trend: Trend, n_modes: int) -> Watched:
        """Hold a mode against its baseline, and see whether it is still found."""
        known = self._known[key]
        found = watch(trend, known.baseline, n_modes, self._watching)
        if found.change is None and known.presence is not None:
            heard = reader.heard(Selection(key[0], (), int(trend.time_ns[-1]) + 1))
            change = lost(heard, known.presence, key[1], n_modes, self._watching)
            found = replace(found, change=change)
        self._known[key] = replace(known, since_ns=needed_since(trend, known.baseline))
        return found

    # -- which part ------------------------------------------------------------------------------

    def _is_longer(self, reader: HistoryReader, alarm: Alarm) -> bool:
        """Return whether more results since a change are there than were when it was last seen."""
        since_ns = alarm.change.since_ns
        asked = Selection(alarm.robot, (), since_ns, since_ns + LONGEST_NS)
        before, now = self._n_seen.get(alarm.number, 0), len(reader.heard(asked))
        self._n_seen[alarm.number] = now
        return now != before

    def _part(self, reader: HistoryReader, keys: Sequence[Key], change: Change) -> Part | None:
        """Return which part of the robot a change goes back to; None without a model."""
        if self._parts is None or change.kind == LOST or not keys:
            return None
        robot, since_ns = keys[0][0], change.since_ns
        arm = self._parts.arm(robot)
        if arm is None:
            return None
        usual = {key[1]: self._learn(reader, key, self._trend(reader, key)) for key in keys}
        baselines = {
            number: found.baseline
            for number, found in usual.items()
            if found is not None and found.baseline.end_ns < change.raised_ns
        }
        since_ns = max([since_ns, *(each.end_ns for each in baselines.values())])
        until_ns = since_ns + LONGEST_NS
        early = Selection(robot, tuple(baselines), since_ns - SOAKED_NS, until_ns)
        windows = (each for _, each in reader.windows(Selection(robot, (), since_ns, until_ns)))
        return locate(arm, windows, reader.trends(early), baselines, since_ns)
