"""Parameters of the emulated cell: names, defaults, meaning; settings out of their values."""

from collections.abc import Mapping
from dataclasses import replace
import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from abb_emulator.cell import CellSettings, PARTS
from abb_emulator.egm import GuidanceSettings
from abb_emulator.mechanics import read_effects
from modal_core.settings.node_parameter import NodeParameter, parameters_of
from modal_core.settings.schema import check_settings, from_parameters
from structural_model.flexible_joint_model import FlexibleJointModel

LIVE = frozenset({'module', 'speed_ratio'})
"""May be changed while the node runs."""
_P = NodeParameter
OWN = (
    _P('robot', 'robot of config/robots, or its folder', 'irb6660_205_190'),
    _P('sensors_file', 'sensor layout of the robot', 'sensors'),
    _P('start_pose', 'named pose the arm stands at', 'P1'),
    _P('start_controller_deg', 'or its controller angles [deg]', (math.nan,)),
    _P('effects', 'what the arm has and its model lacks: YAML list, or its file', ''),
    _P('sensor_address', 'host that answers EGM (Remote Address)', '127.0.0.1'),
    _P('sensor_port', 'its port', 6510, 1, 65535),
    _P('local_address', 'interface the controller sends from', '127.0.0.1'),
    _P('start_program', 'run the program at once; guidance when the sensor answers', True),
    _P('module', 'RAPID module to run; none is EGM guidance', ''),
    _P('speed_ratio', "operator's speed ratio, 0..1", 1.0),
    _P('automatic', 'operating mode at the beginning; else manual', True),
    _P('faults', 'at the beginning: name[:value[:duration_s[:target]]]', ('',)),
    _P('rws.port', 'TCP port of Robot Web Services; 0 has none', 0, 0, 65535),
    _P('rws.version', '1: HTTP of RobotWare 6; 2: HTTPS of RobotWare 7', 1, 1, 2),
    _P('rws.address', 'interface it listens on', '127.0.0.1'),
    _P('rws.user', 'account', 'Default User'),
    _P('rws.password', 'of the account', 'robotics'),
)
PARAMETERS = tuple(
    replace(item, read_only=item.name not in LIVE)
    for item in (
        *OWN,
        *parameters_of(CellSettings),
        *(
            item
            for part, kind in {**PARTS, 'guidance': GuidanceSettings}.items()
            for item in parameters_of(kind, f'{part}.')
        ),
    )
)


def cell_settings(values: Mapping[str, Any]) -> CellSettings:
    """Return the cell the parameters describe.

    Raises
    ------
    SettingsError
        An effect or a figure that is not possible.
    """
    parts = {part: _part(part, kind, values) for part, kind in PARTS.items()}
    return CellSettings(
        effects=read_effects(values['effects']), **parts, **from_parameters(CellSettings, values)
    )


def guidance_settings(values: Mapping[str, Any]) -> GuidanceSettings:
    """Return how guidance is set up.

    Raises
    ------
    SettingsError
        A figure that is not possible.
    """
    made: GuidanceSettings = _part('guidance', GuidanceSettings, values)
    return made


def start_angles_deg(values: Mapping[str, Any], model: FlexibleJointModel) -> NDArray[np.float64]:
    """Return the controller angles the arm stands at, (n_joints,) array [deg]."""
    stated = np.array(values['start_controller_deg'], float)
    if np.isfinite(stated).all() and len(stated) == model.n_joints:
        return stated
    return np.asarray(np.degrees(model.to_controller(model.pose(values['start_pose']))))


def _part(part: str, kind: type[Any], values: Mapping[str, Any]) -> Any:
    settings = kind(**from_parameters(kind, values, f'{part}.'))
    check_settings(settings, f'{part}.')
    return settings
