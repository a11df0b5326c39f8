"""Write a model as a robot folder again, with the effects it contains."""

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from modal_core.channel import LAYOUT_FILE, SensorLayout
from modal_core.files.atomic_file import atomic_path
from structural_model.description import JointSpec, KnownEffect, RodSpec, shown
from structural_model.flexible_joint_model import FlexibleJointModel
from structural_model.robot_files import MODEL_FILE, URDF_FILE

LISTS = ('links', 'masses', 'hinges', 'beams', 'absorbers', 'compensators', 'cables')


def save_robot(model: FlexibleJointModel, folder: str | Path, note: str = '') -> None:
    """Write ``robot.urdf`` and ``model.yaml``; ``load_robot(folder)`` gives the same model.

    Parameters
    ----------
    model : FlexibleJointModel
        What to write.
    folder : path
        Made when missing; the two files are replaced.
    note : str
        First line of the file, as a comment.
    """
    for name, content in robot_content(model, note=note).items():
        with atomic_path(Path(folder) / name) as path:
            path.write_bytes(content)


def robot_content(
    model: FlexibleJointModel, layout: SensorLayout | None = None, note: str = ''
) -> dict[str, bytes]:
    """Return the files of a robot's folder by name, as recordings carry them.

    Parameters
    ----------
    model : FlexibleJointModel
        What to write.
    layout : SensorLayout or None
        Its sensors, where they are known.
    note : str
        First line of the model's file, as a comment.
    """
    heading = f'# {" ".join(note.split())}\n' if note else ''
    content = {
        URDF_FILE: model.robot.text,
        MODEL_FILE: (heading + model_text(model)).encode(),
    }
    return content if layout is None else {**content, LAYOUT_FILE: layout_text(layout).encode()}


def layout_text(layout: SensorLayout) -> str:
    """Return the text of a file with a sensor layout."""
    return yaml.safe_dump(layout.to_mapping(), sort_keys=False, default_flow_style=None)


def model_text(model: FlexibleJointModel) -> str:
    """Return the text of ``model.yaml``."""
    return yaml.safe_dump(model_mapping(model), sort_keys=False, default_flow_style=None)


def model_mapping(model: FlexibleJointModel) -> dict[str, Any]:
    """Return the content of ``model.yaml``."""
    spec = model.spec
    mapping: dict[str, Any] = {
        'robot_name': model.robot_name,
        'coupling': _coupling(model),
        'limits': _limits(model),
        'poses_controller_deg': {
            name: [float(value) for value in shown(pose, model.sliding)]
            for name, pose in model.poses_controller_rad.items()
        },
        'collision_ignore': [list(pair) for pair in model.collision_ignore],
        'gravity_m_s2': list(spec.gravity_m_s2),
        'effects': [_effect(item) for item in spec.effects],
        **({'tolerances': dict(spec.tolerances)} if spec.tolerances else {}),
        'joints': {joint.name: _joint(joint) for joint in spec.joints},
        'base': _plain(spec.base),
        **({} if spec.foundation.rigid else {'foundation': _plain(spec.foundation)}),
        'damping': _plain(spec.damping),
    }
    for name in LISTS:
        mapping[name] = [_plain(item) for item in getattr(spec, name)]
    mapping['rods'] = [_rod(item) for item in spec.rods]
    return mapping


def _effect(effect: KnownEffect) -> dict[str, Any]:
    mapping = {
        name: value
        for name in ('type', 'location', 'variant', 'kept_in')
        if (value := getattr(effect, name))
    }
    numbers = {
        item.name: {'value': item.value, 'sigma': item.sigma, 'unit': item.unit}
        for item in effect.parameters
    }
    return {**mapping, 'parameters': numbers} if numbers else mapping


def _joint(joint: JointSpec) -> dict[str, Any]:
    return {
        'drive': _plain(joint.drive.spring),
        'tilts': [_plain(tilt) for tilt in joint.tilts],
        'servo': _plain(joint.drive.servo),
        'gear_ratio': _plain(joint.drive.gear_ratio),
        'rotor_inertia_kg_m2': _plain(joint.drive.rotor_inertia_kg_m2),
        **({'offset_rad': _plain(joint.offset_rad)} if joint.offset_rad else {}),
    }


def _rod(rod: RodSpec) -> dict[str, Any]:
    return {'name': rod.name, 'weights': dict(rod.weights), 'spring': _plain(rod.spring)}


def _plain(item: Any) -> Any:
    if dataclasses.is_dataclass(item):
        return {
            field.name: _plain(getattr(item, field.name)) for field in dataclasses.fields(item)
        }
    if isinstance(item, tuple):
        return [_plain(part) for part in item]
    return item.item() if isinstance(item, np.generic) else item


def _coupling(model: FlexibleJointModel) -> list[dict[str, Any]]:
    names, extra = model.joint_names, model.axes.matrix - np.eye(model.n_joints)
    return [
        {'axis': names[row], 'added': names[column], 'factor': float(extra[row, column])}
        for row, column in np.argwhere(extra)
    ]


def _limits(model: FlexibleJointModel) -> dict[str, dict[str, float]]:
    limits = model.limits
    angles = {
        'low_deg': limits.controller_low,
        'high_deg': limits.controller_high,
        'serial_low_deg': limits.position_low,
        'serial_high_deg': limits.position_high,
        'velocity_deg_s': limits.velocity,
        'acceleration_deg_s2': limits.acceleration,
        'jerk_deg_s3': limits.jerk,
    }
    return {
        name: {
            **{key: float(np.rad2deg(value[row])) for key, value in angles.items()},
            'effort_nm': float(limits.effort[row]),
        }
        for row, name in enumerate(model.joint_names)
    }
