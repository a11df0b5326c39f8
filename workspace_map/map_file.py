"""A map as a JSON file, written whole or not at all, and checked against the robot it is of."""

from dataclasses import asdict, fields, replace
from hashlib import sha256
import json
import math
from pathlib import Path
from typing import Any, TYPE_CHECKING

import numpy as np

from modal_core.channel import SensorLayout
from modal_core.errors import MapError, ModelError
from modal_core.files.atomic_file import write_text
from modal_core.files.json_file import load_json
from structural_model.description import MassSpec
from workspace_map.arm import Arm, State, ToolPoint
from workspace_map.fit import Centres
from workspace_map.measured_pose import MeasuredPose
from workspace_map.prior import damping_scales, structure_scales
from workspace_map.regression import Scales
from workspace_map.workspace_map import WorkspaceMap

if TYPE_CHECKING:
    from structural_model import FlexibleJointModel

KIND, VERSION = 'workspace_map', 2
LARGEST_BYTES = 200_000_000
BEGIN_WITH = 'measure this one, or take the other as a beginning (--transfer)'
ALIKE = 'only tool point and masses fixed to links may differ: measure this one without it'
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


def save_map(
    path: str | Path, known: WorkspaceMap, layout: SensorLayout, series: str = ''
) -> None:
    """Write a map.

    Parameters
    ----------
    path : path
        File.
    known : WorkspaceMap
        The map.
    layout : SensorLayout
        Its sensors.
    series : str
        Hash of the series of motions that were released for it.
    """
    write_text(Path(path), json.dumps(_content(known, layout, series), indent=1) + '\n')


def _content(known: WorkspaceMap, layout: SensorLayout, series: str = '') -> dict[str, Any]:
    """Return what a file holds; the other arm's map in whole, since this one departs from it."""
    return {
        'kind': KIND,
        'version': VERSION,
        'robot': known.arm.model.robot_name,
        'model': model_fingerprint(known.arm.model),
        'layout': layout_fingerprint(layout),
        'tool': {'link': known.arm.tool.link, 'position_m': list(known.arm.tool.position_m)},
        'masses': [asdict(each) for each in known.arm.model.spec.masses],
        'highest_hz': known.highest_hz,
        'series': series,
        'scales': [_plain(each) for each in known.found_scales],
        'poses': [_plain(each) for each in known.measured],
        'states': [_plain(each) for each in known.fitted.centres.states],
        'pairs': [[part.tolist() for part in each] for each in known.fitted.centres.pairs],
        'before': None if known.before is None else _content(known.before, layout),
    }


def load_map(
    path: str | Path,
    model: 'FlexibleJointModel',
    layout: SensorLayout,
    tool: ToolPoint | None = None,
) -> tuple[WorkspaceMap, str]:
    """Read a map of a robot.

    Parameters
    ----------
    path : path
        File.
    model : FlexibleJointModel
        The robot it must be of.
    layout : SensorLayout
        The sensors it must be of.
    tool : ToolPoint, optional
        The tool point it must be of; by default its own.

    Returns
    -------
    tuple of WorkspaceMap, str
        The map with that of the other arm it began with, and the hash of its series.

    Raises
    ------
    MapError, SettingsError
        No map, or one of another robot, tool or layout.
    """
    path = Path(path)
    data = load_json(path, LARGEST_BYTES)
    return _map_of(path, data, model, layout, tool), str(data.get('series', ''))


def load_other_map(
    path: str | Path, model: 'FlexibleJointModel', layout: SensorLayout
) -> WorkspaceMap:
    """Read the map of another arm of this kind, which may have another tool.

    Parameters
    ----------
    path : path
        File.
    model : FlexibleJointModel
        This arm; the other one may differ from it by the masses that are fixed to its links.
    layout : SensorLayout
        The sensors that both have.

    Returns
    -------
    WorkspaceMap
        Of the other arm, with its own tool.

    Raises
    ------
    MapError, SettingsError
        No map, or one of another robot or layout.
    """
    path = Path(path)
    data = load_json(path, LARGEST_BYTES)
    return _map_of(path, data, _with_masses(model, data), layout, None, ALIKE)


def _with_masses(model: 'FlexibleJointModel', data: Any) -> 'FlexibleJointModel':
    """Return a model with the masses that a map's has, where that makes it the map's."""
    try:
        masses = tuple(_mass(each) for each in data['masses'])
        other = model.replace(replace(model.spec, masses=masses))
        return other if model_fingerprint(other) == data['model'] else model
    except (KeyError, TypeError, ValueError, ModelError):
        return model  # what is wrong with it is told where it is read


def _mass(data: dict[str, Any]) -> MassSpec:
    places = {name: _three(data[name]) for name in ('position_m', 'gyration_m')}
    return MassSpec(str(data['name']), str(data['link']), float(data['mass_kg']), **places)


