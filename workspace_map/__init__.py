"""Modes and tool-point response of an arm at every pose, from a few measured ones.

In come the arm's flexible-joint model and modes that were measured at some poses; out go modes
with their covariance at any pose, the response of the tool point, and where to measure next.
"""

from workspace_map.arm import Arm, ToolPoint, turned_poses, TurnedPose
from workspace_map.following import Carried, carried_on, Followed, followed_from, Named
from workspace_map.map_file import (
    layout_fingerprint,
    load_map,
    load_other_map,
    model_fingerprint,
    save_map,
)
from workspace_map.measured_pose import MeasuredPose
from workspace_map.next_pose import Candidates, candidates, choose_series
from workspace_map.predicted import PredictedModes
from workspace_map.tool_point import (
    receptance,
    tool_modes,
    tool_point_response,
    ToolPointResponse,
)
from workspace_map.workspace_map import LARGEST_STD, WorkspaceMap

__all__ = [
    'LARGEST_STD',
    'Arm',
    'Candidates',
    'Carried',
    'Followed',
    'MeasuredPose',
    'Named',
    'PredictedModes',
    'ToolPoint',
    'ToolPointResponse',
    'TurnedPose',
    'WorkspaceMap',
    'candidates',
    'carried_on',
    'choose_series',
    'followed_from',
    'layout_fingerprint',
    'load_map',
    'load_other_map',
    'model_fingerprint',
    'receptance',
    'save_map',
    'tool_modes',
    'tool_point_response',
    'turned_poses',
]
