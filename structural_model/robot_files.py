"""Read a robot's folder: robot.urdf, model.yaml, sensors.yaml."""

from collections.abc import Mapping
import dataclasses
import math
import os
from pathlib import Path
import re
from typing import Any, get_args

import numpy as np

from modal_core.channel import SensorLayout
from modal_core.errors import ModelError, SettingsError
from modal_core.files.share import share_path
from modal_core.files.yaml_file import load_yaml, parse_yaml
from modal_core.layouts.layout_file import layout_from_file
from modal_core.settings.near_names import refuse_unknown
from structural_model.description import (
    AbsorberSpec,
    AxisCoupling,
    AxisMap,
    BaseSpec,
    BeamSpec,
    CableSpec,
    check_spring,
    CompensatorSpec,
    Drive,
    FoundationSpec,
    HingeSpec,
    JointSpec,
    KnownEffect,
    KnownNumber,
    LinkSpec,
    load_urdf,
    MassSpec,
    MaterialDamping,
    ModelSpec,
    parse_urdf,
    read_values,
    RigidRobot,
    RobotLimits,
    RodSpec,
    Spring,
    Vector,
)
from structural_model.flexible_joint_model import FlexibleJointModel

URDF_FILE, MODEL_FILE = 'robot.urdf', 'model.yaml'
# Numbers that may be infinite: no such degree of freedom, no such limit.
ENDLESS = (
    'stiffness', 'torsion_n_m2', 'axial_n', 'bending_n_m2[0]', 'bending_n_m2[1]', '_deg', '_deg_s',
    '_deg_s2', '_deg_s3', 'effort_nm',
)  # fmt: skip
MODEL_SUFFIXES = ('.yaml', '.yml')
NAME = re.compile(r'[A-Za-z0-9_.-]+')
TOP = (
    'robot_name', 'description', 'sources', 'coupling', 'limits', 'poses_controller_deg',
    'collision_ignore', 'joints', 'base', 'links', 'masses', 'hinges', 'beams', 'absorbers',
    'rods', 'compensators', 'damping', 'gravity_m_s2', 'effects', 'tolerances', 'fit',
    'foundation', 'cables',
)  # fmt: skip
KEPT_IN = ('model', 'layout', 'effects')
LISTS: dict[str, type] = {
    'links': LinkSpec,
    'masses': MassSpec,
    'hinges': HingeSpec,
    'beams': BeamSpec,
    'absorbers': AbsorberSpec,
    'rods': RodSpec,
    'compensators': CompensatorSpec,
    'cables': CableSpec,
}
LIMIT_FIELDS = (
    'low_deg', 'high_deg', 'serial_low_deg', 'serial_high_deg', 'velocity_deg_s',
    'acceleration_deg_s2', 'jerk_deg_s3', 'effort_nm',
)  # fmt: skip


def robot_folder(name_or_folder: str | Path) -> Path:
    """Return the folder of a shipped robot by name, the folder given, or that of a model file.

    Raises
    ------
    ModelError
        Neither exists.
    """
    folder = Path(name_or_folder)
    if folder.suffix in MODEL_SUFFIXES and os.path.isfile(folder):  # noqa: PTH113 - as below
        return folder.parent
    if os.path.isdir(folder):  # noqa: PTH112 - False, not an error, for names no folder can have
        return folder
    robots = share_path('config', 'robots')
    known = sorted(item.name for item in robots.iterdir() if (item / 'model.yaml').exists())
    text = str(name_or_folder)
    if NAME.fullmatch(text) and text in known:
        return robots / text
    raise ModelError(
        'unknown robot',
        found=text[:100],
        expected=f'a folder, or one of {", ".join(known)}',
        advice='ama robot makes a folder of a URDF' if text.endswith('.urdf') else '',
    )


