"""Modal masses from a force that is known, of modes whose poles and shapes are.

With unit modal mass the acceleration that a force f at the point p makes at o is

    a_o(t) = Re Σ_r R_ro u_r(t) + D_o f(t),   u_r' = λ_r u_r + f,   R_ro = λ_r² ψ_ro ψ_rp/(j ω_dr)

(the conjugate pole makes the real part of it, twice).  u_r follows from force and pole.  A mode
whose largest entry is one, moved by ψ_p at the force, has the modal mass
m_r = λ_r² ψ_rp / (j ω_dr Q_r) with R_ro = Q_r ψ_ro.  For each mode the channels are summed along
its shape, and that sum is regressed on the u of all modes and on the force, line by line of the
spectrum.  What else shakes the structure is noise, and resonates as well: lines are weighted by
what a first fit leaves around them, which also tells the standard deviations.  Where the force has
lines, as those of teeth, its scale is that of the lines; what lies between them has one of its own
(:mod:`oma_identifier.known_force.lines_apart`).

References
----------
Reynders and De Roeck (2008), doi:10.1016/j.ymssp.2007.09.004; Brincker and Ventura (2015),
Introduction to Operational Modal Analysis, section 11.3.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
import math

import numpy as np
from numpy.typing import NDArray
from scipy.fft import fft, fftfreq, ifft, next_fast_len
from scipy.ndimage import uniform_filter1d

from modal_core.errors import IdentificationError
from modal_core.mode import Mode, ModeSet
from modal_core.samples import Samples
from oma_identifier.known_force.lines_apart import lines_apart

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]
LOWEST, HIGHEST = 0.5, 1.5
"""Of the lowest and of the highest natural frequency: lines between are fitted."""
SMOOTHED = 15
"""Lines whose mean is the power that is left around one."""
ROUNDS = 3
PAIR = np.array([1.0, 1.0j])
LEAST_ENTRY = 0.1
"""Entry of a shape at the force: entries were off by up to 0.08 on random chains."""
MOST_UNSURE = 0.5
"""Deviation over the mass, from where on the data do not tell it."""
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
        Where a channel measures at the force, along it, and the force moves the mode enough to
        tell; else NaN.
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
    rate = samples.sample_rate_hz
    # Lines come first: noise of the force's sensor is next to nothing beside them.
    parts, known = lines_apart(np.asarray(samples.known[:, [column]], dtype=float), rate)
    rows = samples.select(modes.channel_names).widened()[known]
    columns = [_columns(part, tuple(modes), rate)[known] for part in parts.T]
    hz = np.fft.rfftfreq(len(rows), 1.0 / rate)
    own = modes.frequency_hz
    kept = (hz > LOWEST * own.min()) & (hz < min(HIGHEST * own.max(), 0.45 * rate))
    taper = np.hanning(len(rows))[:, None]
    lines = np.fft.rfft(np.hstack(columns) * taper, axis=0)[kept]
    motion = np.fft.rfft((rows - rows.mean(axis=0)) * taper, axis=0)[kept]
    weight = 1.0 / np.maximum(rows.var(axis=0), 1e-300)
    index = modes.channel_names.index(point) if point else None

    def moved(number: int, pole_of: Mode) -> Complex:
        """Return the lines with one mode at another pole."""
        changed = lines.copy()
        for part, first in zip(parts.T, range(0, lines.shape[1], 2 * len(modes) + 1), strict=True):
            own = _columns(part, (pole_of,), rate)[known, :2]
            pair = slice(first + 2 * number, first + 2 * number + 2)
            changed[:, pair] = np.fft.rfft(own * taper, axis=0)[kept]
        return np.asarray(changed)

    return tuple(
        _scaled(_Seen(mode, number, lines, motion, weight, hz[kept], index), sign, moved)
        for number, mode in enumerate(modes)
    )


@dataclass(frozen=True, slots=True)
class _Seen:
    """What tells of one mode: lines of the states of all modes, and of the channels."""

    mode: Mode
    number: int
    lines: Complex
    motion: Complex
    weight: Real
    hz: Real
    point: int | None

    @property
    def pair(self) -> slice:
        """Columns of the mode."""
        return slice(2 * self.number, 2 * self.number + 2)

    @property
    def along(self) -> Complex:
        """Sum of the channels along the shape: of the mode alone, its largest entry's motion."""
        sums = self.weight * self.mode.shape.real
        return np.asarray(self.motion @ (sums / (sums @ self.mode.shape.real)))


