"""What the axes may do."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from modal_core.errors import ModelError
from structural_model.description.coupling import AxisMap
from structural_model.description.shown_units import shown, unit_of

SLACK_RAD = 1e-9


@dataclass(frozen=True)
class PositionViolation:
    """One joint outside its range.

    Parameters
    ----------
    joint : str
        Name of the controller axis or of the serial joint.
    kind : str
        ``axis range`` (controller angle) or ``coupled range`` (serial angle).
    sample : int
        Row of the pose.
    value_rad, low_rad, high_rad : float [rad]
        The angle and what it must lie between.
    """

    joint: str
    kind: str
    sample: int
    value_rad: float
    low_rad: float
    high_rad: float


@dataclass(frozen=True)
class RobotLimits:
    """Limits of every axis; all arrays are (n_joints,).

    Parameters
    ----------
    joint_names : tuple of str
        One per column.
    axes : AxisMap
        Between serial joints and controller axes.
    controller_low, controller_high : array [rad]
        Range of the controller angle.
    position_low, position_high : array [rad]
        Range of the serial joint angle: the coupled range where axes are coupled, else the same.
    velocity, acceleration, jerk : array [rad/s], [rad/s²], [rad/s³]
        Largest magnitude on the controller axis.
    effort : array [N m]
        Largest drive torque at the link side of the gear.
    """

    joint_names: tuple[str, ...]
    axes: AxisMap
    controller_low: NDArray[np.float64]
    controller_high: NDArray[np.float64]
    position_low: NDArray[np.float64]
    position_high: NDArray[np.float64]
    velocity: NDArray[np.float64]
    acceleration: NDArray[np.float64]
    jerk: NDArray[np.float64]
    effort: NDArray[np.float64]

    @property
    def axis_names(self) -> tuple[str, ...]:
        """Names of the controller axes, which are not those of the serial joints."""
        return axis_names(self.joint_names)

    def position_violation(self, q: ArrayLike) -> PositionViolation | None:
        """Return the first pose outside the ranges, or None.

        Parameters
        ----------
        q : (n_joints,) or (n_poses, n_joints) array [rad]
            Serial joint angles.
        """
        serial = np.atleast_2d(np.asarray(q, dtype=float))
        axis = self.axes.to_controller(serial)
        checks = (
            ('axis range', self.axis_names, axis, self.controller_low, self.controller_high),
            ('coupled range', self.joint_names, serial, self.position_low, self.position_high),
        )
        for kind, names, angle, low, high in checks:
            outside = ~((angle >= low - SLACK_RAD) & (angle <= high + SLACK_RAD))
            if outside.any():
                sample, joint = (int(index) for index in np.argwhere(outside)[0])
                return PositionViolation(
                    joint=names[joint],
                    kind=kind,
                    sample=sample,
                    value_rad=float(angle[sample, joint]),
                    low_rad=float(low[joint]),
                    high_rad=float(high[joint]),
                )
        return None

    def check_pose(self, q: ArrayLike, where: str = '', sliding: Sequence[bool] = ()) -> None:
        """Refuse a pose outside the ranges.

        Parameters
        ----------
        q : (n_joints,) or (n_poses, n_joints) array [rad], [m]
            Serial joints.
        where : str
            For the message.
        sliding : (n_joints,) sequence of bool
            Which joints slide; empty: none.

        Raises
        ------
        ModelError
            With joint, angle and range in degrees, or in metres where it slides.
        """
        found = self.position_violation(q)
        if found is not None:
            names = self.axis_names if found.joint in self.axis_names else self.joint_names
            slides = [bool(sliding) and sliding[names.index(found.joint)]]
            given = np.array([[found.low_rad], [found.high_rad], [found.value_rad]])
            low, high, value = shown(given, slides).ravel()
            unit = unit_of(slides[0])
            raise ModelError(
                f'pose outside the {found.kind} of {found.joint}',
                where=where,
                found=f'{value:.3f} {unit}',
                expected=f'{low:.3f} to {high:.3f} {unit}',
            )


def axis_names(joint_names: Sequence[str]) -> tuple[str, ...]:
    """Return names for controller axes that cannot be taken for those of serial joints."""
    return tuple(
        name.replace('joint', 'axis') if 'joint' in name else f'axis of {name}'
        for name in joint_names
    )


def check_length(q: ArrayLike, joint_names: Sequence[str], where: str = '') -> NDArray[np.float64]:
    """Return q as a finite float array with one entry per joint on the last axis.

    Raises
    ------
    ModelError
        Wrong length, or not finite.
    """
    values = np.asarray(q, dtype=float)
    if values.ndim == 0 or values.shape[-1] != len(joint_names):
        raise ModelError(
            'wrong number of joint values',
            where=where,
            found=values.shape[-1] if values.ndim else 'a scalar',
            expected=f'{len(joint_names)}: {", ".join(joint_names)}',
        )
    if not np.isfinite(values).all():
        raise ModelError('joint values are not finite', where=where)
    return values
