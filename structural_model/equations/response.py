"""Frequency response, state space and time response of M x'' + C x' + K x = f at one pose."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray
import scipy.linalg

from modal_core.errors import ModelError
from structural_model.equations.matrices import StructuralMatrices

Array = NDArray[np.float64]
Kind = Literal['receptance', 'mobility', 'accelerance']
Hold = Literal['linear', 'zero']
ORDER = {'receptance': 0, 'mobility': 1, 'accelerance': 2}


@dataclass(frozen=True)
class StateSpace:
    """x' = A x + B u, y = C x + D u with x = (deflections, their rates).

    Parameters
    ----------
    A, B, C, D : array
        The usual matrices.
    input_names, output_names : tuple of str
        Columns of B, rows of C.
    """

    A: Array
    B: Array
    C: Array
    D: Array
    input_names: tuple[str, ...]
    output_names: tuple[str, ...]


@dataclass(frozen=True)
class TimeResponse:
    """Response at a uniform rate.

    Parameters
    ----------
    output : (n_samples, n_outputs) array
        The outputs.
    state : (n_samples, n_states) array
        Deflections and their rates.
    """

    output: Array
    state: Array


def frequency_response(
    matrices: StructuralMatrices,
    inputs: Array,
    outputs: Array,
    frequency_hz: ArrayLike,
    kind: Kind = 'accelerance',
) -> NDArray[np.complex128]:
    """Return H(f) = (iω)^k · outputs · (K - ω²M + iωC)⁻¹ · inputs.

    Parameters
    ----------
    matrices : StructuralMatrices
        At one pose.
    inputs : (n_dof, n_inputs) array
        Force on the degrees of freedom per unit input.
    outputs : (n_outputs, n_dof) array
        Displacement of the outputs per unit deflection.
    frequency_hz : (n_frequencies,) array [Hz]
        Where.
    kind : {'receptance', 'mobility', 'accelerance'}
        k = 0, 1, 2.

    Returns
    -------
    (n_frequencies, n_outputs, n_inputs) complex array
    """
    if kind not in ORDER:
        raise ModelError('unknown kind of FRF', found=kind, expected=', '.join(ORDER))
    omega = 2.0 * np.pi * np.atleast_1d(np.asarray(frequency_hz, dtype=float))[:, None, None]
    dynamic = matrices.K - omega**2 * matrices.M + 1j * omega * matrices.C
    motion = np.linalg.solve(dynamic, np.broadcast_to(inputs, (len(omega), *inputs.shape)))
    return np.asarray((1j * omega) ** ORDER[kind] * (outputs @ motion))


def simulate(
    system: StateSpace,
    inputs: ArrayLike,
    sample_rate_hz: float,
    hold: Hold = 'linear',
    initial: ArrayLike | None = None,
) -> TimeResponse:
    """Return the exact response to inputs that are linear (or constant) between samples.

    Parameters
    ----------
    system : StateSpace
        At one pose.
    inputs : (n_samples, n_inputs) array
        At the sample instants.
    sample_rate_hz : float [Hz]
        Rate.
    hold : {'linear', 'zero'}
        Between samples.
    initial : (n_states,) array
        At the first sample; zero by default.

    References
    ----------
    Van Loan (1978), doi:10.1109/TAC.1978.1101743 (matrix exponential of the held system).
    """
    u = np.atleast_2d(np.asarray(inputs, dtype=float))
    if u.shape[1] != system.B.shape[1] or not np.isfinite(u).all():
        raise ModelError(
            'bad inputs', found=u.shape, expected=f'finite, (n_samples, {system.B.shape[1]})'
        )
    if not sample_rate_hz > 0.0:
        raise ModelError('sample rate is not positive', found=sample_rate_hz)
    if hold not in ('linear', 'zero'):
        raise ModelError('unknown hold', found=hold, expected='linear, zero')
    held = held_system(system.A, system.B, 1.0 / sample_rate_hz)
    step = np.diff(u, axis=0) if hold == 'linear' else np.zeros((len(u) - 1, u.shape[1]))
    drive = u[:-1] @ held.now.T + step @ held.change.T
    state = np.zeros((len(u), len(system.A)))
    if initial is not None:
        state[0] = initial
    for sample in range(len(u) - 1):
        state[sample + 1] = held.transition @ state[sample] + drive[sample]
    return TimeResponse(output=state @ system.C.T + u @ system.D.T, state=state)


@dataclass(frozen=True)
class HeldSystem:
    """x₊ = Φ x + Γ₀ u + Γ₁ (u₊ - u): one period with inputs linear between samples.

    Parameters
    ----------
    transition, now, change : array
        Φ, Γ₀, Γ₁.
    """

    transition: Array
    now: Array
    change: Array


def held_system(A: Array, B: Array, period_s: float) -> HeldSystem:
    """Return the exact one-period update of x' = A x + B u."""
    states, inputs = B.shape
    block = np.zeros((states + 2 * inputs, states + 2 * inputs))
    block[:states, :states] = A * period_s
    block[:states, states : states + inputs] = B * period_s
    block[states : states + inputs, states + inputs :] = np.eye(inputs)
    power = scipy.linalg.expm(block)
    return HeldSystem(
        transition=power[:states, :states],
        now=power[:states, states : states + inputs],
        change=power[:states, states + inputs :],
    )
