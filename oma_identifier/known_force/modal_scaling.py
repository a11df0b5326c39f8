"""Modal masses from a force that is known, of modes whose poles and shapes are.

With unit modal mass the acceleration that a force f at the point p makes at o is

    a_o(t) = Re Σ_r R_ro u_r(t) + D_o f(t),   u_r' = λ_r u_r + f,   R_ro = λ_r² ψ_ro ψ_rp/(j ω_dr)

(the conjugate pole makes the real part of it, twice).  u_r follows from force and pole.  A mode
whose largest entry is one, moved by ψ_p at the force, has the modal mass
m_r = λ_r² ψ_rp / (j ω_dr Q_r) with R_ro = Q_r ψ_ro.  For each mode the channels are summed along
its shape, and that sum is regressed on the u of all modes and on the force, line by line of the
spectrum.  What else shakes the structure is noise, and resonates as well: lines are weighted by
what a first fit leaves around them, which also tells the standard deviations.

References
----------
Reynders and De Roeck (2008), doi:10.1016/j.ymssp.2007.09.004; Brincker and Ventura (2015),
Introduction to Operational Modal Analysis, section 11.3.
"""

from collections.abc import Sequence
from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import NDArray
from scipy.fft import fft, fftfreq, ifft, next_fast_len
from scipy.ndimage import uniform_filter1d

from modal_core.errors import IdentificationError
from modal_core.mode import Mode, ModeSet
from modal_core.samples import Samples

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]
LOWEST, HIGHEST = 0.5, 1.5
"""Of the lowest and of the highest natural frequency: lines between are fitted."""
SMOOTHED = 15
"""Lines whose mean is the power that is left around one."""
ROUNDS = 3
HANN_BANDWIDTH = 35.0 / 18.0
"""Sum of the squares of the correlation of lines of a Hann window: lines that are one."""


@dataclass(frozen=True, slots=True)
class ModalScaling:
    """How much a force moves a mode.

    Parameters
    ----------
    frequency_hz : float [Hz]
        Of the mode.
    per_force, per_force_std : complex, float [1/kg]
        Entry of the shape at the force over the modal mass, with the largest entry of the shape
        one; the deviation is that of its size.
    modal_mass_kg, modal_mass_std_kg : float [kg]
        Where a channel measures at the force, along it; else NaN.
    explained : float
        Share of the mode's response in the fit that the force explains, in the channel that moves
        most.
    """

    frequency_hz: float
    per_force: complex
    per_force_std: float
    modal_mass_kg: float
    modal_mass_std_kg: float
    explained: float


def modal_scaling(
    samples: Samples, modes: ModeSet, driving_point: str | None = None, column: int = 0
) -> tuple[ModalScaling, ...]:
    """Return the scale of each mode.

    Parameters
    ----------
    samples : Samples
        Accelerations, the force as known input.
    modes : ModeSet
        Of these samples.
    driving_point : str or None
        The channel at the force, along it; ``-`` before it where the force acts against it.
    column : int
        Which of the known inputs.

    Raises
    ------
    IdentificationError
        There is no force, or no such channel.
    """
    if samples.known is None or not np.isfinite(samples.known).all():
        raise IdentificationError(
            'modal masses need a measured force', found='none', expected='a channel in N'
        )
    sign = -1.0 if (driving_point or '').startswith('-') else 1.0
    point = (driving_point or '').removeprefix('-')
    if point and point not in modes.channel_names:
        raise IdentificationError(
            'no such channel', where='driving point', found=point,
            expected=', '.join(modes.channel_names),
        )  # fmt: skip
    if not len(modes):
        return ()
    rows = samples.select(modes.channel_names).widened()
    force = np.asarray(samples.known[:, column], dtype=float)
    rate = samples.sample_rate_hz
    columns = _columns(force - force.mean(), tuple(modes), rate)
    hz = np.fft.rfftfreq(len(rows), 1.0 / rate)
    own = modes.frequency_hz
    kept = (hz > LOWEST * own.min()) & (hz < min(HIGHEST * own.max(), 0.45 * rate))
    taper = np.hanning(len(rows))[:, None]
    lines = np.fft.rfft(columns * taper, axis=0)[kept]
    motion = np.fft.rfft((rows - rows.mean(axis=0)) * taper, axis=0)[kept]
    weight = 1.0 / np.maximum(rows.var(axis=0), 1e-300)
    index = modes.channel_names.index(point) if point else None
    return tuple(
        _scaled(mode, number, lines, motion, weight, hz[kept], index, sign)
        for number, mode in enumerate(modes)
    )