def _map_of(
    path: Path,
    data: Any,
    model: 'FlexibleJointModel',
    layout: SensorLayout,
    tool: ToolPoint | None,
    advice: str = BEGIN_WITH,
) -> WorkspaceMap:
    if not isinstance(data, dict) or data.get('kind') != KIND:
        raise MapError('not a modal map', where=path, advice='make one with `ama map`')
    if data.get('version') != VERSION:
        raise MapError(
            'a modal map of another version', where=path, found=data.get('version'),
            expected=VERSION,
            advice='remove it and give `ama map measure` again: recordings beside it are kept',
        )  # fmt: skip
    try:
        own = ToolPoint(str(data['tool']['link']), _three(data['tool']['position_m']))
        # A model of another robot may have nothing that a fingerprint is made of.
        _same(path, {'robot': (data['robot'], model.robot_name)}, advice)
        asked = {
            'model of the robot': (data['model'], model_fingerprint(model)),
            'sensor layout': (data['layout'], layout_fingerprint(layout)),
            'tool point': (_words(own), _words(tool or own)),
        }
        _same(path, asked, advice)
        arm = Arm(model, layout.channels, own)
        poses = tuple(_pose(arm, each) for each in data['poses'])
        general = structure_scales(model.n_joints), damping_scales(model.n_joints)
        each = zip(data['scales'], general, strict=True)
        structure, dampers = (_scales(found, like) for found, like in each)
        centres = _centres(arm, poses, data['states'], data['pairs'])
        highest_hz = float(data['highest_hz'])
        if not 0.0 < highest_hz < math.inf:
            raise ValueError('highest_hz')
        other = data['before']
        before = None
        if other is not None:
            before = _map_of(path, other, _with_masses(model, other), layout, None)
        made = WorkspaceMap(arm, highest_hz, poses, (structure, dampers), centres, before=before)
        _ = made.fitted  # numbers that no map has are told now, not at the first prediction
        return made
    except (KeyError, TypeError, ValueError, IndexError, OverflowError) as error:
        raise MapError('damaged', where=path, found=repr(error)) from error


def _same(path: Path, asked: dict[str, tuple[str, str]], advice: str) -> None:
    for what, (found, expected) in asked.items():
        if found != expected:
            raise MapError(
                f'a map of another {what}', where=path, found=found, expected=expected,
                advice=advice,
            )  # fmt: skip


def _words(tool: ToolPoint) -> str:
    return f'{tool.link} at {", ".join(f"{value:g}" for value in tool.position_m)} m'


def _plain(item: Any) -> dict[str, Any]:
    return {
        each.name: value.tolist() if isinstance(value, np.ndarray) else value
        for each in fields(item)
        for value in (getattr(item, each.name),)
    }


def _like(template: Any, data: dict[str, Any]) -> Any:
    """Return finite arrays of the shapes that a template has."""
    found = {each.name: np.array(data[each.name], dtype=float) for each in fields(template)}
    for name, value in found.items():
        if value.shape != getattr(template, name).shape or not np.isfinite(value).all():
            raise ValueError(name)
    return type(template)(**found)


def _scales(data: dict[str, Any], template: Scales) -> Scales:
    found: Scales = _like(template, data)
    for each in fields(template):
        value, expected = getattr(found, each.name), getattr(template, each.name)
        if np.any(value < 0.0) or np.any((value > 0.0) != (expected > 0.0)):
            raise ValueError(each.name)
    return found


def _pose(arm: Arm, data: dict[str, Any]) -> MeasuredPose:
    arrays = {
        each.name: np.array(data[each.name], dtype=float)
        for each in fields(MeasuredPose)
        if each.name not in ('duration_s', 'plan_hash')
    }
    found = MeasuredPose(
        **arrays, duration_s=float(data['duration_s']), plan_hash=str(data['plan_hash'])
    )
    expected = (arm.model.n_joints,), (len(arm.channels), len(found))
    if (found.q.shape, found.shapes.shape) != expected:
        raise ValueError('pose')
    return found


def _centres(
    arm: Arm, poses: tuple[MeasuredPose, ...], states: list[Any], pairs: list[Any]
) -> Centres | None:
    none = State.none(arm.n_dof, arm.n_masses)
    found = Centres(
        tuple(_like(none, each) for each in states),
        tuple((np.array(a, dtype=np.intp), np.array(b, dtype=np.intp)) for a, b in pairs),
    )
    if not len(found.states) == len(found.pairs) == len(poses):
        raise ValueError('states')
    for pose, (measured, expected) in zip(poses, found.pairs, strict=True):
        ends = np.max(measured, initial=-1) < len(pose), np.max(expected, initial=-1) < arm.n_dof
        if measured.shape != expected.shape or min([*measured, *expected, 0]) < 0 or not all(ends):
            raise ValueError('pairs')
    return found if poses else None


def _three(values: Any) -> tuple[float, float, float]:
    x, y, z = (float(value) for value in values)
    if not math.isfinite(x + y + z):
        raise ValueError('position_m')
    return x, y, z


def _rounded(matrix: Any) -> Any:
    size = np.max(np.abs(matrix))
    return np.round(matrix / size, DIGITS) + 0.0
