"""The modes of the arm that a recording tells by itself, as the motion of its motors is known.

Identified from the responses alone, modes are those of arm, motors and servo drives together.  A
model whose motors move as recorded has those of the arm behind them, and only these compare.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray
import scipy.linalg
from scipy.optimize import least_squares, OptimizeResult

from modal_core.mode import Mode
from modal_core.numbers.indicators import mpc, mpd
from model_gap.campaign import Complex
from model_gap.modes.driven_response import DrivenResponse
from model_gap.modes.projection import LeftOver, numbers_of, poles_of, Projection
from model_gap.modes.thresholds import LIMITS

Array = NDArray[np.float64]
# Sum of the squared correlations of a Hann bin with its neighbours: 1 + 2 (4/9 + 1/36).
SHARED = 35.0 / 18.0
# Sum of the correlations: noise of what hardly changes from bin to bin, 1 + 2 (2/3 + 1/6).
ALIKE = 8.0 / 3.0
# Bins to either side whose noise is alike, and bins that a mode is looked for in.
AROUND, NEAR = 10, 5


def driven_modes(record: DrivenResponse, starts: Sequence[Complex]) -> list[Mode]:
    """Fit poles and shapes to the response to a known motion.

    y(ω) = D a + G s + Σₖ (Rₖ a + rₖ)/(iω - λₖ) + conjugates, where a and s are the motors'
    acceleration and shift, D the rigid arm and what rings above the band, G gravity, and rₖ what
    rings at the ends of the record.  All but the poles is linear and solved for at each step.

    Parameters
    ----------
    record : DrivenResponse
        Response and motion.
    starts : sequence of (n_poles,) complex array [rad/s]
        Where to begin, upper half planes: the poles of models.  The first of which each pole
        is told counts, else what explains most; modes that no start has are looked for where most
        is left over.

    Returns
    -------
    list of Mode
        Those that the record tells, in order of frequency, with standard deviations from what is
        left over.

    References
    ----------
    Golub and Pereyra (2003), Inverse Problems 19 R1, doi:10.1088/0266-5611/19/2/201; its Jacobian
    as Kaufman (1975), BIT 15, doi:10.1007/BF01932995.
    Pintelon and Schoukens (2012), System Identification: A Frequency Domain Approach, sec. 6.3.
    """
    highest = float(record.omega.max())
    problem = Projection(record)
    found: list[_Judged] = []
    for start in starts:
        poles = start[np.abs(start) < LIMITS.beyond * highest]
        if not 0 < problem.columns(len(poles)) < len(record.omega):
            continue
        found.append(_judged(problem, _fitted(problem, poles).x))
        if found[-1].is_once and found[-1].told[found[-1].omega < highest].all():
            break
    if not found:
        return []
    fit = min(found, key=lambda each: float(np.sum(problem.at(each.numbers).residual ** 2)))
    kept = fit
    for _ in range(LIMITS.most_tried):
        known = fit.once()
        more = np.append(poles_of(known)[0], _where_most_is_left(problem, known))
        fit = _judged(problem, _fitted(problem, more).x)
        if fit.is_once and (fit.told[-1] or not kept.is_once):
            kept = fit
        if fit.is_once and not fit.told[-1]:
            break
    if not kept.is_once:
        kept = _judged(problem, _fitted(problem, poles_of(kept.once())[0]).x)
    return _modes(problem, kept)


@dataclass(frozen=True)
class _Judged:
    """Poles with the deviations of their numbers, (2, n_poles), and which stand out of noise."""

    numbers: Array
    sigma: Array
    sure: NDArray[np.bool_]

    @property
    def omega(self) -> Array:
        """Natural frequencies [rad/s]."""
        return np.asarray(np.exp(self.numbers.reshape(2, -1)[0]))

    @property
    def told(self) -> NDArray[np.bool_]:
        """Which are modes: frequency known within the half-width, damping within itself."""
        ratio = np.exp(self.numbers.reshape(2, -1)[1])
        return np.asarray(self.sure & (self.sigma[0] < ratio) & (self.sigma[1] < 1.0))

    @property
    def is_once(self) -> bool:
        """Whether no mode may be another one once more."""
        return self._twice() is None

    def once(self) -> Array:
        """Return the numbers without the less certain pole of two that may be one mode."""
        twice = self._twice()
        if twice is None:
            return self.numbers
        return np.delete(self.numbers.reshape(2, -1), twice, axis=1).ravel()

    def _twice(self) -> int | None:
        poles = poles_of(self.numbers)[0]
        ratio = np.exp(self.numbers.reshape(2, -1)[1])
        sigma = np.abs(poles) * np.hypot(self.sigma[0], ratio * self.sigma[1])
        for one, other in combinations(np.flatnonzero(self.sure).tolist(), 2):
            if abs(poles[one] - poles[other]) < LIMITS.apart * np.hypot(sigma[one], sigma[other]):
                return int(one if sigma[one] > sigma[other] else other)
        return None


def _where_most_is_left(problem: Projection, numbers: Array) -> complex:
    """Return a pole where most is left over: a mode that no start has."""
    real, imaginary = np.split(_noise(problem.at(numbers)), 2)
    left = np.sum(real**2 + imaginary**2, axis=1)
    around = np.convolve(left, np.ones(NEAR), 'same')
    omega = float(problem.record.omega[int(np.argmax(around)), 1])
    return omega * complex(-LIMITS.added_damping, 1.0)


def _fitted(problem: Projection, start: Complex) -> OptimizeResult:
    begun = numbers_of(start)
    near = np.full(len(start), np.log(LIMITS.reach))
    low = np.concatenate(
        [begun[: len(start)] - near, np.full(len(start), np.log(LIMITS.least_damping))]
    )
    high = np.concatenate(
        [begun[: len(start)] + near, np.full(len(start), np.log(LIMITS.most_damping))]
    )
    return least_squares(
        lambda x: problem.at(x).reduced[0],
        np.clip(begun, low + 1e-6, high - 1e-6),
        lambda x: problem.at(x).reduced[1],
        bounds=(low, high),
        x_scale=0.1,
        ftol=1e-6,
        max_nfev=LIMITS.most_steps,
    )


def _judged(problem: Projection, numbers: Array) -> _Judged:
    """Return what poles are worth."""
    point = problem.at(numbers)
    noise = _noise(point)
    flat = point.jacobian.reshape(-1, len(numbers))
    prior = np.eye(len(numbers)) / LIMITS.most_off**2
    inverse = np.linalg.inv(flat.T @ flat + prior)
    spread = _score_spread(point, noise) + prior
    sigma = np.sqrt(np.diag(inverse @ spread @ inverse)).reshape(2, -1)
    omega = np.exp(numbers.reshape(2, -1)[0])
    sure = _stand_out(point, noise, np.searchsorted(problem.record.omega[:, 1], omega))
    return _Judged(numbers, sigma, sure)


def _modes(problem: Projection, fit: _Judged) -> list[Mode]:
    """Return the modes in order of frequency."""
    residues = problem.at(fit.numbers).residues
    omega, ratio = np.exp(fit.numbers.reshape(2, -1))
    order, modes = np.argsort(omega), []
    for number in order[fit.told[order]]:
        shape = np.linalg.svd((residues[number, :-1] * problem.size).T)[0][:, 0]
        shape = shape / shape[np.argmax(np.abs(shape))]
        frequency_hz = float(omega[number] / (2.0 * np.pi))
        modes.append(
            Mode(
                frequency_hz=frequency_hz,
                damping_ratio=float(ratio[number]),
                shape=shape,
                frequency_std_hz=frequency_hz * float(fit.sigma[0, number]),
                damping_ratio_std=float(ratio[number] * fit.sigma[1, number]),
                mpc=float(mpc(shape[:, None])[0]),
                mpd=float(mpd(shape[:, None])[0]),
                known_motion=True,
            )
        )
    return modes


def _noise(point: LeftOver) -> Array:
    """Return what is left over as it was before so much of it was fitted, as the residual."""
    left = 1.0 - SHARED * np.sum(point.basis**2, axis=1)
    return np.asarray(point.residual / np.sqrt(np.maximum(left, 0.1))[:, None])


def _stand_out(point: LeftOver, noise: Array, bins: NDArray[np.intp]) -> NDArray[np.bool_]:
    """Return which poles explain more than noise around their bins would, (n_poles,).

    Without a pole's columns squares grow by x'S⁻¹x, S the covariance of unit noise.
    """
    n_bins, n_poles = len(noise) // 2, len(bins)
    power = (noise[:n_bins] ** 2 + noise[n_bins:] ** 2) / 2.0
    covariance = scipy.linalg.solve_triangular(point.triangle, np.eye(len(point.triangle)))
    covariance = covariance @ covariance.T
    width = 2 * point.residues.shape[1]
    first = len(point.solved) - n_poles * width
    found = []
    for number, centre in enumerate(bins):
        own = slice(first + number * width, first + (number + 1) * width)
        if not 0 < centre < n_bins:
            found.append(False)
            continue
        around = power[max(0, centre - AROUND) : centre + AROUND + 1]
        more = point.solved[own] * np.linalg.solve(covariance[own, own], point.solved[own])
        excess = float(np.sum(more.sum(axis=0) / around.mean(axis=0))) / ALIKE - more.size
        found.append(excess > LIMITS.stands_out * np.sqrt(2.0 * more.size))
    return np.array(found)


def _score_spread(point: LeftOver, noise: Array) -> Array:
    """Return the covariance of the slopes of half the squares, (n_numbers, n_numbers).

    The noise of a bin, as channels share it, is the mean over bins around; Hann bins next to each
    other share noise too.
    """
    noises, parts = np.split(noise, 2), np.split(point.jacobian, 2)
    total = np.zeros((point.jacobian.shape[2],) * 2)
    for shift in range(-AROUND, AROUND + 1):
        slopes = sum(
            np.einsum('bc,bcn->bn', np.roll(own, shift, axis=0), part)
            for own, part in zip(noises, parts, strict=True)
        )
        total += slopes.T @ slopes
        for lag in (1, 2):
            both = slopes[lag:].T @ slopes[:-lag]
            total += both + both.T
    return np.asarray(total / (2 * AROUND + 1))
