"""Which sensors of a record changed, and when: those without which all others go on as before."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from oma_identifier.synchrony.change_kind import change_kind, CHANGED, SHAPE
from oma_identifier.synchrony.clock_drift import DRIFTS, drifts_of, without_drift
from oma_identifier.synchrony.course_misfit import misfit, parted
from oma_identifier.synchrony.peak_course import Course
from oma_identifier.synchrony.sensor_peaks import Columns
from oma_identifier.synchrony.thresholds import SYNCHRONY

MOST_SUSPECTS = 4
"""Sensors that break most, one or two of which may be those that changed."""
MOST_DOUBTFUL = 3
"""Sensors, all combinations of which are tried where too few bear witness."""
N_MOMENTS = 64
"""Moments between which a change is placed."""


@dataclass(frozen=True, slots=True)
class Change:
    """Sensors that are not what they were.

    Parameters
    ----------
    sensors : tuple of str
        Which.
    kind : str
        Flag; ``shape_changed`` where it may as well be the structure that changed.
    from_ns, to_ns : int [ns]
        Between which times it happened.
    is_sure : bool
        The others say that these sensors changed; else any of them may have.
    """

    sensors: tuple[str, ...]
    kind: str
    from_ns: int
    to_ns: int
    is_sure: bool


def find_change(
    courses: Sequence[Course], columns: Columns, moments: NDArray[np.int64]
) -> Change | None:
    """Look for sensors that changed at one of several moments.

    Parameters
    ----------
    courses : sequence of Course
        Of the peaks.
    columns : mapping of str to int array
        Channels of each sensor.
    moments : (n_moments,) int64 array [ns]
        Rising.
    """
    heat = _Heat.of(courses, columns, moments)
    if not heat.suspects.any():
        return None
    place = int(np.argmax(np.where(heat.suspects.any(axis=0), heat.broken.sum(axis=0), -1)))
    out = _changed(courses, columns, moments[place])
    if not out:
        broken = tuple(
            name for name, hot in zip(columns, heat.suspects[:, place], strict=True) if hot
        )
        drifting = _drifting(courses, columns, moments)
        return (
            drifting
            or _doubtful(courses, columns, moments)
            or Change(broken, SHAPE, *_when(courses, columns, broken[:1], moments)[::2], False)
        )
    # The moments tried first are far apart: who changed is clearer at the true one.
    when = _when(courses, columns, out, moments)
    out = _changed(courses, columns, when[1]) or out
    changed = [columns[name] for name in out]
    others = [own for name, own in columns.items() if name not in out]
    kind = change_kind(courses, changed, others, when[1])
    if kind is None and (drifting := _drifting(courses, columns, moments)):
        return drifting
    return Change(out, kind or SHAPE, when[0], when[2], kind is not None)


def _changed(courses: Sequence[Course], columns: Columns, moment: int) -> tuple[str, ...]:
    """Return the one or two sensors without which all others go on; none where it is not they."""
    moments = np.array([moment])
    hottest = _Heat.of(courses, columns, moments).hottest(columns)
    found = []
    for size in range(1, min(SYNCHRONY.most_changed, len(columns) // 2) + 1):
        for names in combinations(hottest, size):
            left = {name: own for name, own in columns.items() if name not in names}
            heat = _Heat.of(courses, left, moments)
            if len(left) >= SYNCHRONY.fewest_left and not heat.suspects.any():
                # Without one more, less is left that can break by chance.
                found.append((int(heat.broken.sum()) + size, names))
    return min(found)[1] if found else ()


@dataclass(frozen=True, slots=True)
class _Heat:
    """At how many peaks each sensor is seen, and breaks: (n_sensors, n_moments) arrays."""

    seen: NDArray[np.int64]
    broken: NDArray[np.int64]

    @classmethod
    def of(
        cls, courses: Sequence[Course], columns: Columns, moments: NDArray[np.int64]
    ) -> '_Heat':
        sensors = list(columns.values())
        found = [misfit(course, sensors, moments) for course in courses]
        return cls(
            np.array(
                [sum(f.seen[:, own].any(axis=1).astype(int) for f in found) for own in sensors]
            ),
            np.array(
                [sum(f.broken[:, own].any(axis=1).astype(int) for f in found) for own in sensors]
            ),
        )

    @property
    def suspects(self) -> NDArray[np.bool_]:
        """Whether a sensor breaks at many peaks, (n_sensors, n_moments) array."""
        many = self.broken >= SYNCHRONY.share_of_peaks * self.seen
        return many & (self.broken >= SYNCHRONY.fewest_peaks)

    def hottest(self, columns: Columns) -> list[str]:
        """Return the sensors that break most at the first moment."""
        share = self.broken[:, 0] / np.maximum(self.seen[:, 0], 1)
        return [
            list(columns)[index] for index in np.argsort(-share, kind='stable')[:MOST_SUSPECTS]
        ]


def _drifting(
    courses: Sequence[Course], columns: Columns, moments: NDArray[np.int64]
) -> Change | None:
    """Return the sensor without whose clock's drift nothing breaks; None where there is none."""
    for name, rate in drifts_of(courses, columns):
        turned = [without_drift(course, columns[name], rate) for course in courses]
        if not _Heat.of(turned, columns, moments).suspects.any():
            return Change((name,), DRIFTS, int(moments[0]), int(moments[-1]), True)
    return None


def _doubtful(
    courses: Sequence[Course], columns: Columns, moments: NDArray[np.int64]
) -> Change | None:
    """Return a change that too few others bear witness of, where one kind of it explains all."""
    if len(columns) > MOST_DOUBTFUL:
        return None
    for size in range(1, len(columns)):
        for names in combinations(columns, size):
            others = [own for name, own in columns.items() if name not in names]
            when = _when(courses, columns, names, moments)
            if change_kind(courses, [columns[name] for name in names], others, when[1]):
                return Change(tuple(columns), CHANGED, when[0], when[2], False)
    return None


def _when(
    courses: Sequence[Course],
    columns: Columns,
    out: Sequence[str],
    moments: NDArray[np.int64],
) -> tuple[int, int, int]:
    """Return the first, the likeliest and the last moment at which sensors may have changed."""
    fine = np.linspace(moments[0], moments[-1], N_MOMENTS).astype(np.int64)
    own = np.concatenate([columns[name] for name in out])
    others = [each for name, each in columns.items() if name not in out]
    likelihood = np.sum([parted(course, own, others, fine) for course in courses], axis=0)
    likely = fine[likelihood > likelihood.max() - SYNCHRONY.unlikely_moment]
    # A row of a narrow band tells no more exactly when it was.
    step = int(np.median([course.step_ns for course in courses]))
    return int(likely[0]) - step, int(fine[np.argmax(likelihood)]), int(likely[-1]) + step