def load_robot(name_or_folder: str | Path) -> FlexibleJointModel:
    """Read a robot by name (config/robots/<name>), from a folder, or from its model file.

    Raises
    ------
    ModelError
        A file is missing, malformed or contradicts another; the message names the field.
    """
    file = Path(name_or_folder)
    if file.suffix in MODEL_SUFFIXES and file.is_file():
        folder, where = file.parent, file
    else:
        folder = robot_folder(name_or_folder)
        where = folder / MODEL_FILE
    try:
        data = load_yaml(where)
    except SettingsError as error:
        raise _of_the_model(error) from error
    _known(data, TOP, str(where))
    return _model(data, load_urdf(folder / URDF_FILE), str(where), folder.name)


def robot_of_files(urdf: bytes, model: str, where: str) -> FlexibleJointModel:
    """Read a robot from the content of its files, as a recording carries them.

    Parameters
    ----------
    urdf : bytes
        Content of ``robot.urdf``.
    model : str
        Content of ``model.yaml``.
    where : str
        What to call them in errors.

    Raises
    ------
    ModelError
        One is malformed or contradicts the other; the message names the field.
    """
    place = f'{where}: {MODEL_FILE}'
    try:
        data = _mapping(parse_yaml(model, place), place)
    except SettingsError as error:
        raise _of_the_model(error) from error
    _known(data, TOP, place)
    robot = parse_urdf(urdf, f'{where}: {URDF_FILE}')
    return _model(data, robot, place, robot.name)


def _of_the_model(error: SettingsError) -> ModelError:
    """Return an error in a YAML file as one of the model."""
    return ModelError(
        error.what,
        where=error.where,
        found=error.found,
        expected=error.expected,
        advice=error.advice,
    )


def _model(
    data: Mapping[str, Any], robot: RigidRobot, where: str, name: str
) -> FlexibleJointModel:
    """Return the model that a file makes of a rigid robot, called so unless it says otherwise."""
    couplings = _list(data, 'coupling', where)
    axes = AxisMap.build(
        robot.joint_names,
        [
            _fill(AxisCoupling, item, f'{where}: coupling[{index}]')
            for index, item in enumerate(couplings)
        ],
    )
    return FlexibleJointModel(
        robot=robot,
        spec=_spec(data, robot, where),
        limits=_limits(data, robot, axes, where),
        poses_controller_rad=_poses(data, robot, where),
        collision_ignore=tuple(
            _pair(item, robot, f'{where}: collision_ignore')
            for item in _list(data, 'collision_ignore', where)
        ),
        name=str(data.get('robot_name', name)),
    )


def load_layout(name_or_folder: str | Path, name: str = 'sensors') -> SensorLayout:
    """Read a sensor layout ``<name>.yaml`` of a robot.

    Raises
    ------
    ModelError
        No such layout.
    LayoutError
        It is malformed.
    """
    folder = robot_folder(name_or_folder)
    path = folder / f'{name}.yaml'
    if not NAME.fullmatch(name) or not path.exists():
        known = sorted(item.stem for item in folder.glob('sensors*.yaml'))
        raise ModelError(
            'unknown sensor layout',
            where=folder.resolve().name,
            found=name,
            expected=', '.join(known) or 'a sensors.yaml beside the model',
        )
    return layout_from_file(path)


def _spec(data: Mapping[str, Any], robot: RigidRobot, where: str) -> ModelSpec:
    joints = data.get('joints') or {}
    if not isinstance(joints, Mapping):
        raise ModelError('not a mapping of joints', where=f'{where}: joints')
    refuse_unknown(joints, robot.joint_names, 'unknown joint', f'{where}: joints', ModelError)
    parts: dict[str, Any] = {
        key: tuple(
            _fill(kind, item, f'{where}: {key}[{index}]')
            for index, item in enumerate(_list(data, key, where))
        )
        for key, kind in LISTS.items()
    }
    base = data.get('base')
    return ModelSpec(
        joints=tuple(
            _joint(name, joints.get(name) or {}, f'{where}: joints.{name}')
            for name in robot.joint_names
        ),
        base=BaseSpec() if base is None else _fill(BaseSpec, base, f'{where}: base'),
        foundation=_fill(FoundationSpec, data.get('foundation') or {}, f'{where}: foundation'),
        damping=_fill(MaterialDamping, data.get('damping') or {}, f'{where}: damping'),
        gravity_m_s2=_convert(
            data.get('gravity_m_s2', [0.0, 0.0, -9.81]), Vector, f'{where}: gravity_m_s2'
        ),
        effects=tuple(
            _effect(item, f'{where}: effects[{index}]')
            for index, item in enumerate(_list(data, 'effects', where))
        ),
        tolerances=tuple(
            (str(name), _number(value, f'{where}: tolerances: {name}'))
            for name, value in _mapping(
                data.get('tolerances') or {}, f'{where}: tolerances'
            ).items()
        ),
        **parts,
    )