def _scaled(seen: _Seen, sign: float, moved: Callable[[int, Mode], Complex]) -> ModalScaling:
    mode, along = seen.mode, seen.along
    value, covariance, rest = _regressed(seen.lines, along)
    to_scale = _to_scale(mode)
    scale = complex(value[seen.pair] @ PAIR) * to_scale
    std = _std(scale, to_scale, covariance[seen.pair, seen.pair])
    others = [
        _entry(moved(seen.number, other), along, seen.pair, other) for other in _beside(mode)
    ]
    by_pole = math.hypot(*(abs(other) - abs(scale) for other in others))
    near = np.abs(seen.hz - mode.frequency_hz) < max(
        mode.damping_ratio * mode.frequency_hz, 3.0 * (seen.hz[1] - seen.hz[0])
    )
    explained = 1.0 - np.sum(np.abs(rest[near]) ** 2) / np.sum(np.abs(along[near]) ** 2)
    mass, mass_std = _mass(seen, scale, std, others, sign)
    return ModalScaling(
        mode.frequency_hz, scale, math.hypot(std, by_pole), mass, mass_std, float(explained)
    )


def _mass(
    seen: _Seen, scale: complex, std: float, others: Sequence[complex], sign: float
) -> tuple[float, float]:
    """Return the modal mass and its deviation, NaN where nothing tells.

    The scale comes with its deviation, and with what it is at poles a deviation away.

    Two things tell the entry of the shape at the force: the shape, which comes without a deviation
    and is off most where it is small, and the motion there per force, ψ_p²/m, which the rest of
    other modes is in.  What they differ by counts as deviation.
    """
    if seen.point is None or abs(seen.mode.shape[seen.point]) < LEAST_ENTRY:
        return math.nan, math.nan
    entry = complex(seen.mode.shape[seen.point])
    mass = _mass_by(entry, scale, sign)
    there = _entry(seen.lines, seen.motion[:, seen.point], seen.pair, seen.mode) / scale
    mass_std = math.hypot(
        mass * std / abs(scale),
        *(_mass_by(entry, other, sign) - mass for other in others),
        _mass_by(there, scale, sign) - mass,
    )
    unsure = not mass_std < MOST_UNSURE * abs(mass)
    return (math.nan, math.nan) if unsure else (mass, mass_std)


def _mass_by(entry: complex, scale: complex, sign: float) -> float:
    """Return ψ_p over the scale ψ_p/m, which a late or early force turns."""
    return math.copysign(1.0, scale.real) * sign * float(np.real(entry)) / abs(scale)


def _entry(lines: Complex, seen: Complex, pair: slice, mode: Mode) -> complex:
    """Return the entry of a channel, or a sum of channels, per force [1/kg]."""
    return complex(_regressed(lines, seen)[0][pair] @ PAIR) * _to_scale(mode)


def _to_scale(mode: Mode) -> complex:
    """Return what makes ψ ψ_p / m of a residue: that is λ² ψ ψ_p / (jω_d m)."""
    pole, damped = _pole(mode)
    return 1j * damped / pole**2


def _std(value: complex, to_scale: complex, covariance: Real) -> float:
    """Return the deviation of the size of a value that two coefficients make."""
    slope = np.real(to_scale * PAIR * np.conj(value) / abs(value))
    return math.sqrt(float(slope @ covariance @ slope))


def _beside(mode: Mode) -> Iterator[Mode]:
    """Yield the mode a deviation of its frequency away, and one of its damping, where known."""
    for other in (
        replace(mode, frequency_hz=mode.frequency_hz + mode.frequency_std_hz),
        replace(mode, damping_ratio=mode.damping_ratio + mode.damping_ratio_std),
    ):
        if math.isfinite(other.frequency_hz) and math.isfinite(other.damping_ratio):
            yield other


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
