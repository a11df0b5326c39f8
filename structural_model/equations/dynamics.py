"""Mass, stiffness, loads and torques of the expanded arm at a pose, by pinocchio's algorithms."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
import pinocchio as pin

from modal_core.errors import ModelError
from structural_model.assembly import Assembly
from structural_model.description import AxisMap, check_length, CompensatorSpec, ModelSpec
from structural_model.equations.cables import cable_row, cable_stiffness
from structural_model.equations.matrices import StructuralMatrices

Array = NDArray[np.float64]
LARGEST_STEP_RAD = 1e-12
# What a step leaves is less than its square, 1e-5 rad, as of arms that hang up to 0.1 rad aside; a
# milliradian moves a frequency by a tenth of a percent at most.
LARGEST_SAG_STEP_RAD = 3e-3


@dataclass(frozen=True)
class Inputs:
    """How the motor side acts on the deflections at a pose.

    Parameters
    ----------
    inertia, gravity : (n_dof, n_joints) array
        Force per unit motor-side acceleration, and change of gravity's load per unit motion.
    """

    inertia: Array
    gravity: Array


@dataclass(frozen=True)
class Dynamics:
    """Dynamics of one expanded arm; every q is (n_joints,) serial joint angles [rad].

    Parameters
    ----------
    joint_names : tuple of str
        Entries of q.
    assembly : Assembly
        The expanded arm.
    spec : ModelSpec
        Its gravity, compensators, damping and rotors.
    axes : AxisMap
        Rotors turn with controller axes.
    """

    joint_names: tuple[str, ...]
    assembly: Assembly
    spec: ModelSpec
    axes: AxisMap

    @property
    def n_dof(self) -> int:
        """Number of flexible degrees of freedom."""
        return len(self.assembly.dof_names)

    def position(self, q: ArrayLike, deflection: ArrayLike | None = None) -> Array:
        """Return pinocchio's coordinate vector of a pose and a deflection."""
        angles = check_length(q, self.joint_names)
        if angles.ndim != 1:
            raise ModelError(
                'one pose is asked for', found=angles.shape, advice='use scan for many poses'
            )
        full = np.zeros(self.assembly.model.nq)
        full[self.assembly.drives] = angles
        if deflection is not None:
            full[self.assembly.flexible] += np.asarray(deflection)[: len(self.assembly.flexible)]
        return full

    def mass(self, full: Array) -> Array:
        """Return pinocchio's whole mass matrix; its Python bindings fill both triangles."""
        return np.array(pin.crba(self.assembly.model, self.assembly.data, full))

    def matrices(self, q: ArrayLike, deflection: ArrayLike | None = None) -> StructuralMatrices:
        """Return M, C and K, gravity and compensator stiffness included."""
        full = self.position(q, deflection)
        return self._matrices(full, self.mass(full), self._gravity_slope(full))

    def equations(
        self, q: ArrayLike, deflection: ArrayLike | None = None
    ) -> tuple[StructuralMatrices, Inputs]:
        """Return ``matrices``, and what ``input_matrix`` and ``gravity_coupling`` are, at once."""
        full = self.position(q, deflection)
        mass, slope = self.mass(full), self._gravity_slope(full)
        inputs = Inputs(self._input_matrix(mass), self._gravity_coupling(full, slope))
        return self._matrices(full, mass, slope), inputs

    def _matrices(self, full: Array, whole: Array, slope: Array) -> StructuralMatrices:
        assembly, damping = self.assembly, self.spec.damping
        mass = self._mass_matrix(whole)
        return StructuralMatrices(
            M=mass,
            C=assembly.damping
            + damping.mass_proportional_1_s * mass
            + damping.stiffness_proportional_s * assembly.stiffness,
            K=self._stiffness(full, slope),
            dof_names=assembly.dof_names,
        )

    def mass_matrix(self, q: ArrayLike, deflection: ArrayLike | None = None) -> Array:
        """Return M alone, (n_dof, n_dof)."""
        return self._mass_matrix(self.mass(self.position(q, deflection)))

    def _mass_matrix(self, whole: Array) -> Array:
        assembly = self.assembly
        places, count = assembly.flexible, len(assembly.flexible)
        mass = np.zeros((self.n_dof, self.n_dof))
        mass[:count, :count] = whole[places[:, None], places]
        motors = np.arange(count, self.n_dof)
        mass[motors, motors] = assembly.motor_inertia
        return mass

    def _stiffness(self, full: Array, slope: Array) -> Array:
        """Return K, gravity and compensators included."""
        assembly, count = self.assembly, len(self.assembly.flexible)
        stiffness = assembly.stiffness.copy()
        gravity = slope[assembly.flexible[:, None], assembly.flexible]
        stiffness[:count, :count] += 0.5 * (gravity + gravity.T)
        for item in self.spec.compensators:
            row = self._row(item)
            if row is not None:
                stiffness[row, row] += item.strength_nm * np.cos(self._turn(item, full))
        for cable in self.spec.cables:
            whole = cable_stiffness(assembly, cable, full)
            stiffness[:count, :count] += whole[assembly.flexible[:, None], assembly.flexible]
        return stiffness

    def input_matrix(self, q: ArrayLike, deflection: ArrayLike | None = None) -> Array:
        """Return -M_r, (n_dof, n_joints)."""
        return self._input_matrix(self.mass(self.position(q, deflection)))

    def _input_matrix(self, whole: Array) -> Array:
        assembly = self.assembly
        matrix = np.zeros((self.n_dof, len(self.joint_names)))
        matrix[: len(assembly.flexible)] = -whole[assembly.flexible[:, None], assembly.drives]
        return matrix

    def gravity_coupling(self, q: ArrayLike, deflection: ArrayLike | None = None) -> Array:
        """Return the change of the gravity load on x per unit motor-side motion."""
        full = self.position(q, deflection)
        return self._gravity_coupling(full, self._gravity_slope(full))

    def _gravity_coupling(self, full: Array, slope: Array) -> Array:
        assembly = self.assembly
        coupling = np.zeros((self.n_dof, len(self.joint_names)))
        coupling[: len(assembly.flexible)] = slope[assembly.flexible[:, None], assembly.drives]
        for item in self.spec.compensators:
            row, column = self._row(item), self.joint_names.index(item.joint)
            if row is not None:
                coupling[row, column] += item.strength_nm * np.cos(self._turn(item, full))
        for cable in self.spec.cables:
            whole = cable_stiffness(assembly, cable, full)
            coupling[: len(assembly.flexible)] += whole[
                assembly.flexible[:, None], assembly.drives
            ]
        return coupling

    def rigid_force(self, q: ArrayLike, qd: ArrayLike, qdd: ArrayLike) -> Array:
        """Return the load of a rigid motion on x, (n_samples, n_dof)."""
        assembly = self.assembly
        rows = [np.atleast_2d(check_length(part, self.joint_names)) for part in (q, qd, qdd)]
        force = np.zeros((len(rows[0]), self.n_dof))
        torque = self._inverse_dynamics(rows)
        force[:, : len(assembly.flexible)] = -torque[:, assembly.flexible]
        for item in self.spec.compensators:
            row = self._row(item)
            if row is not None:
                turn = rows[0][:, self.joint_names.index(item.joint)] - self.neutral(item)
                force[:, row] -= item.strength_nm * np.sin(turn)
        return force

    def torque(self, q: ArrayLike, qd: ArrayLike, qdd: ArrayLike) -> Array:
        """Return serial joint torques of a rigid motion, (n_samples, n_joints) [N m]."""
        rows = [np.atleast_2d(check_length(part, self.joint_names)) for part in (q, qd, qdd)]
        T, drives = self.axes.matrix, [joint.drive for joint in self.spec.joints]
        rotor = np.diag([drive.gear_ratio**2 * drive.rotor_inertia_kg_m2 for drive in drives])
        torque = self._inverse_dynamics(rows)[:, self.assembly.drives]
        torque = torque + rows[2] @ (T.T @ rotor @ T)
        for item in self.spec.compensators:
            column = self.joint_names.index(item.joint)
            turn = rows[0][:, column] - self.neutral(item)
            torque[:, column] += item.strength_nm * np.sin(turn)
        return np.asarray(torque)

    def link_inertia(self, q: ArrayLike) -> Array:
        """Return the drive torques on the links per acceleration of each axis; no rotors."""
        drives, inverse = self.assembly.drives, np.linalg.inv(self.axes.matrix)
        mass = self.mass(self.position(q, None))[drives[:, None], drives]
        return np.asarray(inverse.T @ mass @ inverse)

    def static_deflection(self, q: ArrayLike) -> Array:
        """Return the deflection at which springs and gravity balance (Newton), (n_dof,).

        Raises
        ------
        ModelError
            There is none near zero.
        """
        return self._balance(q, LARGEST_STEP_RAD)

    def sag(self, q: ArrayLike) -> Array:
        """Return the static deflection but for what no frequency shows, (n_dof,).

        One step where gravity bends the arm by milliradians, more where a counterbalance does.

        Raises
        ------
        ModelError
            There is none near zero.
        """
        return self._balance(q, LARGEST_SAG_STEP_RAD)

    def _balance(self, q: ArrayLike, last: float) -> Array:
        """Return the static deflection by Newton steps, until one is smaller than the last."""
        deflection = np.zeros(self.n_dof)
        for _ in range(30):
            full = self.position(q, deflection)
            load = self._static_load(full) - self.assembly.stiffness @ deflection
            try:
                step = np.linalg.solve(self._stiffness(full, self._gravity_slope(full)), load)
            except np.linalg.LinAlgError as error:  # something is held by nothing
                found = np.asarray(q).tolist()
                raise ModelError('no static equilibrium found', found=found) from error
            deflection = deflection + step
            if np.abs(step).max(initial=0.0) < last:
                return np.asarray(deflection)
        raise ModelError('no static equilibrium found', found=np.asarray(q).tolist())

    def _static_load(self, full: Array) -> Array:
        assembly = self.assembly
        gravity = pin.computeGeneralizedGravity(assembly.model, assembly.data, full)
        load = np.zeros(self.n_dof)
        load[: len(assembly.flexible)] = (self._pulls(full) - gravity)[assembly.flexible]
        for item in self.spec.compensators:
            row = self._row(item)
            if row is not None:
                load[row] -= item.strength_nm * np.sin(self._turn(item, full))
        return load

    def _inverse_dynamics(self, rows: list[Array]) -> Array:
        assembly = self.assembly
        model, data = assembly.model, assembly.data
        full, rate, rise = np.zeros(model.nq), np.zeros(model.nv), np.zeros(model.nv)
        torque = np.empty((len(rows[0]), model.nv))
        for sample, (angle, speed, acceleration) in enumerate(zip(*rows, strict=True)):
            full[assembly.drives] = angle
            rate[assembly.drives], rise[assembly.drives] = speed, acceleration
            torque[sample] = pin.rnea(model, data, full, rate, rise) - self._pulls(full)
        return torque

    def _pulls(self, full: Array) -> Array:
        """Return what cables pull at pinocchio's coordinates, (n_v,)."""
        pulls = np.zeros(self.assembly.model.nv)
        for cable in self.spec.cables:
            if cable.pull_n:
                pulls += cable.pull_n * cable_row(self.assembly, cable, full)
        return pulls

    def _gravity_slope(self, full: Array) -> Array:
        if not any(self.spec.gravity_m_s2):
            return np.zeros((len(full), len(full)))
        assembly = self.assembly
        return np.asarray(
            pin.computeGeneralizedGravityDerivatives(assembly.model, assembly.data, full)
        )

    def _row(self, item: CompensatorSpec) -> int | None:
        name = f'{item.joint}/drive'
        names = self.assembly.dof_names
        return names.index(name) if name in names else None

    def _turn(self, item: CompensatorSpec, full: Array) -> float:
        place = self.assembly.drives[self.joint_names.index(item.joint)]
        return float(full[place]) - self.neutral(item)

    def neutral(self, item: CompensatorSpec) -> float:
        """Return what the encoder says where a compensator is neutral."""
        joint = next(joint for joint in self.spec.joints if joint.name == item.joint)
        return item.phase_rad - joint.offset_rad
