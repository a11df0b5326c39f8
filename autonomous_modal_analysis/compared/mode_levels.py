"""Each mode of several recordings over the level of its motion: `ama compare --levels`."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
import math
from typing import TYPE_CHECKING

import numpy as np

from autonomous_modal_analysis.compared.mode_courses import CoursePoint
from modal_core.errors import SettingsError
from modal_core.mode import Mode
from oma_identifier.levels import (
    level_law,
    LevelLaw,
    LEVELS,
    LevelStiffness,
    ModalMotion,
    ModeRecord,
    motions_at_levels,
    stiffness_at_levels,
)

if TYPE_CHECKING:
    from autonomous_modal_analysis.api.modal_result import ModalResult


@dataclass(frozen=True, slots=True)
class ModeLevels:
    """A mode over levels.

    Parameters
    ----------
    channel : str
        At which motion is meant: the mode's largest.
    mode : Mode
        In the first recording.
    points : tuple of (int, Mode, ModalMotion)
        Number of the recording, mode and motion there, by motion.
    law : LevelLaw or None
        None where the levels do not tell one, see ``reason``.
    reason : str
        Why there is none.
    stiffness : LevelStiffness or None
        At each point; None without points.
    """

    channel: str
    mode: Mode
    points: tuple[tuple[int, Mode, ModalMotion], ...]
    law: LevelLaw | None
    reason: str = ''
    stiffness: LevelStiffness | None = None


def mode_levels(
    results: Sequence['ModalResult'], courses: Sequence[tuple[CoursePoint, ...]]
) -> list[ModeLevels]:
    """Return each mode of the first recording over its levels.

    Parameters
    ----------
    results : sequence of ModalResult
        Of the recordings, the first first.
    courses : sequence of tuple of CoursePoint
        Of each mode of the first.

    Raises
    ------
    SettingsError
        Fewer recordings than tell a law.
    """
    if len(results) < LEVELS.fewest_levels:
        raise SettingsError(
            'too few levels',
            where='--levels',
            found=len(results),
            expected=f'{LEVELS.fewest_levels} recordings at different levels, or more',
        )
    return [_over_levels(results, course) for course in courses]


def _over_levels(results: Sequence['ModalResult'], course: tuple[CoursePoint, ...]) -> ModeLevels:
    shape = course[0].mode.shape
    channels = results[0].found.parts[0].channels
    straight = np.array([each.is_straight for each in channels])
    if not straight.any():
        return ModeLevels('', course[0].mode, (), None, 'no channel along a straight line')
    largest = channels[int(np.argmax(np.where(straight, np.abs(shape), -1.0)))]
    unknown = dict.fromkeys(range(len(results)), 'not found there')
    seen = max(course, key=lambda point: len(results[point.recording].modes))
    there = [point for point in course if largest.name in _names(results[point.recording])]
    unknown |= {point.recording: f'without {largest.name}' for point in course}
    motions = motions_at_levels([_record(results, each, seen, largest.name) for each in there])
    points = []
    for point, motion in zip(there, motions, strict=True):
        if isinstance(motion, str):
            unknown[point.recording] = motion
        else:
            del unknown[point.recording]
            points.append((point.recording, point.mode, motion))
    points.sort(key=lambda each: each[2].displacement_m)
    missing = [f'{results[number].name}: {why}' for number, why in unknown.items()]
    if not points:
        return ModeLevels(largest.name, course[0].mode, (), None, _unseen(points, missing))
    stiffness = stiffness_at_levels([motion for *_, motion in points])
    law, reason = _law(points, missing, stiffness)
    return ModeLevels(largest.name, course[0].mode, tuple(points), law, reason, stiffness)


def _names(result: 'ModalResult') -> list[str]:
    return [each.name for each in result.found.parts[0].channels]


def _record(
    results: Sequence['ModalResult'], point: CoursePoint, seen: CoursePoint, channel: str
) -> ModeRecord:
    """Return a mode in one recording, told from others as where most modes were found.

    What one and the same filter lets through of the others is alike at all levels, and no change
    with the level: shapes found at each, or another mode missed there, had made laws of linear
    structures.
    """
    here, there = results[point.recording], results[seen.recording]
    mode, modes = point.mode, list(here.modes)
    if _names(here) == _names(there):
        mode = replace(mode, shape=seen.mode.shape)
        modes = [mode, *(each for each in there.modes if each is not seen.mode)]
    return ModeRecord(here.found.parts, mode, modes, _names(here).index(channel))


def _law(
    points: Sequence[tuple[int, Mode, ModalMotion]],
    missing: Sequence[str],
    stiffness: LevelStiffness,
) -> tuple[LevelLaw | None, str]:
    """Return the law that the points tell, or why they tell none."""
    if len(points) < LEVELS.fewest_levels:
        return None, _unseen(points, missing)
    if math.isnan(stiffness.off):
        return None, 'it was not refined: its frequency has no standard deviation'
    if not stiffness.told:
        return None, (
            f'what its band holds is {abs(stiffness.off):.1f} half-widths off its frequency:'
            ' other modes are there, which more channels would tell apart'
        )
    moves = [motion.displacement_m for _, _, motion in points]
    if moves[-1] < LEVELS.least_factor * moves[0]:
        return None, f'its levels differ by a factor of {moves[-1] / moves[0]:.1f}'
    law = level_law([motion for *_, motion in points])
    return law, '' if law is not None else 'its stiffness without motion would be negative'


def _unseen(points: Sequence[object], missing: Sequence[str]) -> str:
    known = f'its motion is known in {len(points)} recordings of {LEVELS.fewest_levels}'
    return '; '.join((known, *missing))
