"""What a model says of one pose, for people and for programs."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from rich.box import SIMPLE_HEAD
from rich.table import Table

from autonomous_modal_analysis.results import plain
from autonomous_modal_analysis.terminal import OUTPUT
from excitation_planner.sensitivity import sensitivity_table, SensitivityTable
from modal_core.channel import SensorLayout
from structural_model.flexible_joint_model import FlexibleJointModel
from structural_model.matrices import DampedModes


@dataclass(frozen=True, slots=True)
class ModelAtPose:
    """Modes of a robot in one pose.

    Parameters
    ----------
    model : FlexibleJointModel
        The robot.
    layout : SensorLayout
        Its sensors.
    q : (n_joints,) array [rad]
        Serial joints.
    highest_hz : float [Hz]
        Modes above are not shown.
    step_deg : float or None [deg]
        Joint step of the sensitivity; None: not asked for.
    """

    model: FlexibleJointModel
    layout: SensorLayout
    q: NDArray[np.float64]
    highest_hz: float
    step_deg: float | None = None

    @property
    def pose_deg(self) -> NDArray[np.float64]:
        """Controller angles [deg]."""
        return np.asarray(np.rad2deg(self.model.to_controller(self.q)))

    def modes(self) -> DampedModes:
        """Return all modes, with shapes at the sensors."""
        return self.model.damped_modes(self.q, self.layout.channels)

    def sensitivity(self) -> SensitivityTable | None:
        """Return how modes change with each joint, if asked for."""
        if self.step_deg is None:
            return None
        return sensitivity_table(self.model, self.q, np.deg2rad(self.step_deg), self.highest_hz)


def model_json(seen: ModelAtPose) -> object:
    """Return modes, shapes and sensitivity as plain values."""
    modes, coefficients = seen.modes(), seen.sensitivity()
    shown = modes.frequency_hz <= seen.highest_hz
    value: dict[str, object] = {
        'robot': seen.model.robot_name,
        'pose_deg': seen.pose_deg,
        'frequencies_hz': modes.frequency_hz[shown],
        'damping_ratios': modes.damping_ratio[shown],
        'channels': [channel.name for channel in seen.layout.channels],
        'shapes': {
            'real': modes.channel_shapes.real[:, shown].T,
            'imag': modes.channel_shapes.imag[:, shown].T,
        },
    }
    if coefficients is not None:
        value['sensitivity'] = coefficients
    return plain(value)


def show_model(seen: ModelAtPose) -> None:
    """Print one row per mode, with the sensitivity to each joint where asked for."""
    modes, coefficients = seen.modes(), seen.sensitivity()
    pose = seen.pose_deg.round(2).tolist()
    OUTPUT.print(f'{seen.model.robot_name} at {pose} deg', soft_wrap=True, markup=False)
    table = Table(box=SIMPLE_HEAD, padding=(0, 0))
    joints = seen.model.joint_names if coefficients is not None else ()
    for heading in ('mode', 'Hz', 'damping %', *joints):
        table.add_column(heading, justify='right', no_wrap=True)
    for number in range(int((modes.frequency_hz <= seen.highest_hz).sum())):
        table.add_row(
            str(number + 1),
            f'{modes.frequency_hz[number]:.2f}',
            f'{100 * modes.damping_ratio[number]:.2f}',
            *_changes(coefficients, number),
        )
    OUTPUT.print(table)
    if coefficients is not None:
        OUTPUT.print(
            f'change of frequency [%] for a joint step of {seen.step_deg:g} deg:'
            ' from the model at both poses / predicted from the shapes at this one'
        )


def _changes(coefficients: SensitivityTable | None, number: int) -> list[str]:
    if coefficients is None or number >= len(coefficients.actual):
        return []
    pairs = zip(coefficients.actual[number], coefficients.predicted[number], strict=True)
    return [f'{100 * actual:.1f}/{100 * predicted:.1f}' for actual, predicted in pairs]
