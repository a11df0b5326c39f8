"""Measure a series of motions into a map; one that was interrupted goes on where it stopped."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from autonomous_modal_analysis.api.recording import open_recording
from autonomous_modal_analysis.campaigns.campaign_recording import is_whole, Player
from autonomous_modal_analysis.mapping.series import asked_of, MapWish, OF_INTEREST, Series
from excitation_planner.plan import ExcitationPlan
from modal_core.channel import SensorLayout
from modal_core.errors import IdentificationError, MapError
from modal_core.work.progress import Progress
from structural_model.equations import random_poses
from workspace_map import load_map, MeasuredPose, save_map, WorkspaceMap

MAP_FILE, SERIES_FILE = 'map.json', 'series.json'
SURE = 0.9
"""Of the frequencies of the workspace, that shall be as sure as was asked."""


@dataclass(frozen=True)
class MappingFolder:
    """Where a map and its recordings go.

    Parameters
    ----------
    path : Path
        Folder.
    layout : SensorLayout
        Sensors of the map.
    """

    path: Path
    layout: SensorLayout

    @property
    def map_path(self) -> Path:
        """The map's file."""
        return self.path / MAP_FILE

    def recording(self, number: int) -> Path:
        """Return the file of a pose's recording, counted from 0."""
        return self.path / f'pose_{number + 1:02d}.mcap'

    def series(self, start: WorkspaceMap, wish: MapWish) -> Series | None:
        """Return the series of this wish that was planned before, None where there is none."""
        path = self.path / SERIES_FILE
        if not path.exists():
            return None
        found = Series.load(path)
        return found if found.asked == asked_of(start, self.layout, wish) else None

    def keep(self, series: Series) -> None:
        """Write a series beside the map."""
        series.save(self.path / SERIES_FILE)

    def begun(self, start: WorkspaceMap, series: Series) -> WorkspaceMap:
        """Return the map as it stands: empty, or what an earlier run of the series left.

        Raises
        ------
        MapError
            The folder holds a map of another series, robot, tool or layout.
        """
        if not self.map_path.exists():
            return start
        arm = start.arm
        known, made_by = load_map(self.map_path, arm.model, self.layout, arm.tool)
        if made_by != series.series_hash:
            raise MapError(
                'the folder holds a map of another series', where=self.map_path,
                advice='choose another --out, or remove the folder',
            )  # fmt: skip
        return known


def measure(
    folder: MappingFolder,
    start: WorkspaceMap,
    series: Series,
    wish: MapWish,
    play: Player,
    tell: Callable[[str], None],
    progress: Progress = lambda _: None,
    travel: Callable[[ExcitationPlan], None] | None = None,
) -> WorkspaceMap:
    """Measure poses until the map is as sure as wanted; the file is written after every pose.

    Parameters
    ----------
    folder : MappingFolder
        Where it goes; what is there already is kept.
    start : WorkspaceMap
        Without measured poses.
    series : Series
        What was released.
    wish : MapWish
        Accuracy wanted.
    play : callable
        Plays a plan and leaves its recording.
    tell, progress : callable
        Told what happens, in words and as the fraction done.
    travel : callable or None
        Moves the arm along a way; None: the player brings it to each pose itself.
    """
    known = folder.begun(start, series)
    for number, stop in enumerate(series.stops):
        label = f'pose {number + 1} of {len(series.stops)}'
        if any(pose.plan_hash == stop.plan_hash for pose in known.measured):
            tell(f'{label}: kept')
            continue
        if len(known.measured) > 1 and (left := unsure(known, wish)) <= wish.accuracy:
            tell(f'{label}: not needed, frequencies are known to {100 * left:.2f} %')
            break
        plan = series.excitation(start.arm.model, folder.layout, wish, stop)
        if travel is not None and number and not is_whole(folder.recording(number), plan):
            travel(series.way(start.arm.model, folder.layout, wish, number))
        pose = _measured(folder, number, plan, start, play)
        known = known.with_measured(pose)
        save_map(folder.map_path, known, folder.layout, series.series_hash)
        tell(f'{label}: {len(pose)} modes; frequencies known to {100 * unsure(known, wish):.2f} %')
        progress((number + 1) / len(series.stops))
    return known


def unsure(known: WorkspaceMap, wish: MapWish) -> float:
    """Return the σ over value that nine of ten frequencies of the workspace keep."""
    generator = np.random.default_rng([wish.seed, 7])
    poses = random_poses(known.arm.model.limits, OF_INTEREST, generator)[::2]
    found = [known.predict(q) for q in poses]
    return float(
        np.quantile(np.concatenate([f.frequency_std_hz / f.frequency_hz for f in found]), SURE)
    )


def _measured(
    folder: MappingFolder, number: int, plan: ExcitationPlan, start: WorkspaceMap, play: Player
) -> MeasuredPose:
    """Play, identify and return the modes of a pose; a whole recording is not played again."""
    path = folder.recording(number)
    if not is_whole(path, plan):
        folder.path.mkdir(parents=True, exist_ok=True)
        play(plan, path, lambda _: None)
    q = plan.position.mean(axis=0)
    try:
        result = open_recording(path).identify(robot=start.arm.model, layout=folder.layout)
    except IdentificationError:
        return _nothing(q, start, plan)
    names = [channel.name for channel in start.arm.channels]
    return MeasuredPose.of(q, result.modes, names, plan.duration_s, plan.plan_hash)


def _nothing(q: np.ndarray, start: WorkspaceMap, plan: ExcitationPlan) -> MeasuredPose:
    none, shapes = np.zeros(0), np.zeros((len(start.arm.channels), 0))
    return MeasuredPose(q, none, none, none, none, shapes, shapes, plan.duration_s, plan.plan_hash)
