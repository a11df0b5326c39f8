"""Turn a path into one reference per controller cycle: ramp-in, override, stop, hold."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modal_core.settings.schema import setting
from robot_bridge.player.plan_path import PlanPath

Array = NDArray[np.float64]
# Of the path's own peak speed, what a change of the amplitude may add on any axis.
GAIN_SHARE = 0.05
STEEPEST_STEP = 1.875  # of smooth_step, in the middle
TINY = 1e-9


@dataclass(frozen=True, slots=True)
class PlayerSettings:
    """How a path is played.

    Parameters
    ----------
    ramp_in_s : float [s]
        Time over which the amplitude, or the speed of a path of moves, grows from nothing.
    stop_ramp_s : float [s]
        Time over which the motion slows down to standstill when it is stopped.
    override_rate_per_s : float [1/s]
        Fastest change of the speed override.

    A path that goes far slowly takes longer for a change of the override: its speed is the
    distance from the start times the rate of the change.
    """

    ramp_in_s: float = setting(1.0, 'time over which the amplitude grows [s]', 0.01, 60.0)
    stop_ramp_s: float = setting(0.05, 'time from an abort to standstill [s]', 0.004, 5.0)
    override_rate_per_s: float = 1.0


@dataclass(frozen=True, slots=True)
class Reference:
    """What is asked of the controller for one cycle.

    Parameters
    ----------
    position_deg : (6,) array [deg]
        Axis angles now.
    speed_deg_s : (6,) array [deg/s]
        Mean speed until the next cycle.
    """

    position_deg: Array
    speed_deg_s: Array


class PlanPlayer:
    """Plays one path from where the arm stands.

    The amplitude about the start pose is path x gain: the gain is the ramp-in times the speed
    override, so that at half override every speed and acceleration is half and the spectrum keeps
    its shape.  A path that goes far within the ramp-in, as moves do, would be faster for a growing
    gain: there the time along the path speeds up from nothing instead.  Stopping slows that time
    down to nothing, so the axes come to rest where they are and are not sent back.

    Parameters
    ----------
    path : PlanPath
        What to play.
    hold_deg : (6,) array [deg]
        Where the arm is held now; any small distance to the path's start is closed in the ramp-in.
    settings : PlayerSettings
        Ramps.
    override : float
        Speed override it begins with, 0..1.
    """

    def __init__(
        self,
        path: PlanPath,
        hold_deg: Array,
        settings: PlayerSettings,
        override: float = 1.0,
    ) -> None:
        self._path = path
        gain_rate = GAIN_SHARE * path.quickest_1_s
        self._override_rate = min(settings.override_rate_per_s, gain_rate)
        self._grows = _ramps_gently(path, settings.ramp_in_s)
        self._ramp_in_s = settings.ramp_in_s if self._grows else ramp_of_time_s(path, settings)
        self._stop_ramp_s = settings.stop_ramp_s
        self._offset = np.asarray(hold_deg, float) - path.start_deg
        self._time_s = 0.0
        self._ramp = 0.0
        self._played_s = 0.0
        self._pace = 1.0
        self._override = self.override_target = override
        self._stopping = False
        self._position = np.array(hold_deg, float)

    @property
    def progress(self) -> float:
        """Fraction of the path played."""
        return min(self._time_s / self._path.duration_s, 1.0)

    @property
    def at_rest(self) -> bool:
        """Nothing moves any more: stopped, or at the end."""
        return self._pace <= 0.0 or self._time_s >= self._path.duration_s

    @property
    def position_deg(self) -> Array:
        """Axis angles asked for last, (6,) [deg]."""
        return self._position

    def stop(self) -> None:
        """Begin to slow down to standstill."""
        self._stopping = True

    def step(self, cycle_s: float) -> Reference:
        """Return the reference of this cycle and move on to the next."""
        here = self._position
        if not self.at_rest:
            self._advance(cycle_s)
            self._position = self._blend()
        return Reference(here, (self._position - here) / cycle_s)

    def _advance(self, cycle_s: float) -> None:
        if self._stopping:
            self._pace = max(self._pace - cycle_s / self._stop_ramp_s, 0.0)
        else:
            change = self._override_rate * cycle_s
            target = min(max(self.override_target, 0.0), 1.0)
            self._override += min(max(target - self._override, -change), change)
        self._played_s += self._pace * cycle_s
        self._ramp = smooth_step(self._played_s / self._ramp_in_s)
        pace = self._pace if self._grows else self._pace * self._ramp
        self._time_s = min(self._time_s + pace * cycle_s, self._path.duration_s)

    def _blend(self) -> Array:
        start = self._path.start_deg
        moved = self._path.position(self._time_s) - start
        gain = self._override * (self._ramp if self._grows else 1.0)
        return np.asarray(start + (1.0 - self._ramp) * self._offset + gain * moved)


def ramp_of_time_s(path: PlanPath, settings: PlayerSettings) -> float:
    """Return how long the time along a path speeds up [s]: at most 5 % more acceleration for it.

    Speeding up adds the path's speed times its rate to the acceleration of an axis.
    """
    moved = path.coefficients[-1] - path.start_deg
    speed, acceleration = (_peak(moved, order) / path.sample_period_s**order for order in (1, 2))
    needed = STEEPEST_STEP * speed / (GAIN_SHARE * np.maximum(acceleration, TINY))
    return max(settings.ramp_in_s, float(np.max(needed)))


def _ramps_gently(path: PlanPath, ramp_s: float) -> bool:
    """Return whether growing over this time adds at most 5 % to peak speed and acceleration."""
    moved = path.coefficients[-1] - path.start_deg
    time_s = np.arange(len(moved)) * path.sample_period_s
    grown = np.array([smooth_step(time / ramp_s) for time in time_s])[:, None] * moved
    return all(
        np.all(_peak(grown, order) <= (1.0 + GAIN_SHARE) * _peak(moved, order)) for order in (1, 2)
    )


def _peak(moved: Array, order: int) -> Array:
    """Return the largest difference of an order on each axis."""
    return np.asarray(np.max(np.abs(np.diff(moved, order, axis=0)), axis=0, initial=0.0))


def smooth_step(u: float) -> float:
    """Return the quintic from 0 to 1 with no speed and no acceleration at its ends."""
    u = min(max(u, 0.0), 1.0)
    return u * u * u * (10.0 + u * (6.0 * u - 15.0))