def _effect(item: object, where: str) -> KnownEffect:
    """Read a known effect: its name, or a mapping with its parameters by name."""
    mapping = {'type': item} if isinstance(item, str) else dict(_mapping(item, where))
    parameters = _mapping(mapping.pop('parameters', {}), f'{where}.parameters')
    effect: KnownEffect = _fill(KnownEffect, mapping, where)
    if effect.kept_in not in KEPT_IN:
        raise ModelError(
            'unknown place', where=f'{where}.kept_in', found=effect.kept_in, expected=KEPT_IN
        )
    return dataclasses.replace(
        effect,
        parameters=tuple(
            _fill(KnownNumber, {'name': name, **_mapping(value, where)}, f'{where}.{name}')
            for name, value in parameters.items()
        ),
    )


def _joint(name: str, item: object, where: str) -> JointSpec:
    """Read a joint, which is flat in YAML: springs beside the gear's numbers."""
    fields = ('drive', 'tilts', 'servo', 'gear_ratio', 'rotor_inertia_kg_m2', 'offset_rad')
    mapping = _mapping(item, where)
    _known(mapping, fields, where)
    tilts = mapping.get('tilts', [{}, {}])
    if not isinstance(tilts, list) or len(tilts) != 2:
        raise ModelError('tilts are two springs', where=where, found=tilts)
    return JointSpec(
        name=name,
        drive=Drive(
            spring=_spring(mapping.get('drive') or {}, f'{where}.drive'),
            gear_ratio=_number(mapping.get('gear_ratio', 1.0), f'{where}.gear_ratio'),
            rotor_inertia_kg_m2=_number(
                mapping.get('rotor_inertia_kg_m2', 0.0), f'{where}.rotor_inertia_kg_m2'
            ),
            servo=_spring(mapping.get('servo') or {}, f'{where}.servo'),
        ),
        tilts=(
            _spring(tilts[0], f'{where}.tilts[0]'),
            _spring(tilts[1], f'{where}.tilts[1]'),
        ),
        offset_rad=_number(mapping.get('offset_rad', 0.0), f'{where}.offset_rad'),
    )


def _spring(item: object, where: str) -> Spring:
    spring: Spring = _fill(Spring, item, where)
    check_spring(spring, where)
    return spring


def _fill(kind: type, item: object, where: str) -> Any:
    """Build a spec dataclass from a YAML mapping, by its field types."""
    mapping = _mapping(item, where)
    fields = {field.name: field for field in dataclasses.fields(kind)}
    _known(mapping, tuple(fields), where)
    for name, field in fields.items():
        if name not in mapping and field.default is dataclasses.MISSING:
            raise ModelError(f'{name} missing', where=where)
    values = {
        name: _convert(value, fields[name].type, f'{where}.{name}')
        for name, value in mapping.items()
    }
    return kind(**values)


def _convert(value: object, kind: Any, where: str) -> Any:
    """Turn a YAML value into what a field is declared to be."""
    inner = get_args(kind)
    if kind is Spring:
        return _spring(value, where)
    if kind is bool:
        if not isinstance(value, bool):
            raise ModelError('not true or false', where=where, found=value)
        return value
    if kind is int:
        return int(_number(value, where))
    if kind is float:
        return _number(value, where)
    if inner and inner[-1] is Ellipsis:  # weights of a rod: joint to number
        return tuple((name, _number(item, where)) for name, item in _mapping(value, where).items())
    if inner:
        if not isinstance(value, list) or len(value) != len(inner):
            raise ModelError('wrong length', where=where, found=value, expected=len(inner))
        return tuple(_convert(item, inner[0], f'{where}[{n}]') for n, item in enumerate(value))
    if not isinstance(value, str):
        raise ModelError('not a text', where=where, found=value)
    return value


