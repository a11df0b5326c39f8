"""The robot as a flexible-joint model: rigid arm, springs, and what they do at a pose."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from modal_core.channel import Channel
from structural_model.arm_dynamics import ArmDynamics
from structural_model.description import check_length
from structural_model.equations import (
    damped_modes,
    DampedModes,
    follow,
    frequency_response,
    gravity_rows,
    Hold,
    Kind,
    ModelModes,
    rigid_readings,
    scan,
    sensor_rows,
    simulate,
    state_space,
    StateSpace,
    TimeResponse,
    undamped_modes,
    WorkspaceScan,
)

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False, repr=False)
class FlexibleJointModel(ArmDynamics):
    """A robot arm with elastic joints, links and base, linearised at any pose.

    The model is immutable: ``with_parameters`` and ``replace`` return new ones.

    Parameters
    ----------
    robot, spec, limits, poses_controller_rad, collision_ignore, name
        See `ArmDescription`.
    """

    def __repr__(self) -> str:
        return f'FlexibleJointModel({self.robot_name!r}, n_dof={self.n_dof})'

    def modes(self, q: ArrayLike, channels: Sequence[Channel] = ()) -> ModelModes:
        """Return the undamped modes and their damping ratios at a pose."""
        matrices = self.matrices(q)
        return undamped_modes(matrices, self.sensor_jacobian(q, channels))

    def damped_modes(self, q: ArrayLike, channels: Sequence[Channel] = ()) -> DampedModes:
        """Return poles and complex modes at a pose: the truth for an identification."""
        return damped_modes(self.matrices(q), self.sensor_jacobian(q, channels))

    def sensor_jacobian(self, q: ArrayLike, channels: Sequence[Channel]) -> Array:
        """Return the motion of channels per unit deflection, in the sensors' own axes.

        Parameters
        ----------
        q : (n_joints,) array [rad]
            Serial joint angles.
        channels : sequence of Channel
            Accelerometer axes (displacement along) or angular velocity axes (turn about).

        Returns
        -------
        (n_channels, n_dof) array
        """
        return sensor_rows(self.dynamics, q, channels)[:, : self.n_dof]

    def rigid_jacobian(self, q: ArrayLike, channels: Sequence[Channel]) -> Array:
        """Return the motion of channels per unit motor-side motion, (n_channels, n_joints)."""
        return sensor_rows(self.dynamics, q, channels)[:, self.n_dof :]

    def gravity_jacobian(self, q: ArrayLike, channels: Sequence[Channel]) -> Array:
        """Return the change of gravity readings per unit deflection, (n_channels, n_dof)."""
        return gravity_rows(self.dynamics, q, channels)[:, : self.n_dof]

    def rigid_acceleration(
        self, q: ArrayLike, qd: ArrayLike, qdd: ArrayLike, channels: Sequence[Channel]
    ) -> Array:
        """Return what the channels read when the arm moves without deflection, gravity included.

        Parameters
        ----------
        q, qd, qdd : (n_joints,) or (n_samples, n_joints) array
            Serial joint motion.
        channels : sequence of Channel
            Accelerometer axes read d·Rᵀ(a - g), angular velocity axes d·Rᵀω.

        Returns
        -------
        (n_channels,) or (n_samples, n_channels) array
        """
        parts = [check_length(part, self.joint_names) for part in (q, qd, qdd)]
        motion = self.kinematics.motion(*parts)
        gravity = np.array(self.spec.gravity_m_s2)
        readings = rigid_readings(self.assembly, motion, channels, gravity)
        return readings[0] if np.ndim(q) == 1 else readings

    def frf(
        self,
        q: ArrayLike,
        inputs: Sequence[Channel],
        outputs: Sequence[Channel],
        frequency_hz: ArrayLike,
        kind: Kind = 'accelerance',
    ) -> NDArray[np.complex128]:
        """Return the response of channels to unit forces along (torques about) other channels.

        Returns
        -------
        (n_frequencies, n_outputs, n_inputs) complex array
            [m/N], [m/s/N] or [m/s²/N] by kind.
        """
        force = self.sensor_jacobian(q, inputs).T
        return frequency_response(
            self.matrices(q), force, self.sensor_jacobian(q, outputs), frequency_hz, kind
        )

    def state_space(
        self, q: ArrayLike, channels: Sequence[Channel], forces: Sequence[Channel] = ()
    ) -> StateSpace:
        """Return the linear system from motor accelerations (then forces) to channel readings.

        The states are the deflections, the motor-side departures from q, and the rates of both: a
        slow departure turns the sensors and the links in the field of gravity.

        Parameters
        ----------
        q : (n_joints,) array [rad]
            Serial joint angles.
        channels : sequence of Channel
            Outputs: readings less those at rest; rigid motion included.
        forces : sequence of Channel
            Further inputs: unit forces along these channels.
        """
        return state_space(self.dynamics, q, channels, forces)

    def time_response(
        self,
        q: ArrayLike,
        channels: Sequence[Channel],
        motor_acceleration: ArrayLike,
        sample_rate_hz: float,
        hold: Hold = 'linear',
    ) -> TimeResponse:
        """Return the channels' readings while the drives follow small accelerations about a pose.

        Parameters
        ----------
        q : (n_joints,) array [rad]
            Serial joint angles.
        channels : sequence of Channel
            Outputs.
        motor_acceleration : (n_samples, n_joints) array [rad/s²]
            Of the serial joints, at the motor side.
        sample_rate_hz : float [Hz]
            Rate of both.
        hold : {'linear', 'zero'}
            Of the acceleration between samples.
        """
        return simulate(self.state_space(q, channels), motor_acceleration, sample_rate_hz, hold)

    def trajectory_response(
        self,
        motion: Sequence[ArrayLike],
        channels: Sequence[Channel],
        sample_rate_hz: float,
        pose_step_rad: float = 2e-3,
    ) -> TimeResponse:
        """Return what the channels read along any motion, the pose changing as it goes.

        Parameters
        ----------
        motion : (q, qd, qdd), each (n_samples, n_joints) array
            Serial motor-side joint motion, starting from rest.
        channels : sequence of Channel
            Outputs: whole readings, gravity included.
        sample_rate_hz : float [Hz]
            Rate of both.
        pose_step_rad : float [rad]
            Matrices are renewed when a joint has moved this far.
        """
        found = follow(self.dynamics, motion, channels, sample_rate_hz, pose_step_rad)
        rigid = self.rigid_acceleration(motion[0], motion[1], motion[2], channels)
        return TimeResponse(output=found.output + rigid, state=found.state)

    def scan(
        self, q: ArrayLike, channels: Sequence[Channel] = (), n_modes: int | None = None
    ) -> WorkspaceScan:
        """Return the modes at many poses, (n_poses, n_joints) [rad], in one stacked solution."""
        return scan(self.dynamics, q, channels, n_modes)

    def deflected(self, q: ArrayLike, mode_vector: ArrayLike) -> Array:
        """Return the skeleton's points moved by a mode, (n_points, 3) [m].

        Parameters
        ----------
        q : (n_joints,) array [rad]
            Serial joint angles.
        mode_vector : (n_dof,) array
            A column of ``modes(q).shapes``, as large as it shall be drawn.
        """
        channels = self.geometry.skeleton_channels
        rows = self.sensor_jacobian(q, channels) @ np.real(np.asarray(mode_vector))
        return np.asarray(self.frame_positions(q) + self.geometry.to_base(q, rows.reshape(-1, 3)))

    def frame_positions(self, q: ArrayLike) -> Array:
        """Return where the skeleton's points are, (n_points, 3) or (n_poses, n_points, 3) [m]."""
        return self.geometry.skeleton(q)
