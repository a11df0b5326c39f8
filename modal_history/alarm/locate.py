"""Brings what modes do since a change together with what the parts of a robot would do."""

from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from modal_history.alarm.arm_parts import ArmParts
from modal_history.alarm.baseline import Baseline
from modal_history.alarm.evidence import Evidence, evidence_of
from modal_history.alarm.part import Part
from modal_history.alarm.suspects import weigh
from modal_history.kept import KeptWindow
from modal_history.trend import Trend

LONGEST_NS = 86_400 * 10**9
"""Results after a change that are looked at: what wanders for hours is told no better by more."""
MOST_WINDOWS = 300
"""Of them, evenly taken: an eighth of the deviation of one result is less than what wanders."""


def locate(
    arm: ArmParts,
    windows: Iterable[KeptWindow],
    trends: Sequence[Trend],
    baselines: Mapping[int, Baseline],
    since_ns: int,
) -> Part:
    """Return which part of the robot changed.

    Parameters
    ----------
    arm : ArmParts
        The robot's model.
    windows : iterable of KeptWindow
        Since the change, by time, with ids of the history.
    trends : sequence of Trend
        The same results as trends, and those before that tell how warm the robot is.
    baselines : mapping of int to Baseline
        What was usual, by mode.
    since_ns : int [ns]
        When the change began.
    """
    seen = [window for window in windows if window.start_ns >= since_ns]
    terms = arm.terms(seen[:: max(1, -(-len(seen) // MOST_WINDOWS))])
    modes: list[Evidence] = []
    for trend in trends:
        if trend.id not in terms or trend.id not in baselines or not len(trend):
            continue
        baseline, mine = baselines[trend.id], terms[trend.id]
        found = baseline.departures(trend)
        # A window may not be kept twice in a trend, nor without what the baseline depends on.
        _, rows, there = np.intersect1d(found.trend.time_ns, mine.time_ns, return_indices=True)
        if len(rows):
            modes.append(evidence_of(found.at(rows), baseline.wander, mine.terms[there]))
    return weigh(arm.parts, modes)
