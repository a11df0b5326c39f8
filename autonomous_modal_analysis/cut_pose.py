"""The pose of a cut: where the task leaves the turn about the spindle free, the best one.

A task holds the tool point and the spindle's direction; a robot of six joints can still turn the
tool about the spindle, and gives way otherwise in each such pose.
"""

from dataclasses import dataclass, replace
import math

import numpy as np
from numpy.typing import NDArray

from autonomous_modal_analysis.campaigns.campaign_poses import is_possible
from excitation_planner.request import PlanRequest
from machining.cut_settings import CutSettings
from machining.lobes import Proposal, stability_lobes
from modal_core.errors import MapError, SettingsError
from modal_core.tool_modes import ToolModes
from modal_core.work.progress import Progress
from workspace_map import tool_modes, turned_poses, TurnedPose, WorkspaceMap

Array = NDArray[np.float64]
SPACING_DEG = 10.0
"""Between poses that are looked at."""
LARGEST_TURN_DEG = 180.0


@dataclass(frozen=True)
class CutPose:
    """One pose and the cut that takes most material there.

    Parameters
    ----------
    turned : TurnedPose
        The pose.
    tool : ToolModes or None
        Modes of the tool point in the axes of the pose that was given; None where the map does
        not know them.
    proposal : Proposal or None
        By the zeroth order; None where no cut is proposed.
    reason : str
        Why there is none; empty where there is one.
    """

    turned: TurnedPose
    tool: ToolModes | None
    proposal: Proposal | None
    reason: str = ''

    @property
    def turn_deg(self) -> float:
        """Turn about the spindle [deg]."""
        return math.degrees(self.turned.turn_rad)

    @property
    def rate_m_rpm(self) -> float:
        """Depth times speed: material per time up to a factor of the cutter [m rpm]."""
        return 0.0 if self.proposal is None else self.proposal.depth_m * self.proposal.speed_rpm


@dataclass(frozen=True)
class PoseChoice:
    """Poses that were looked at, and the best of them.

    Parameters
    ----------
    poses : tuple of CutPose
        By turn.
    best, given : CutPose
        Where most material can be taken, and where the tool is not turned.
    """

    poses: tuple[CutPose, ...]
    best: CutPose
    given: CutPose

    @property
    def gain(self) -> float:
        """Material of the best pose over that of the one given; NaN where that allows no cut."""
        return self.best.rate_m_rpm / self.given.rate_m_rpm if self.given.rate_m_rpm else math.nan


def choose_pose(
    known: WorkspaceMap,
    q: Array,
    settings: CutSettings,
    turn_deg: float,
    progress: Progress = lambda _: None,
) -> PoseChoice:
    """Return the pose with the tool turned about the spindle in which most material can be taken.

    Parameters
    ----------
    known : WorkspaceMap
        Of the arm.
    q : (n_joints,) array [rad]
        Serial joint angles of the pose that is given.
    settings : CutSettings
        The cut; its axes are those of the tool in that pose.
    turn_deg : float [deg]
        Largest turn either way; 0: the pose is not free.
    progress : callable
        Takes the fraction done.

    Raises
    ------
    SettingsError
        The turn is none.
    MapError
        The map knows the modes at none of the poses.
    """
    if not 0.0 <= turn_deg <= LARGEST_TURN_DEG:
        raise SettingsError(
            'no turn', where='turn_deg', found=turn_deg, expected=f'0 to {LARGEST_TURN_DEG:g}'
        )
    reach, spacing = math.radians(turn_deg), math.radians(SPACING_DEG)
    turned = turned_poses(known.arm, q, settings.spindle_axis, reach, spacing)
    poses = []
    for number, each in enumerate(turned):
        poses.append(_looked_at(known, each, settings))
        progress((number + 1) / len(turned))
    (given,) = (pose for pose in poses if pose.turned.turn_rad == 0.0)
    known_poses = [pose for pose in poses if pose.tool is not None]
    if not known_poses:
        raise MapError('the map knows no pose of this cut', found=given.reason)
    # Of poses as good as one another the one that is turned least.
    best = max(known_poses, key=lambda pose: (pose.rate_m_rpm, -abs(pose.turn_deg)))
    return PoseChoice(tuple(poses), best, given)


def _looked_at(known: WorkspaceMap, turned: TurnedPose, settings: CutSettings) -> CutPose:
    if turned.turn_rad != 0.0 and not is_possible(known.arm.model, turned.q, PlanRequest()):
        return CutPose(turned, None, None, 'too near to the floor or the arm itself')
    try:
        modes = known.predict_surely(turned.q)
    except MapError as error:
        return CutPose(turned, None, None, str(error))
    tool = tool_modes(modes).turned(turned.axes)
    found = stability_lobes(tool, replace(settings, theory='mean')).proposals
    if not found:
        return CutPose(turned, tool, None, 'no cut is proposed')
    return CutPose(turned, tool, found[0])
