"""The arm of a cell at one pose as a linear system in modal form."""

import dataclasses
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
import scipy.linalg

from modal_core.channel import Channel
from modal_core.errors import ModelError
from structural_model import FlexibleJointModel
from structural_model.equations import reading_rows

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Complex64 = NDArray[np.complex64]
# Undamped modes above this follow at once; the band ends far below.
FAST_1_S = 2.0 * np.pi * 320.0
# Modes below this may still ring at the end of a record.
RINGING_1_S = 2.0 * np.pi * 60.0


@dataclass(frozen=True)
class PoseArm:
    """The arm at a pose before its modes are known: M x'' + C x' + K x = B a + P q.

    Parameters
    ----------
    M, C, K : (n, n) array
        Mass, damping and stiffness.
    inertia_input, shift_input : (n, n_joints) array
        B and P: force per motor acceleration, and per motor shift (gravity).
    rest : (n,) array [rad], [m]
        Deflection that it is linear about.
    """

    M: Array
    C: Array
    K: Array
    inertia_input: Array
    shift_input: Array
    rest: Array


@dataclass(frozen=True)
class PoseSystem:
    """M x'' + C x' + K x = B a + P q, y = Ja x'' + Jg x + Ra a + Rg q at one pose.

    Parameters
    ----------
    arm : PoseArm
        Its matrices.
    poles : (n_poles,) complex array [1/s]
        Of the damped arm, up to well above the band.
    shapes : (n, n_poles) complex array
        Deflection part of the right eigenvectors.
    drives : (n_poles, n) complex array
        Modal force per force on a degree of freedom.
    instant : (n, n) array
        Compliance of the faster modes, which follow a force at once.
    flexible, gravity : (n_channels, n) array
        Ja and Jg.
    rigid, rigid_gravity : (n_channels, n_joints) array
        Ra and Rg.
    dof_names : tuple of str
        Rows.
    """

    arm: PoseArm
    poles: Complex
    shapes: Complex
    drives: Complex
    instant: Array
    flexible: Array
    gravity: Array
    rigid: Array
    rigid_gravity: Array
    dof_names: tuple[str, ...]

    @cached_property
    def one_of_pairs(self) -> tuple[NDArray[np.intp], Array]:
        """Places of one pole of every pair and of real ones, and what each counts for: 2 or 1."""
        places = np.flatnonzero(self.poles.imag >= 0.0)
        return places, np.where(self.poles[places].imag > 0.0, 2.0, 1.0)

    def twist_per_force(self, omega: Array, vector: Array) -> Complex:
        """Return vᵀ times the deflection per force on each degree of freedom, (n, n_bins)."""
        resolvent = 1.0 / (1j * omega - self.poles[:, None])
        paths = ((vector @ self.shapes)[:, None] * self.drives).T
        return np.asarray(paths @ resolvent + (vector @ self.instant)[:, None])

    def deflection(
        self, omega: Array, force: Complex, end_state: Complex | None = None
    ) -> Complex:
        """Return deflection spectra (n, n_bins) under force spectra (n, n_bins).

        ``end_state`` (n_poles,) is what the modes carry out of the record: a record that starts
        at rest and ends in motion has (iω - λ)Z = G - z(T).
        """
        modal = self.drives @ force
        if end_state is not None:
            modal -= end_state[:, None]
        modal /= 1j * omega - self.poles[:, None]
        return np.asarray(self.shapes @ modal + _real_times(self.instant, force))

    def end_state(self, tail: Array, period_s: float) -> Complex:
        """Return the modes' state at the end of a motion that starts at rest, (n_poles,).

        Parameters
        ----------
        tail : (n_block, n_blocks, 2 n_joints) array [rad/s²], [rad]
            Accelerations of the motors, then their shifts, newest first; the first row is one
            period before the end.
        period_s : float [s]
            Between samples.
        """
        state = np.zeros(len(self.poles), dtype=complex)
        slow = np.flatnonzero((self.poles.imag > 0.0) & (self.poles.imag < RINGING_1_S))
        length, blocks, inputs = tail.shape
        step = self.poles[slow, None] * period_s
        inside = np.exp(step * np.arange(1, length + 1))
        ahead = np.exp(step * length * np.arange(blocks))
        # The motion is real: no complex copy of it is made.
        parts = np.concatenate([inside.real, inside.imag]).astype(tail.dtype) @ tail.reshape(
            length, -1
        )
        sums = (parts[: len(slow)] + 1j * parts[len(slow) :]).reshape(len(slow), blocks, inputs)
        pull = self.drives[slow] @ np.hstack([self.arm.inertia_input, self.arm.shift_input])
        whole = np.matmul(ahead[:, None], sums)[:, 0]
        state[slow] = np.sum(whole * pull, axis=1) * period_s
        twins = np.argmin(np.abs(self.poles - self.poles[slow, None].conj()), axis=1)
        state[twins] = state[slow].conj()
        return state

    def force(self, acceleration: Complex, shift: Complex) -> Complex:
        """Return the force of the motor motion on the degrees of freedom, (n, n_bins)."""
        return _real_times(self.arm.inertia_input, acceleration) + _real_times(
            self.arm.shift_input, shift
        )

    def response(self, omega: Array, force: Array) -> Complex:
        """Return readings per constant force spectrum (n,), (n_channels, n_bins)."""
        modal = (self.drives @ force)[:, None] / (1j * omega - self.poles[:, None])
        deflection = self.shapes @ modal + (self.instant @ force)[:, None]
        return np.asarray(self.flexible @ (-(omega**2) * deflection) + self.gravity @ deflection)

    def transfer(self, omega: Array) -> Complex64:
        """Return readings per force on the degrees of freedom, (n_channels, n, n_bins).

        With s = iω, s²/(s - λ) = s + λ + λ²/(s - λ), the residues of s add up to nothing, and a
        pair of poles is (a s + b) / (s² - 2 Re λ s + |λ|²) with real a, b.
        """
        places, count = self.one_of_pairs
        poles, s = self.poles[places], 1j * omega
        rows = self.gravity @ self.shapes[:, places]
        rows += poles**2 * (self.flexible @ self.shapes[:, places])
        residues = (count * rows)[:, None, :] * self.drives[places].T
        below = 1.0 / (s**2 - 2.0 * poles.real[:, None] * s + np.abs(poles[:, None]) ** 2)
        slow = ((count * poles * self.shapes[:, places]) @ self.drives[places]).real
        steady = self.gravity @ self.instant + self.flexible @ slow
        rising = self.flexible @ self.instant
        pairs = residues.real, -(residues * poles.conj()).real
        parts = np.concatenate([*pairs, steady[:, :, None], rising[:, :, None]], axis=2)
        shared = np.concatenate([s * below, below, [np.ones(len(s)), s**2]])
        found = _real_times(parts.reshape(len(parts) * parts.shape[1], -1), shared)
        return found.astype(np.complex64).reshape(*residues.shape[:2], -1)

    def reading(
        self, omega: Array, deflection: Complex, acceleration: Complex, shift: Complex
    ) -> Complex:
        """Return what the channels read, (n_channels, n_bins)."""
        return (
            _real_times(self.flexible, -(omega**2) * deflection)
            + _real_times(self.gravity, deflection)
            + _real_times(self.rigid, acceleration)
            + _real_times(self.rigid_gravity, shift)
        )


