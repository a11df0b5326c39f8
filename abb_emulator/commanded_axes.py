"""Where the axes are commanded and where they are: moves, stops, and their supervision."""

from dataclasses import replace
import math

import numpy as np
from numpy.typing import NDArray

from abb_emulator.controller_settings import ControllerSettings
from abb_emulator.drives import CommandedMotion, JointMove, MoveLimits, Stop, Supervision
from modal_core.errors import BridgeError
from structural_model.flexible_joint_model import FlexibleJointModel

Array = NDArray[np.float64]
AT_TARGET_DEG = 1e-6
STANDING_DEG = 0.005


class CommandedAxes:
    """The six axes of a controller.

    Parameters
    ----------
    model : FlexibleJointModel
        Ranges, speeds and kinematics.
    start_deg : (6,) array [deg]
        Where the axes stand, in controller angles.
    settings : ControllerSettings
        Figures.

    Attributes
    ----------
    planned_deg, planned_speed_deg_s, measured_deg : (6,) array [deg], [deg/s], [deg]
        Commanded position and speed; where the motors are.
    motion : CommandedMotion or None
        What moves them; None where nothing does.
    """

    def __init__(
        self, model: FlexibleJointModel, start_deg: Array, settings: ControllerSettings
    ) -> None:
        self.planned_deg = np.array(start_deg, float)
        self.planned_speed_deg_s = np.zeros_like(self.planned_deg)
        self.measured_deg = self.planned_deg.copy()
        self.motion: CommandedMotion | None = None
        self._model, self._settings = model, settings
        self._supervision = Supervision(
            model, settings.cycle_s, settings.speed_slack, settings.following_error_deg
        )

    @property
    def moving(self) -> bool:
        """The commanded position moves."""
        return self.motion is not None

    @property
    def standing(self) -> bool:
        """The motors are where they are commanded."""
        away = float(np.max(np.abs(self.measured_deg - self.planned_deg)))
        return self.motion is None and away < STANDING_DEG

    @property
    def utilization(self) -> float:
        """Largest part of any axis' speed limit in use [%]."""
        part = np.abs(self.planned_speed_deg_s) / self._supervision.top_speed_deg_s
        return 100.0 * float(np.max(part))

    def at(self, target_deg: Array) -> bool:
        """Tell whether the commanded position is the target."""
        return bool(np.max(np.abs(self.planned_deg - target_deg)) < AT_TARGET_DEG)

    def move(self, target_deg: Array, limits: MoveLimits, automatic: bool) -> None:
        """Begin a move from where the axes are commanded; manual mode is slow.

        Raises
        ------
        BridgeError
            The target is out of range; nothing moves.
        """
        outside = self._supervision.outside(target_deg)
        if outside:
            raise BridgeError(f'target out of range: {outside}')
        if not automatic:
            tool_mm_s = min(limits.tool_speed_mm_s, 1e3 * self._settings.manual_speed_m_s)
            limits = replace(limits, tool_speed_mm_s=tool_mm_s)
        self.motion = JointMove(
            self._model, self.planned_deg, target_deg, limits, self._settings.cycle_s
        )

    def halt(self) -> None:
        """Bring the axes to standstill on the ramp of a stop, anew if one is on its way."""
        if np.any(self.planned_speed_deg_s):
            self.motion = Stop(
                self.planned_deg,
                self.planned_speed_deg_s,
                self._settings.stop_s,
                self._settings.cycle_s,
            )
        else:
            self.motion = None

    def step(self, motors_on: bool, automatic: bool) -> str:
        """Advance by one cycle; return what supervision finds wrong, and stay where that is."""
        cycle_s, source = self._settings.cycle_s, self.motion
        if source is None or not motors_on:
            still = Stop(self.planned_deg, self.planned_speed_deg_s, cycle_s, cycle_s)
            target = still.step()
        else:
            target = source.step()
            if source.finished:
                self.motion = None
        is_free = source is None or isinstance(source, Stop)
        fault = '' if is_free else self._fault(target, automatic)
        if not fault:
            self._command(target)
        return fault

    def give_way(self) -> None:
        """Take the first step of a stop, in the cycle whose step was refused."""
        self._command(self.motion.step() if self.motion is not None else self.planned_deg)

    def _command(self, target: Array) -> None:
        self.planned_speed_deg_s = (target - self.planned_deg) / self._settings.cycle_s
        self.planned_deg = target

    def _fault(self, target: Array, automatic: bool) -> str:
        """Return what is wrong with the next position; empty when nothing is."""
        tool_m_s = math.inf if automatic else self._settings.manual_speed_m_s
        check = self._supervision
        return (
            check.range_fault(self.planned_deg, target)
            or check.speed_fault(self.planned_deg, target, tool_m_s)
            or check.following_fault(target, self.measured_deg)
        )
