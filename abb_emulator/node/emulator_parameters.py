"""Parameters of the emulated cell: names, defaults, meaning; settings out of their values."""

from collections.abc import Callable
from dataclasses import dataclass, fields
import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from abb_emulator.cell import CellSettings
from abb_emulator.controller import ControllerSettings
from abb_emulator.drives import ServoSettings
from abb_emulator.egm import GuidanceSettings
from abb_emulator.mechanics import GearSettings, read_effects
from abb_emulator.sensing import SensorSettings
from structural_model.flexible_joint_model import FlexibleJointModel

Value = Callable[[str], Any]
"""Name of a parameter to its value."""


@dataclass(frozen=True, slots=True)
class EmulatorParameter:
    """One parameter of the node.

    Parameters
    ----------
    name : str
        With its group, as in ``servo.bandwidth_hz``.
    default : value
        Also gives the type.
    text : str
        What it is.
    live : bool
        May be changed while the node runs.
    """

    name: str
    default: Any
    text: str
    live: bool = False


GROUPS: dict[str, type[Any]] = {
    'servo': ServoSettings,
    'gears': GearSettings,
    'sensors': SensorSettings,
    'controller': ControllerSettings,
    'guidance': GuidanceSettings,
}
OWN = (
    EmulatorParameter('robot', 'irb6660_205_190', 'robot of config/robots, or its folder'),
    EmulatorParameter('sensors_file', 'sensors', 'sensor layout of the robot'),
    EmulatorParameter('start_pose', 'P1', 'named pose the arm stands at'),
    EmulatorParameter('start_controller_deg', [math.nan], 'or its controller angles [deg]'),
    EmulatorParameter('sample_rate_hz', 2048.0, 'of the accelerometers [Hz]'),
    EmulatorParameter('block_samples', 64, 'rows per acceleration_block'),
    EmulatorParameter('seed', 1, 'of noise, bias and link faults'),
    EmulatorParameter(
        'effects', '', 'what the arm has and its model lacks: YAML list, or its file'
    ),
    EmulatorParameter(
        'tolerance', 0.0, 'ordinary deviations from the model; 1 is what every arm has'
    ),
    EmulatorParameter('tolerance_seed', 1, 'of those'),
    EmulatorParameter('uptime_s', 0.0, 'how long the arm has been switched on [s]'),
    EmulatorParameter('sensor_address', '127.0.0.1', 'host that answers EGM (Remote Address)'),
    EmulatorParameter('sensor_port', 6510, 'its port'),
    EmulatorParameter('local_address', '127.0.0.1', 'interface the controller sends from'),
    EmulatorParameter(
        'start_program', True, 'run the program at once; guidance when the sensor answers'
    ),
    EmulatorParameter('module', '', 'RAPID module to run; none is EGM guidance', live=True),
    EmulatorParameter('speed_ratio', 1.0, "operator's speed ratio, 0..1", live=True),
    EmulatorParameter('automatic', True, 'operating mode at the beginning; else manual'),
    EmulatorParameter('faults', [''], 'at the beginning: name[:value[:duration_s[:target]]]'),
    EmulatorParameter('rws.port', 0, 'TCP port of Robot Web Services; 0 has none'),
    EmulatorParameter('rws.address', '127.0.0.1', 'interface it listens on'),
    EmulatorParameter('rws.user', 'Default User', 'account'),
    EmulatorParameter('rws.password', 'robotics', 'of the account'),
)


def _of_group(group: str, kind: type[Any]) -> list[EmulatorParameter]:
    made = []
    for item in fields(kind):
        default = getattr(kind(), item.name)
        default = list(default) if isinstance(default, tuple) else default
        made.append(
            EmulatorParameter(f'{group}.{item.name}', default, f'{kind.__name__}.{item.name}')
        )
    return made


PARAMETERS = (*OWN, *(item for group, kind in GROUPS.items() for item in _of_group(group, kind)))


def cell_settings(value: Value) -> CellSettings:
    """Return the cell the parameters describe.

    Raises
    ------
    SettingsError
        An effect or a figure that is not possible.
    """
    return CellSettings(
        sample_rate_hz=value('sample_rate_hz'),
        block_samples=value('block_samples'),
        seed=value('seed'),
        effects=read_effects(value('effects')),
        tolerance=value('tolerance'),
        tolerance_seed=value('tolerance_seed'),
        uptime_s=value('uptime_s'),
        controller=settings_of('controller', value),
        servo=settings_of('servo', value),
        gears=settings_of('gears', value),
        sensors=settings_of('sensors', value),
    )


def settings_of(group: str, value: Value) -> Any:
    """Return the settings of one group."""
    kind = GROUPS[group]
    values = {}
    for item in fields(kind):
        found = value(f'{group}.{item.name}')
        values[item.name] = found if isinstance(found, (int, float, str)) else tuple(found)
    return kind(**values)


def start_angles_deg(value: Value, model: FlexibleJointModel) -> NDArray[np.float64]:
    """Return the controller angles the arm stands at, (n_joints,) array [deg]."""
    stated = np.array(value('start_controller_deg'), float)
    if np.isfinite(stated).all() and len(stated) == model.n_joints:
        return stated
    return np.asarray(np.degrees(model.to_controller(model.pose(value('start_pose')))))
