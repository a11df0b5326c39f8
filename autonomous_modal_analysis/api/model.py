"""What the structural model of a robot says of one pose."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from autonomous_modal_analysis.api.modal_plots import plot_on_geometry
from autonomous_modal_analysis.api.result import Columns, Result
from autonomous_modal_analysis.api.robot import Layout, read_robot, Robot, sensors_of
from autonomous_modal_analysis.identified.results import plain
from autonomous_modal_analysis.pose import parse_pose, PoseGiven
from excitation_planner.pose_range import sensitivity_table, SensitivityTable
from modal_core.channel import SensorLayout
from modal_core.errors import SettingsError
from modal_core.files.version import software
from modal_core.mode import Mode, ModeSet
from modal_core.numbers.indicators import normalise
from modal_dashboard.arm_drawing import draw_arm
from structural_model.description import shown, unit_of
from structural_model.equations import DampedModes
from structural_model.flexible_joint_model import FlexibleJointModel
from structural_model.model_notes import model_notes

Array = NDArray[np.float64]
HIGHEST_HZ = 200.0
LOWEST_STEP_DEG, LARGEST_STEP_DEG = 0.01, 30.0


@dataclass(frozen=True, eq=False, repr=False)
class ModelAtPose(Result):
    """Modes of the model of a robot in one pose.

    Parameters
    ----------
    model : FlexibleJointModel
        The robot.
    layout : SensorLayout
        Its sensors.
    q : (n_joints,) array [rad]
        Serial joints.
    highest_hz : float [Hz]
        Modes above are left out.
    step_deg : float or None [deg]
        Joint step of the sensitivity; None: not asked for.
    """

    model: FlexibleJointModel
    layout: SensorLayout
    q: Array
    highest_hz: float
    step_deg: float | None = None

    @property
    def pose_deg(self) -> Array:
        """Controller angles, (n_joints,) [deg]; [m] of axes that slide."""
        return self.model.shown_axes(self.q)

    @property
    def channel_names(self) -> tuple[str, ...]:
        """Rows of ``shapes``."""
        return tuple(channel.name for channel in self.layout.channels)

    @property
    def frequencies_hz(self) -> Array:
        """Natural frequencies, (n_modes,) [Hz]."""
        return np.asarray(self._modes.frequency_hz[self._inside])

    @property
    def damping_ratios(self) -> Array:
        """Damping ratios as fractions of critical damping, (n_modes,)."""
        return np.asarray(self._modes.damping_ratio[self._inside])

    @property
    def shapes(self) -> NDArray[np.complex128]:
        """Mode shapes at the sensors as columns, (n_channels, n_modes)."""
        return np.asarray(self._modes.channel_shapes[:, self._inside])

    @property
    def modes(self) -> ModeSet:
        """The same as modes, the largest entry of each shape 1 + 0i; there must be sensors."""
        both = zip(self.frequencies_hz, self.damping_ratios, self.shapes.T, strict=True)
        has_channels = bool(self.channel_names)
        return ModeSet(
            tuple(
                Mode(float(frequency_hz), float(ratio), normalise(shape))
                for frequency_hz, ratio, shape in both
                if has_channels
            ),
            self.channel_names,
        )

    @cached_property
    def sensitivity(self) -> SensitivityTable | None:
        """How modes change with each joint; None where ``step_deg`` is."""
        if self.step_deg is None:
            return None
        return sensitivity_table(self.model, self.q, np.deg2rad(self.step_deg), self.highest_hz)

    @cached_property
    def _modes(self) -> DampedModes:
        return self.model.damped_modes(self.q, self.layout.channels)

    @property
    def _inside(self) -> NDArray[np.bool_]:
        return np.asarray(self._modes.frequency_hz <= self.highest_hz)

    @property
    def notes(self) -> tuple[str, ...]:
        """What to know of the model, and how many of its modes do not oscillate."""
        still = self.model.n_dof - len(self._modes.frequency_hz)
        left_out = (
            f'{still} of {self.model.n_dof} modes do not oscillate and are left out: overdamped,'
            ' or gravity overturns a spring',
        )
        return (*model_notes(self.model), *(left_out if still else ()))

    def headline(self) -> str:
        """Say which robot and pose, and how many modes there are."""
        angles = ', '.join(f'{angle:.4g}' for angle in self.pose_deg + 0.0)
        units = sorted({unit_of(slides) for slides in self.model.sliding})
        return (
            f'{self.model.robot_name} at ({angles}) {" or ".join(units)}: '
            f'{len(self.frequencies_hz)} modes up to {self.highest_hz:g} Hz'
        )

    def columns(self) -> Columns:
        """Return the modes, and their change with each joint where asked for."""
        table: dict[str, Sequence[Any]] = {
            'frequency_hz': self.frequencies_hz.tolist(),
            'damping_ratio': self.damping_ratios.tolist(),
        }
        if self.sensitivity is not None:
            for name, column in zip(
                self.sensitivity.joint_names, self.sensitivity.actual.T, strict=True
            ):
                known = column.tolist()
                unknown = [np.nan] * (len(self.frequencies_hz) - len(known))
                table[f'sensitivity.{name}'] = known + unknown
        return table

    def shown(self) -> Columns:
        """Return the modes as texts."""
        return {
            'frequency [Hz]': [f'{value:.2f}' for value in self.frequencies_hz],
            'damping [%]': [f'{100 * value:.2f}' for value in self.damping_ratios],
        }

    def to_dict(self) -> dict[str, Any]:
        """Return what ``ama model --json`` prints."""
        value: dict[str, object] = {
            'robot': self.model.robot_name,
            'pose_deg': self.pose_deg,
            'serial_pose_deg': shown(self.q, self.model.sliding),
            'frequencies_hz': self.frequencies_hz,
            'damping_ratios': self.damping_ratios,
            'channels': list(self.channel_names),
            'notes': list(self.notes),
            'shapes': {'real': self.shapes.real.T, 'imag': self.shapes.imag.T},
        }
        if self.sensitivity is not None:
            value['sensitivity'] = self.sensitivity
        return {name: plain(item) for name, item in value.items()}

    def plot_shapes(self) -> Any:
        """Draw the arm as each mode moves it.

        Returns
        -------
        (n_modes,) array of matplotlib Axes
            In one figure.

        Raises
        ------
        ModalAnalysisError
            matplotlib is not installed.
        """
        modes = self.modes
        drawing = draw_arm(self.model, self.q, self.layout, modes)
        return plot_on_geometry(modes, drawing.geometry, drawing.displacements)

    def export(self, path: str | Path) -> None:
        """Write the modes into one file of another program, whole or not at all.

        Parameters
        ----------
        path : path
            Ends in .uff or .unv (datasets 15, 82, 55), .mat, .nc, .parquet or .csv.

        Raises
        ------
        ModalAnalysisError
            No such kind, a library that it needs is not installed, or there are no sensors.
        OSError
            It cannot be written.
        """
        from autonomous_modal_analysis.export import export_arm_modes

        about = {'result': self.headline(), 'software': software()}
        export_arm_modes(Path(path), self.model, self.layout, self.q, self.modes, about)


def model(
    robot: Robot,
    pose_deg: PoseGiven = None,
    *,
    serial: bool = False,
    max_frequency_hz: float = HIGHEST_HZ,
    layout: Layout | None = None,
    step_deg: float | None = None,
) -> ModelAtPose:
    """Return natural frequencies, damping ratios and mode shapes of a robot in one pose.

    Parameters
    ----------
    robot : str, path or FlexibleJointModel
        Robot of config/robots by name, its folder, or its model.yaml.
    pose_deg : str, path, sequence of float [deg] or None
        Angles of the controller axes, the name of a pose, or a recording made there; None: the
        robot's first.
    serial : bool
        The angles are those of the serial joints, as in joint states; they differ where a rod
        couples axes.
    max_frequency_hz : float [Hz]
        Highest mode.
    layout : SensorLayout, mapping, path or None
        Sensors the shapes are seen by; None: the robot's own.
    step_deg : float [deg] or None
        Also say how the modes change when each joint is turned by so much.

    Returns
    -------
    ModelAtPose

    Raises
    ------
    ModalAnalysisError
        There is no such robot or pose, or the pose is out of range.

    Examples
    --------
    >>> import autonomous_modal_analysis as ama
    >>> arm = ama.model('irb6660_205_190', 'P1', max_frequency_hz=30)
    >>> arm.frequencies_hz.round(1)[:3]
    array([ 9.6, 11.1, 19.4])
    """
    for name, value, low, high in (
        ('max_frequency_hz', max_frequency_hz, 0.01, np.inf),
        ('step_deg', step_deg, LOWEST_STEP_DEG, LARGEST_STEP_DEG),
    ):
        if value is not None and not low <= value <= high:
            raise SettingsError(
                'out of range', where=name, found=value, expected=f'{low:g} to {high:g}'
            )
    arm = read_robot(robot)
    sensors = sensors_of(robot, arm, layout) or SensorLayout(())
    return ModelAtPose(arm, sensors, parse_pose(arm, pose_deg, serial), max_frequency_hz, step_deg)
