"""A map as a JSON file, written whole or not at all, and checked against the robot it is of."""

from dataclasses import fields, replace
from hashlib import sha256
import json
from pathlib import Path
from typing import Any, TYPE_CHECKING

import numpy as np

from modal_core.atomic_file import write_text
from modal_core.channel import SensorLayout
from modal_core.errors import MapError
from modal_core.json_file import load_json
from workspace_map.arm import Arm, State, ToolPoint
from workspace_map.fit import Centres
from workspace_map.measured_pose import MeasuredPose
from workspace_map.regression import Scales
from workspace_map.workspace_map import WorkspaceMap

if TYPE_CHECKING:
    from structural_model import FlexibleJointModel

KIND, VERSION = 'workspace_map', 1
LARGEST_BYTES = 200_000_000
DIGITS = 6
"""Significant digits of a model's matrices that two machines agree on."""


def model_fingerprint(model: 'FlexibleJointModel') -> str:
    """Return what tells a robot's model from any other: its matrices at three poses."""
    seen = sha256('\n'.join((model.robot_name, *model.joint_names)).encode())
    for angle in (0.0, 0.5, -0.4):
        found = model.matrices(np.full(model.n_joints, angle))
        for matrix in (found.M, found.C, found.K):
            seen.update(np.array2string(_rounded(matrix), threshold=10**9).encode())
    return seen.hexdigest()[:16]


def layout_fingerprint(layout: SensorLayout) -> str:
    """Return what tells a sensor layout from any other."""
    text = json.dumps(layout.to_mapping(), sort_keys=True, default=str)
    return sha256(text.encode()).hexdigest()[:16]


def save_map(path: Path, known: WorkspaceMap, layout: SensorLayout, series: str = '') -> None:
    """Write a map.

    Parameters
    ----------
    path : Path
        File.
    known : WorkspaceMap
        The map.
    layout : SensorLayout
        Its sensors.
    series : str
        Hash of the series of motions that were released for it.
    """
    content = {
        'kind': KIND,
        'version': VERSION,
        'robot': known.arm.model.robot_name,
        'model': model_fingerprint(known.arm.model),
        'layout': layout_fingerprint(layout),
        'tool': {'link': known.arm.tool.link, 'position_m': list(known.arm.tool.position_m)},
        'highest_hz': known.highest_hz,
        'series': series,
        'scales': [_plain(each) for each in known.found_scales],
        'poses': [_plain(each) for each in known.measured],
        'states': [_plain(each) for each in known.fitted.centres.states],
        'pairs': [[part.tolist() for part in each] for each in known.fitted.centres.pairs],
    }
    write_text(path, json.dumps(content, indent=1) + '\n')


def load_map(
    path: Path,
    model: 'FlexibleJointModel',
    layout: SensorLayout,
    tool: ToolPoint | None = None,
    before: WorkspaceMap | None = None,
) -> tuple[WorkspaceMap, str]:
    """Read a map of a robot.

    Parameters
    ----------
    path : Path
        File.
    model : FlexibleJointModel
        The robot it must be of.
    layout : SensorLayout
        The sensors it must be of.
    tool : ToolPoint, optional
        The tool point it must be of; by default its own.
    before : WorkspaceMap, optional
        Map of another arm that this one began with.

    Returns
    -------
    tuple of WorkspaceMap, str
        The map, and the hash of the series it was made by.

    Raises
    ------
    MapError, SettingsError
        No map, or one of another robot, tool or layout.
    """
    data = load_json(path, LARGEST_BYTES)
    if not isinstance(data, dict) or data.get('kind') != KIND or data.get('version') != VERSION:
        raise MapError('not a modal map', where=path, advice='make one with `ama map`')
    try:
        own = ToolPoint(str(data['tool']['link']), _three(data['tool']['position_m']))
        asked = {
            'robot': (data['robot'], model.robot_name),
            'model of the robot': (data['model'], model_fingerprint(model)),
            'sensor layout': (data['layout'], layout_fingerprint(layout)),
            'tool point': (_words(own), _words(tool or own)),
        }
        _same(path, asked)
        poses = tuple(_read(MeasuredPose, each) for each in data['poses'])
        first, second = (_read(Scales, each) for each in data['scales'])
        arm = Arm(model, layout.channels, own)
        states = tuple(_read(State, each) for each in data['states'])
        pairs = tuple((np.array(a, int), np.array(b, int)) for a, b in data['pairs'])
        centres = Centres(states, pairs) if states else None
        made = WorkspaceMap(arm, float(data['highest_hz']), poses, (first, second), centres)
        made = replace(made, before=before)
        return made, str(data['series'])
    except (KeyError, TypeError, ValueError) as error:
        raise MapError('damaged', where=path, found=repr(error)) from error


def _same(path: Path, asked: dict[str, tuple[str, str]]) -> None:
    for what, (found, expected) in asked.items():
        if found != expected:
            raise MapError(
                f'a map of another {what}', where=path, found=found, expected=expected,
                advice='measure this one, or take the other as a beginning (--transfer)',
            )  # fmt: skip


def _words(tool: ToolPoint) -> str:
    return f'{tool.link} at {", ".join(f"{value:g}" for value in tool.position_m)} m'


def _plain(item: Any) -> dict[str, Any]:
    return {
        each.name: value.tolist() if isinstance(value, np.ndarray) else value
        for each in fields(item)
        for value in (getattr(item, each.name),)
    }


def _read(kind: type[Any], data: dict[str, Any]) -> Any:
    return kind(**{k: np.array(v, float) if isinstance(v, list) else v for k, v in data.items()})


def _three(values: Any) -> tuple[float, float, float]:
    x, y, z = (float(value) for value in values)
    return x, y, z


def _rounded(matrix: Any) -> Any:
    size = np.max(np.abs(matrix))
    return np.round(matrix / size, DIGITS) + 0.0