def _real_times(matrix: Array, spectra: Complex) -> Complex:
    """Return a real matrix times complex spectra: half the work of a complex product."""
    parts = np.ascontiguousarray(spectra, dtype=complex).view(float)
    return np.asarray((matrix @ parts).view(complex))


def sag(model: FlexibleJointModel, pose: Array, hanging: bool) -> Array:
    """Return the deflection to linearise about, (n_dof,): as the arm hangs in its springs, or 0.

    Gravity bends an arm by a milliradian; its frequencies are then up to a tenth of a percent off
    those of the motors' angles, which is seen at a lightly damped peak.
    """
    return model.dynamics.sag(pose) if hanging else np.zeros(model.n_dof)


def pose_arm(model: FlexibleJointModel, pose: Array, hanging: bool = True) -> PoseArm:
    """Return the matrices of a model at a pose; ``hanging`` as in ``sag``."""
    return _arm_about(model, pose, sag(model, pose, hanging))


def _arm_about(model: FlexibleJointModel, pose: Array, rest: Array) -> PoseArm:
    matrices, inputs = model.dynamics.equations(pose, rest)
    return PoseArm(matrices.M, matrices.C, matrices.K, inputs.inertia, -inputs.gravity, rest)


def pose_system(
    model: FlexibleJointModel, pose: Array, channels: tuple[Channel, ...], hanging: bool = True
) -> PoseSystem:
    """Linearise a model at a pose; ``hanging`` as in ``sag``.

    Raises
    ------
    ModelError
        The pose or a channel does not fit the model.
    """
    rest = sag(model, pose, hanging)
    arm = _arm_about(model, pose, rest)
    try:
        squared, basis = scipy.linalg.eigh(arm.K, arm.M, check_finite=False)
    except np.linalg.LinAlgError as error:
        raise ModelError('mass matrix is not positive definite') from error
    if squared[0] <= 0.0:
        raise ModelError('stiffness matrix is not positive definite')
    fast = squared > FAST_1_S**2
    instant = (basis[:, fast] / squared[fast]) @ basis[:, fast].T
    kept = basis[:, ~fast]
    size = kept.shape[1]
    state = np.zeros((2 * size, 2 * size))
    state[:size, size:] = np.eye(size)
    state[size:, :size] = -np.diag(squared[~fast])
    state[size:, size:] = -(kept.T @ arm.C @ kept)
    poles, right = np.linalg.eig(state)
    left = np.linalg.inv(right)
    rows = _channel_rows(model, pose, channels, rest)
    return PoseSystem(
        arm=arm,
        poles=poles,
        shapes=kept @ right[:size],
        drives=left[:, size:] @ kept.T,
        instant=instant,
        **rows,
        dof_names=model.dof_names,
    )


def with_channels(
    system: PoseSystem,
    model: FlexibleJointModel,
    pose: Array,
    channels: tuple[Channel, ...],
    hanging: bool = True,
) -> PoseSystem:
    """Return a system with other channels."""
    rest = sag(model, pose, hanging)
    return dataclasses.replace(system, **_channel_rows(model, pose, channels, rest))  # type: ignore[arg-type]


def _channel_rows(
    model: FlexibleJointModel, pose: Array, channels: tuple[Channel, ...], rest: Array
) -> dict[str, Array]:
    motion, tilt = reading_rows(model.dynamics, pose, channels, rest)
    return {
        'flexible': motion[:, : model.n_dof],
        'rigid': motion[:, model.n_dof :],
        'gravity': tilt[:, : model.n_dof],
        'rigid_gravity': tilt[:, model.n_dof :],
    }
