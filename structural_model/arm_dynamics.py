"""Dynamics of the flexible arm at a pose: matrices, forces, torques."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from structural_model.arm_description import ArmDescription
from structural_model.assembly import assemble, Assembly
from structural_model.equations import Dynamics, StructuralMatrices
from structural_model.rigid import RigidKinematics, RobotGeometry

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False, repr=False)
class ArmDynamics(ArmDescription):
    """The arm expanded by its flexible degrees of freedom x, linearised at any pose.

    The drives prescribe the motor side; x rides on it:
    M(q) x'' + C x' + K(q) x = -M_r(q) q'' - h(q, q') for small x.

    Parameters
    ----------
    robot, spec, limits, poses_controller_rad, collision_ignore, name
        See `ArmDescription`.
    """

    @property
    def n_dof(self) -> int:
        """Number of flexible degrees of freedom."""
        return len(self.assembly.dof_names)

    @property
    def dof_names(self) -> tuple[str, ...]:
        """Rows of M, C and K, for example ``joint_2/drive``."""
        return self.assembly.dof_names

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

    def mass_matrix(self, q: ArrayLike) -> Array:
        """Return M of `matrices` at a pose alone, (n_dof, n_dof): several times as fast."""
        return self.dynamics.mass_matrix(q)

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
        return _as_asked(self.dynamics.rigid_force(q, qd, qdd), q)

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
        return _as_asked(self.dynamics.torque(q, qd, qdd), q)

    def drive_torque(self, q: ArrayLike, qd: ArrayLike, qdd: ArrayLike) -> Array:
        """Return the torque of each drive (controller axis) behind its gear; see ``torque``."""
        return self.axes.torque_to_controller(self.torque(q, qd, qdd))

    def link_inertia(self, q: ArrayLike) -> Array:
        """Return the torque of every drive on the structure per acceleration of a controller axis.

        The rigid mass matrix in controller axes, without rotors: what the gears hand on.

        Parameters
        ----------
        q : (n_joints,) array [rad]
            Serial joint angles.

        Returns
        -------
        (n_joints, n_joints) array [kg m²]
        """
        return self.dynamics.link_inertia(q)

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


def _as_asked(rows: Array, q: ArrayLike) -> Array:
    """Return the only row where one pose was asked for."""
    return rows[0] if np.ndim(q) == 1 else rows
