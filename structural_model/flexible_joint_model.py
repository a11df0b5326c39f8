"""The robot as a flexible-joint model: rigid arm, springs, and what they do at a pose."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from modal_core.channel import Channel
from modal_core.errors import ModelError
from structural_model import sensing
from structural_model.assembly import assemble, Assembly
from structural_model.coupling import AxisMap
from structural_model.dynamics import Dynamics
from structural_model.geometry import RobotGeometry
from structural_model.kinematics import RigidKinematics
from structural_model.limits import check_length, RobotLimits
from structural_model.linearise import gravity_rows, sensor_rows, state_space
from structural_model.matrices import (
    damped_modes,
    DampedModes,
    ModelModes,
    StructuralMatrices,
    undamped_modes,
)
from structural_model.parameters import read_parameters, write_parameters
from structural_model.response import (
    frequency_response,
    Hold,
    Kind,
    simulate,
    StateSpace,
    TimeResponse,
)
from structural_model.scan import scan, WorkspaceScan
from structural_model.spec import ModelSpec
from structural_model.trajectory import follow
from structural_model.urdf import RigidRobot

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False, repr=False)
class FlexibleJointModel:
    """A robot arm with elastic joints, links and base, linearised at any pose.

    The drives prescribe the motor side; the flexible degrees of freedom x ride on it:
    M(q) x'' + C x' + K(q) x = -M_r(q) q'' - h(q, q') for small x.  The model is immutable:
    ``with_parameters`` and ``replace`` return new ones.

    Parameters
    ----------
    robot : RigidRobot
        The rigid arm of the URDF.
    spec : ModelSpec
        Everything the URDF does not say.
    limits : RobotLimits
        What the axes may do; holds the map between serial joints and controller axes.
    poses_controller_rad : dict of str to tuple [rad]
        Named poses in controller angles.
    collision_ignore : tuple of (link, link)
        Pairs that may touch.
    name : str
        Name of the robot; that of the URDF when empty.
    """

    robot: RigidRobot
    spec: ModelSpec
    limits: RobotLimits
    poses_controller_rad: Mapping[str, tuple[float, ...]]
    collision_ignore: tuple[tuple[str, str], ...] = ()
    name: str = ''

    def __repr__(self) -> str:
        return f'FlexibleJointModel({self.robot_name!r}, n_dof={self.n_dof})'

    def __getstate__(self) -> dict[str, object]:
        """Leave out what is worked out on demand: another process does it again."""
        return {field.name: getattr(self, field.name) for field in fields(self)}

    # -- what the robot is ---------------------------------------------------------------------

    @property
    def robot_name(self) -> str:
        """Name of the robot."""
        return self.name or self.robot.name

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Moving joints, in the order of every q."""
        return self.robot.joint_names

    @property
    def link_names(self) -> tuple[str, ...]:
        """Links a sensor can sit on."""
        return self.robot.link_names

    @property
    def axes(self) -> AxisMap:
        """The map between serial joints and controller axes."""
        return self.limits.axes

    @property
    def n_joints(self) -> int:
        """Number of moving joints."""
        return len(self.robot.joints)

    @property
    def n_dof(self) -> int:
        """Number of flexible degrees of freedom."""
        return len(self.assembly.dof_names)

    @property
    def dof_names(self) -> tuple[str, ...]:
        """Rows of M, C and K, for example ``joint_2/drive``."""
        return self.assembly.dof_names

    def to_serial(self, controller_rad: ArrayLike) -> Array:
        """Return serial joint angles of controller (ABB) angles, (..., n_joints) [rad]."""
        return self.axes.to_serial(check_length(controller_rad, self.joint_names, self.robot_name))

    def to_controller(self, serial_rad: ArrayLike) -> Array:
        """Return controller (ABB) angles of serial joint angles, (..., n_joints) [rad]."""
        return self.axes.to_controller(check_length(serial_rad, self.joint_names, self.robot_name))

    def pose(self, name: str) -> Array:
        """Return a named pose as serial joint angles [rad].

        Raises
        ------
        ModelError
            No such pose.
        """
        if name not in self.poses_controller_rad:
            raise ModelError(
                'unknown pose',
                where=self.robot_name,
                found=name,
                expected=', '.join(self.poses_controller_rad),
            )
        return self.to_serial(self.poses_controller_rad[name])

    def check_pose(self, q: ArrayLike) -> Array:
        """Return q when it has the right length and lies inside all ranges.

        Raises
        ------
        ModelError
            With joint, angle and range.
        """
        values = check_length(q, self.joint_names, self.robot_name)
        self.limits.check_pose(values, self.robot_name)
        return values

    # -- changing it ---------------------------------------------------------------------------

    def replace(self, spec: ModelSpec) -> 'FlexibleJointModel':
        """Return this robot with other flexibilities, masses or dampers."""
        return FlexibleJointModel(
            robot=self.robot,
            spec=spec,
            limits=self.limits,
            poses_controller_rad=self.poses_controller_rad,
            collision_ignore=self.collision_ignore,
            name=self.name,
        )

    def parameters(self) -> dict[str, float]:
        """Return every number of the spec by dotted name, such as ``masses.tool.mass_kg``."""
        return read_parameters(self.spec)

    def with_parameters(self, values: Mapping[str, float]) -> 'FlexibleJointModel':
        """Return the model with some numbers of the spec changed.

        Raises
        ------
        ModelError
            A name is unknown.
        """
        return self.replace(write_parameters(self.spec, values))

    # -- dynamics at a pose --------------------------------------------------------------------

    @cached_property
    def assembly(self) -> Assembly:
        """The expanded pinocchio model."""
        return assemble(self.robot, self.spec, self.axes)

    @cached_property
    def kinematics(self) -> RigidKinematics:
        """Vectorised rigid kinematics."""
        return RigidKinematics(self.robot)

    @cached_property
    def geometry(self) -> RobotGeometry:
        """Shapes of the arm: drawing, point speeds, self-collision."""
        return RobotGeometry(self.robot, self.kinematics, self.collision_ignore)

    @cached_property
    def dynamics(self) -> Dynamics:
        """Dynamics of the expanded arm."""
        return Dynamics(self.joint_names, self.assembly, self.spec, self.axes)

    def matrices(self, q: ArrayLike, deflection: ArrayLike | None = None) -> StructuralMatrices:
        """Return M, C and K at a pose, gravity and compensator stiffness included.

        Parameters
        ----------
        q : (n_joints,) array [rad]
            Serial joint angles.
        deflection : (n_dof,) array
            Linearise about this deflection, for example ``static_deflection(q)``, instead of zero.

        References
        ----------
        Do et al., linearisation with gravity at any posture (the paper's reference 9).
        """
        return self.dynamics.matrices(q, deflection)

    def input_matrix(self, q: ArrayLike) -> Array:
        """Return the force on the flexible degrees of freedom per unit motor-side acceleration.

        Parameters
        ----------
        q : (n_joints,) array [rad]
            Serial joint angles.

        Returns
        -------
        (n_dof, n_joints) array [kg m²]
            -M_r; zero on the motors of soft servos, whose own inertia the servo feeds forward.
        """
        return self.dynamics.input_matrix(q)

    def gravity_coupling(self, q: ArrayLike) -> Array:
        """Return the change of the gravity load on each deflection per unit motor-side motion.

        Returns
        -------
        (n_dof, n_joints) array [N m/rad]
            Compensators included.
        """
        return self.dynamics.gravity_coupling(q)

    def rigid_force(self, q: ArrayLike, qd: ArrayLike, qdd: ArrayLike) -> Array:
        """Return the full force of the rigid motion on the flexible degrees of freedom.

        Parameters
        ----------
        q, qd, qdd : (n_joints,) or (n_samples, n_joints) array
            Serial joint motion.

        Returns
        -------
        (n_dof,) or (n_samples, n_dof) array
            Inertia, centrifugal, Coriolis, gravity and compensator force at x = 0.
        """
        force = self.dynamics.rigid_force(q, qd, qdd)
        return force[0] if np.ndim(q) == 1 else force

    def static_deflection(self, q: ArrayLike) -> Array:
        """Return the deflection at which springs and gravity balance, (n_dof,)."""
        return self.dynamics.static_deflection(q)

    def torque(self, q: ArrayLike, qd: ArrayLike, qdd: ArrayLike) -> Array:
        """Return serial joint torques of a rigid motion, rotor inertia included (RNEA).

        Parameters
        ----------
        q, qd, qdd : (n_joints,) or (n_samples, n_joints) array
            Serial joint motion.

        Returns
        -------
        (n_joints,) or (n_samples, n_joints) array [N m]
        """
        torque = self.dynamics.torque(q, qd, qdd)
        return torque[0] if np.ndim(q) == 1 else torque

    def drive_torque(self, q: ArrayLike, qd: ArrayLike, qdd: ArrayLike) -> Array:
        """Return the torque of each drive (controller axis) behind its gear; see ``torque``."""
        return self.axes.torque_to_controller(self.torque(q, qd, qdd))

    def drive_angle(self, q: ArrayLike) -> Array:
        """Return the angle of each motor shaft, coupled axes and gears included; linear.

        Parameters
        ----------
        q : (n_joints,) or (n_samples, n_joints) array [rad]
            Serial joint angles; speeds give speeds.

        Returns
        -------
        (n_joints,) or (n_samples, n_joints) array [rad]
        """
        ratios = np.array([joint.drive.gear_ratio for joint in self.spec.joints])
        return np.asarray(self.axes.to_controller(q) * ratios)

    # -- modes and responses -------------------------------------------------------------------

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
        readings = sensing.rigid_readings(self.assembly, motion, channels, gravity)
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

    # -- drawing -------------------------------------------------------------------------------

    def frame_positions(self, q: ArrayLike) -> Array:
        """Return where the skeleton's points are, (n_points, 3) or (n_poses, n_points, 3) [m]."""
        return self.geometry.skeleton(q)

    def deflected(self, q: ArrayLike, mode_vector: ArrayLike, scale: float = 1.0) -> Array:
        """Return the skeleton's points moved by a mode, (n_points, 3) [m].

        Parameters
        ----------
        q : (n_joints,) array [rad]
            Serial joint angles.
        mode_vector : (n_dof,) array
            A column of ``modes(q).shapes``.
        scale : float
            Factor on the mode.
        """
        channels = self.geometry.skeleton_channels
        rows = self.sensor_jacobian(q, channels) @ np.real(np.asarray(mode_vector))
        local = rows.reshape(-1, 3) * scale
        turned = self.geometry.to_base(q, local)
        return np.asarray(self.frame_positions(q) + turned)