def _scaled(
    mode: Mode,
    number: int,
    lines: Complex,
    motion: Complex,
    weight: Real,
    hz: Real,
    point: int | None,
    sign: float,
) -> ModalScaling:
    along = weight * mode.shape.real
    along = along / (along @ mode.shape.real)
    seen = motion @ along
    value, covariance, rest = _regressed(lines, seen)
    pole, damped = _pole(mode)
    # Q is λ²ψ_p / (jω_d m), and both parts of it are as sure as these.
    to_scale = 1j * damped / pole**2 / complex(along @ mode.shape)
    pair = slice(2 * number, 2 * number + 2)
    scale = complex(value[pair] @ np.array([1.0, 1.0j])) * to_scale
    parts = np.array([to_scale, 1j * to_scale])
    slope = np.real(parts * np.conj(scale) / abs(scale))
    std = math.sqrt(float(slope @ covariance[pair, pair] @ slope))
    near = np.abs(hz - mode.frequency_hz) < max(
        mode.damping_ratio * mode.frequency_hz, 3.0 * (hz[1] - hz[0])
    )
    explained = 1.0 - np.sum(np.abs(rest[near]) ** 2) / np.sum(np.abs(seen[near]) ** 2)
    mass = mass_std = math.nan
    if point is not None:
        mass = float(np.real(sign * mode.shape[point] / scale))
        mass_std = abs(mass) * std / abs(scale)
    return ModalScaling(mode.frequency_hz, scale, std, mass, mass_std, float(explained))


def _regressed(lines: Complex, seen: Complex) -> tuple[Real, Real, Complex]:
    """Return coefficients, their covariance, and what is left, (n_lines,)."""
    power = np.ones(len(seen))
    for _ in range(ROUNDS):
        weighted = lines / np.sqrt(power)[:, None]
        gram = np.real(weighted.conj().T @ weighted)
        onto = np.real(weighted.conj().T @ (seen / np.sqrt(power)))
        value = np.linalg.solve(gram, onto)
        rest = seen - lines @ value
        power = np.maximum(uniform_filter1d(np.abs(rest) ** 2, SMOOTHED), 1e-300)
    # Hann's window lets every line share its noise with its neighbours; the power of a real and
    # an imaginary part is half of this each.
    covariance = 0.5 * HANN_BANDWIDTH * np.linalg.inv(gram)
    return np.asarray(value, float), np.asarray(covariance, float), rest


def _pole(mode: Mode) -> tuple[complex, float]:
    omega = 2.0 * math.pi * mode.frequency_hz
    damped = omega * math.sqrt(1.0 - mode.damping_ratio**2)
    return complex(-mode.damping_ratio * omega, damped), damped


def _columns(force: Real, modes: Sequence[Mode], rate_hz: float) -> Real:
    """Return Re u, -Im u of every mode, then the force, (n_samples, 2 n_modes + 1)."""
    # As long again of silence, in which what rings at the end of the record dies away.
    length = next_fast_len(2 * len(force))
    spectrum, omega = fft(force, length), 2.0 * np.pi * fftfreq(length, 1.0 / rate_hz)
    found = []
    for mode in modes:
        state = ifft(spectrum / (1j * omega - _pole(mode)[0]))[: len(force)]
        found += [state.real, -state.imag]
    return np.column_stack([*found, force])
