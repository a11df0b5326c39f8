"""The quickest way from rest to rest under limits on speed, acceleration and jerk.

References
----------
Biagiotti and Melchiorri (2008), Trajectory Planning for Automatic Machines and Robots, section
3.4, doi:10.1007/978-3-540-85629-0.
"""

from bisect import bisect_right
from dataclasses import dataclass
import math


@dataclass(frozen=True, slots=True)
class JerkProfile:
    """Seven stretches of constant jerk.

    Parameters
    ----------
    duration_s : float [s]
        From rest to rest.
    """

    duration_s: float
    _starts: tuple[float, ...]
    _states: tuple[tuple[float, float, float, float], ...]

    def at(self, time_s: float) -> float:
        """Return the way gone, between 0 and the whole."""
        index = bisect_right(self._starts, min(max(time_s, 0.0), self.duration_s)) - 1
        t = min(max(time_s, 0.0), self.duration_s) - self._starts[index]
        way, speed, acceleration, jerk = self._states[index]
        return way + t * (speed + t * (acceleration / 2.0 + t * jerk / 6.0))


def jerk_profile(way: float, speed: float, acceleration: float, jerk: float) -> JerkProfile:
    """Return the profile over a way; limits are positive and in the same unit of way."""
    if speed * jerk >= acceleration**2:
        build_s, rise_s = acceleration / jerk, acceleration / jerk + speed / acceleration
    else:
        build_s = math.sqrt(speed / jerk)
        rise_s = 2.0 * build_s
    cruise_s = way / speed - rise_s
    if cruise_s < 0.0:
        cruise_s, build_s = 0.0, acceleration / jerk
        if way >= 2.0 * acceleration * build_s**2:
            rise_s = build_s / 2.0 + math.sqrt(build_s**2 / 4.0 + way / acceleration)
        else:
            build_s = (way / (2.0 * jerk)) ** (1.0 / 3.0)
            rise_s = 2.0 * build_s
    hold_s = max(rise_s - 2.0 * build_s, 0.0)
    stretches = (
        (build_s, jerk), (hold_s, 0.0), (build_s, -jerk), (cruise_s, 0.0),
        (build_s, -jerk), (hold_s, 0.0), (build_s, jerk),
    )  # fmt: skip
    return _joined(stretches)


def _joined(stretches: tuple[tuple[float, float], ...]) -> JerkProfile:
    starts, states = [], []
    time_s = way = speed = acceleration = 0.0
    for length_s, jerk in stretches:
        starts.append(time_s)
        states.append((way, speed, acceleration, jerk))
        t = length_s
        way += t * (speed + t * (acceleration / 2.0 + t * jerk / 6.0))
        speed += t * (acceleration + t * jerk / 2.0)
        acceleration += t * jerk
        time_s += t
    return JerkProfile(time_s, tuple(starts), tuple(states))
