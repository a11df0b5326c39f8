"""Whether the axes do what they are asked to: where, when, and with the speed of the plan.

Between a reference and the angle that answers it lie wire, law, dead time and servo.  No model of
them is believed: an axis that follows, however late within ``LONGEST_LAG_S``, is where its
reference was lately, moves when it moved, and takes no step faster than the plan.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from robot_bridge.egm import RobotFeedback
from robot_bridge.operator.lateness import Lateness
from robot_bridge.player import PlanPath

Array = NDArray[np.float64]
# Users report up to 80 ms; dead time of 60 ms and a servo of 10 Hz make 86 ms and a cycle.
LONGEST_LAG_S = 0.12
# Encoders, droop and friction leave some hundredths; overshoot and what the servo does not follow
# leave parts of the motion.  See docs/reference/abb.md for the largest seen on emulated arms.
SLACK_DEG, SLACK_OF_REACH = 0.03, 0.5
STEP_SLACK_DEG, FASTEST_OF_PLAN = 0.02, 2.0
# What a reference must have moved before it is asked whether the axis did.
LEAST_MOTION_DEG, MOTION_OF_REACH, MOTION_OF_STEPS = 0.01, 0.1, 5.0
WINDOW_S, EVERY_S = 0.5, 0.1
LEAST_CORRELATION = 0.6
LEAST_CORRELATED_DEG = 0.02
CLOCK_S = 0.1


class FollowingCheck:
    """Compares reference and feedback of one run, cycle by cycle.

    A machine that is not punctual lets the controller run on with its last speed and queues what
    it missed: what lateness has been seen widens what is allowed, up to ``largest_deg``.

    Parameters
    ----------
    path : PlanPath
        What is played.
    hold_deg, feedback : (6,) array [deg], RobotFeedback
        Reference and feedback before the first cycle.
    cycle_s : float [s]
        Period of the controller.
    largest_deg : float [deg]
        Tolerance in any case.
    lateness : Lateness or None
        Of the session, when the reference is ours and comes with the plan's speed; None when it is
        the controller's own.
    """

    def __init__(
        self,
        path: PlanPath,
        hold_deg: Array,
        feedback: RobotFeedback,
        cycle_s: float,
        largest_deg: float,
        lateness: Lateness | None = None,
    ) -> None:
        position, speed = path.coefficients[-1], path.coefficients[-2]
        self._reach = np.abs(position - position[0]).max(axis=0)
        self._speed = np.abs(speed).max(axis=0)
        self._cycle_s, self._largest, self._lateness = cycle_s, largest_deg, lateness
        self._n_window = round(WINDOW_S / cycle_s)
        self._n_every = max(1, round(EVERY_S / cycle_s))
        measured = np.array(feedback.joints_deg)
        self._offset = measured - hold_deg
        n_rows = self._n_window + self._n_lag(lateness.longest_s if lateness else 0.0) + 1
        # Reference and feedback, twice as long as needed so that it is seldom moved.
        self._rows = np.tile(np.stack([np.asarray(hold_deg, float), measured]), (2 * n_rows, 1, 1))
        self._end = n_rows
        self._still = np.zeros(len(measured), int)
        self._quantum = np.full(len(measured), np.inf)
        self._n_cycles = self._next = 0
        self._time_us, self._n_standing, self._clock_ran = feedback.time_us, 0, False

    def fault(self, reference_deg: Array, feedback: RobotFeedback, n_steps: int) -> str:
        """Take one cycle; return what is wrong, empty when nothing is.

        Parameters
        ----------
        reference_deg : (6,) array [deg]
            Asked for in this cycle.
        feedback : RobotFeedback
            What the controller said in it.
        n_steps : int
            Cycles since the one before.
        """
        measured = np.array(feedback.joints_deg)
        step = np.abs(measured - self._rows[self._end - 1, 1])
        self._still = np.where(step > 0.0, 0, self._still + n_steps)
        self._quantum = np.where(step > 0.0, np.minimum(step, self._quantum), self._quantum)
        # A program's stream may skip any number: no more rows than are ever looked at.
        for _ in range(min(n_steps, len(self._rows) // 2)):
            self._append(reference_deg, measured)
        return (
            self._standing_clock(feedback, n_steps)
            or self._jump(step, n_steps)
            or self._away(measured)
            or self._frozen()
            or self._unlike()
        )

    def _append(self, reference: Array, measured: Array) -> None:
        if self._end == len(self._rows):
            half = len(self._rows) // 2
            self._rows[:half] = self._rows[half:]
            self._end = half
        self._rows[self._end] = reference, measured
        self._end += 1
        self._n_cycles += 1

    def _n_lag(self, late_s: float) -> int:
        return round((LONGEST_LAG_S + late_s) / self._cycle_s)

    @property
    def _late_s(self) -> float:
        return self._lateness.worst_s if self._lateness else 0.0

    def _standing_clock(self, feedback: RobotFeedback, n_steps: int) -> str:
        runs = feedback.time_us != self._time_us
        self._clock_ran |= runs
        self._n_standing = 0 if runs else self._n_standing + n_steps
        self._time_us = feedback.time_us
        stands = self._clock_ran and self._n_standing * self._cycle_s > CLOCK_S
        return 'the time of its feedback stands still' if stands else ''

    def _jump(self, step: Array, n_steps: int) -> str:
        if self._lateness is None:
            return ''
        most = FASTEST_OF_PLAN * self._speed * n_steps * self._cycle_s + STEP_SLACK_DEG
        return _named(step > most, step, 'jumped by {:.3f} deg')

    def _away(self, measured: Array) -> str:
        recent = self._rows[self._end - self._n_lag(self._late_s) - 1 : self._end, 0]
        place = measured - self._offset
        away = np.maximum(place - recent.max(axis=0), recent.min(axis=0) - place)
        most = SLACK_DEG + SLACK_OF_REACH * self._reach + self._late_s * self._speed
        over = away > np.minimum(most, self._largest)
        return _named(over, away, 'is {:.2f} deg away from where it should be')

    def _frozen(self) -> str:
        n_lag = self._n_lag(self._late_s)
        for axis in np.flatnonzero(self._still > n_lag):
            first = self._end - min(int(self._still[axis]), self._end)
            asked = self._rows[first : self._end - n_lag, 0, axis]
            if np.ptp(asked) > self._least(axis, LEAST_MOTION_DEG):
                return f'the feedback of axis {axis + 1} is frozen'
        return ''

    def _unlike(self) -> str:
        """Compare the last half second, once in a while and when every reply was in time."""
        n_lag = self._n_lag(self._late_s)
        n_rows = self._n_window + n_lag
        calm = self._lateness is None or self._lateness.n_calm >= n_rows
        if self._n_cycles < self._next or not calm or 2 * n_lag > self._n_window:
            return ''
        self._next = self._n_cycles + self._n_every
        rows = self._rows[self._end - n_rows : self._end]
        for axis in range(rows.shape[2]):
            asked, got = rows[:, 0, axis], rows[n_lag:, 1, axis]
            # Where the answer falls into the window, whatever its delay.
            if np.ptp(asked[n_lag:-n_lag]) < self._least(axis, LEAST_CORRELATED_DEG):
                continue
            likeness = _correlation(asked, got)
            if likeness < LEAST_CORRELATION:
                return (
                    f'axis {axis + 1} does not move as it is asked to (correlation {likeness:.2f})'
                )
        return ''

    def _least(self, axis: int | np.integer[Any], least_deg: float) -> float:
        """Return how far a reference must go before its answer shows, over all resolutions."""
        quantum = self._quantum[axis]
        resolution = MOTION_OF_STEPS * quantum if np.isfinite(quantum) else 0.0
        return float(max(least_deg, MOTION_OF_REACH * self._reach[axis], resolution))


def _correlation(asked: Array, got: Array) -> float:
    """Return the largest correlation of an answer with what was asked, over all delays."""
    windows = np.lib.stride_tricks.sliding_window_view(asked, len(got))
    centred = windows - windows.mean(axis=1, keepdims=True)
    answer = got - got.mean()
    power = np.linalg.norm(centred, axis=1) * np.linalg.norm(answer)
    product = centred @ answer
    return float(np.max(product / np.where(power > 0.0, power, np.inf)))


def _named(wrong: NDArray[np.bool_], size: Array, text: str) -> str:
    if not wrong.any():
        return ''
    axis = int(np.argmax(np.where(wrong, size, -np.inf)))
    return f'axis {axis + 1} {text.format(size[axis])}'