def _number(value: object, where: str) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float | str):
        raise ModelError('not a number', where=where, found=value)
    try:
        number = float(value)  # PyYAML reads 1e6 as text
    except ValueError as error:
        raise ModelError('not a number', where=where, found=str(value)[:60]) from error
    if math.isnan(number) or (math.isinf(number) and not where.endswith(ENDLESS)):
        raise ModelError('not a finite number', where=where, found=value)
    return number


def _limits(data: Mapping[str, Any], robot: RigidRobot, axes: AxisMap, where: str) -> RobotLimits:
    given = _mapping(data.get('limits') or {}, f'{where}: limits')
    rows = []
    for joint in robot.joints:
        place = f'{where}: limits.{joint.name}'
        item = _mapping(given.get(joint.name) or {}, place)
        _known(item, LIMIT_FIELDS, place)
        low, high = math.degrees(joint.low), math.degrees(joint.high)
        coupled = bool(
            np.any(np.delete(axes.matrix[robot.joints.index(joint)], robot.joints.index(joint)))
        )
        defaults = {
            'low_deg': -math.inf if coupled else low,
            'high_deg': math.inf if coupled else high,
            'serial_low_deg': low,
            'serial_high_deg': high,
            'velocity_deg_s': math.degrees(joint.velocity),
            'acceleration_deg_s2': math.inf,
            'jerk_deg_s3': math.inf,
            'effort_nm': joint.effort,
        }
        row = [
            _number(item[key], f'{place}.{key}') if key in item else defaults[key]
            for key in LIMIT_FIELDS
        ]
        if not (row[0] < row[1] and row[2] < row[3] and min(row[4:]) > 0.0):
            raise ModelError('limits are empty', where=place, found=row)
        rows.append(row)
    table = np.array(rows)
    angles = np.deg2rad(table[:, :7])
    return RobotLimits(
        joint_names=robot.joint_names,
        axes=axes,
        controller_low=angles[:, 0],
        controller_high=angles[:, 1],
        position_low=angles[:, 2],
        position_high=angles[:, 3],
        velocity=angles[:, 4],
        acceleration=angles[:, 5],
        jerk=angles[:, 6],
        effort=table[:, 7],
    )


def _poses(data: Mapping[str, Any], robot: RigidRobot, where: str) -> dict[str, tuple[float, ...]]:
    poses = {}
    for name, item in _mapping(data.get('poses_controller_deg') or {}, where).items():
        place = f'{where}: poses_controller_deg.{name}'
        if not isinstance(item, list) or len(item) != len(robot.joints):
            raise ModelError('bad pose', where=place, expected=f'{len(robot.joints)} angles')
        values = [_number(value, place) for value in item]
        sliding = [joint.prismatic for joint in robot.joints]
        poses[str(name)] = tuple(read_values(values, sliding).tolist())
    return poses


def _pair(item: object, robot: RigidRobot, where: str) -> tuple[str, str]:
    if not isinstance(item, list) or len(item) != 2:
        raise ModelError('not a pair of links', where=where, found=item)
    for name in item:
        if name not in robot.link_names:
            raise ModelError(
                'unknown link', where=where, found=name, expected=', '.join(robot.link_names)
            )
    return str(item[0]), str(item[1])


def _mapping(item: object, where: str) -> Mapping[str, Any]:
    if not isinstance(item, Mapping):
        raise ModelError('not a mapping', where=where, found=str(item)[:60])
    return item


def _list(data: Mapping[str, Any], key: str, where: str) -> list[Any]:
    items = data.get(key) or []
    if not isinstance(items, list):
        raise ModelError('not a list', where=f'{where}: {key}', found=type(items).__name__)
    return items


def _known(mapping: Mapping[str, Any], allowed: tuple[str, ...], where: str) -> None:
    refuse_unknown(mapping, allowed, where=where, error=ModelError)
