"""The Whittle likelihood of a few modes in one frequency band, maximised by Fisher scoring.

The discrete Fourier transforms F_k of all channels at the frequencies of a band are independent
complex Gaussian vectors with covariance E_k = Φ H_k S H_kᴴ Φᴴ + diag s: mode shapes Φ,
accelerances H_k, the cross spectral density S of the modal forces (a power of frequency over this
band) and the noise s of each channel.
Modes beside the band take part with fixed poles and shapes, since their tails are coherent with
the forces of the band's own modes.

References
----------
Au (2017), Operational Modal Analysis, Springer, doi:10.1007/978-981-10-4118-1, chapters 10, 12;
Whittle (1953), Arkiv för Matematik 2, 423-434.
"""

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.lapack import dpotrf, dpotri

from oma_identifier.likelihood import shape_prior
from oma_identifier.likelihood.whittle_information import Evaluated, gradient, pairs
from oma_identifier.likelihood.whittle_information import information as fisher_information

CONVERGED_CHANGE = 0.01
"""Change of the log-likelihood at which no parameter moves by more than 0.14 of its deviation."""
NEARLY_UNDAMPED = 0.1
FIRST_DAMPING, LEAST_DAMPING, LARGEST_DAMPING = 1e-3, 1e-6, 1e6
NEARLY_SINGULAR = 1e-9
"""Share of a parameter's information that the others leave, from where on rounding matters."""
LEAST_POWER = 0.01
"""Of the noise, which forces of tails below zero must leave."""
NOISE_LOG_STD = 1.0
LEAST_LEVEL = 1e-6
"""Of the largest force, taken for the scale of another."""
ALIKE = 1.0
"""Distance of nearly equal poles, in half-power half-widths of both."""
LARGEST_LOG_STEP = (0.2, 0.7, 2.0)
"""Of frequency, damping ratio and noise."""

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True, slots=True)
class ConvergenceLimits:
    """When a fit is given up: it does not converge to a model that describes the data.

    Parameters
    ----------
    misfit : float
        A fit that is better than this is followed to its end.
    gain : float
        A worse one must come to this share of its misfit ...
    every : int
        ... in so many steps.
    """

    misfit: float
    gain: float
    every: int


FIRST_PASS, LATER_PASS = ConvergenceLimits(3.0, 0.8, 6), ConvergenceLimits(1.3, 0.93, 4)
"""Until the modes beside the band are refined too, and afterwards."""


@dataclass(frozen=True, slots=True)
class BandData:
    """Averaged periodograms of one band.

    Parameters
    ----------
    frequency_hz : (n_lines,) array [Hz]
        Mean frequency of each average.
    periodogram : (n_lines, n_channels, n_channels) complex array
        F Fᴴ averaged over neighbouring frequencies.
    n_averaged : (n_lines,) array
        Number of frequencies in each average.
    n_noise : float
        Number of further complex values that hold noise alone.
    noise_power : float
        Their mean squared magnitude.
    """

    frequency_hz: Real
    periodogram: Complex
    n_averaged: Real
    n_noise: float
    noise_power: float


@dataclass(frozen=True, slots=True)
class SlopePrior:
    """A Gaussian prior on the exponent of the force density over frequency."""

    mean: float = 0.0
    std: float = 1.0


@dataclass(frozen=True, slots=True)
class BandModel:
    """Modes of one band; the first ``n_free`` of them are estimated, the others are tails.

    Parameters
    ----------
    frequency_hz, damping_ratio : (n_modes,) array [Hz], [-]
        Natural frequencies and damping ratios.
    shapes : (n_channels, n_modes) complex array
        Of unit length.
    force : (n_modes, n_modes) complex array
        Cross spectral density of the modal forces, Hermitian.
    noise : (n_channels,) array
        Noise power of each channel.
    n_free : int
        Number of modes whose pole and shape are estimated.
    one_noise : bool
        All channels have the same noise.
    reference_hz : float [Hz]
        Frequency at which ``force`` holds.
    slope : float
        Elsewhere it holds times (f / reference)^slope: white over a band is too much to ask for.
    slope_prior : SlopePrior
        What is known about the slope from elsewhere.
    """

    frequency_hz: Real
    damping_ratio: Real
    shapes: Complex
    force: Complex
    noise: Real
    n_free: int
    one_noise: bool
    reference_hz: float
    slope: float = 0.0
    slope_prior: 'SlopePrior' = field(default_factory=lambda: SlopePrior())


@dataclass(frozen=True, slots=True)
class BandFit:
    """The maximum of the likelihood of one band.

    Parameters
    ----------
    model : BandModel
        At the maximum.
    frequency_std, damping_ratio_std : (n_free,) array
        Relative standard deviations from the Fisher information.
    shape_scatter : (n_free, n_channels, n_directions) complex array
        First-order errors of each shape along independent directions of one standard deviation,
        across the shape.
    slope_std : float
        Of the exponent of the force density.
    converged : bool
        A further step would be far below a standard deviation.
    n_steps : int
        Scoring steps taken.
    misfit : float
        Mean square of the whitened residual over what the model expects; 1 for a perfect model.
    value : float
        Negative logarithm of likelihood and priors.
    """

    model: BandModel
    frequency_std: Real
    damping_ratio_std: Real
    shape_scatter: Complex
    slope_std: float
    converged: bool
    n_steps: int
    misfit: float
    value: float


@dataclass(frozen=True, slots=True)
class Evaluation:
    """One model against the data: likelihood, L⁻¹ of E_k = L Lᴴ, H, ΦH and L⁻¹(P - E)L⁻ᴴ."""

    value: float
    whitening: Complex
    bare: Complex
    gain: Complex
    amplitude: Complex
    residual: Complex


@dataclass(frozen=True, slots=True)
class _Quadratic:
    """Fisher information and downhill gradient at one model, and the scale of each parameter.

    Directions across one shape have a common scale, so that it matters not which they are.
    """

    information: Real
    gradient: Real
    scale: Real


@dataclass(frozen=True, slots=True)
class Prior:
    """A weak Gaussian prior on the forces of tails and on the noise, where a band says nothing.

    Far tails look alike within one band, so that their forces are not determined by its data, nor
    is the noise of a channel that the modes drown.  The standard deviation of a force entry is the
    geometric mean of the two force levels; that of the logarithm of the noise is NOISE_LOG_STD.
    """

    force: Complex
    slope: float
    noise: Real
    weight: Real

    @classmethod
    def of(cls, start: BandModel) -> 'Prior':
        """Return the prior that is centred on a model."""
        # What a band made of the forces of far tails may be below zero: a scale must not be.
        level = np.abs(np.diag(start.force).real)
        level = np.maximum(level, LEAST_LEVEL * level.max())
        first, second = pairs(len(level))
        weight = np.where(second >= start.n_free, 1.0 / (level[first] * level[second]), 0.0)
        weight[first != second] *= 2.0
        n_noise = 1 if start.one_noise else len(start.noise)
        noise = np.full(n_noise, NOISE_LOG_STD**-2)
        slope = [start.slope_prior.std**-2]
        return cls(
            start.force,
            start.slope_prior.mean,
            start.noise[:n_noise],
            np.concatenate([weight, weight[first != second], slope, noise]),
        )

    def offset(self, model: BandModel) -> Real:
        """Return centre minus model, in the order of the last parameters."""
        difference = self.force - model.force
        first, second = pairs(len(difference))
        off = difference[first, second][first != second]
        noise = np.log(self.noise / model.noise[: len(self.noise)])
        slope = [self.slope - model.slope]
        return np.concatenate([difference[first, second].real, off.imag, slope, noise])

    def value(self, model: BandModel) -> float:
        """Return the negative logarithm of the prior."""
        return float(0.5 * np.sum(self.weight * self.offset(model) ** 2))


def accelerance(frequency_hz: Real, natural_hz: Real, damping_ratio: Real) -> Complex:
    """Return acceleration per modal force, 1 / (1 - β² - 2iζβ), β = f_n / f, lines × modes."""
    beta = natural_hz / frequency_hz[:, None]
    return np.asarray(1.0 / (1.0 - beta**2 - 2j * damping_ratio * beta))


def _log_frequency(data: BandData, model: BandModel) -> Real:
    return np.asarray(np.log(data.frequency_hz) - np.log(model.reference_hz))


def fit_band(
    data: BandData,
    start: BandModel,
    max_steps: int = 60,
    convergence: ConvergenceLimits = FIRST_PASS,
    near: BandModel | None = None,
) -> BandFit:
    """Maximise the likelihood from a start near the maximum.

    Levenberg-damped Fisher scoring: the information matrix needs no second derivative.

    Parameters
    ----------
    data : BandData
        Of one band.
    start : BandModel
        With shapes of unit length and a positive definite force; the prior is centred on it.
    max_steps : int
        Scoring steps, those rejected included.
    convergence : ConvergenceLimits
        When to give up.
    near : BandModel or None
        A better place to begin, on which the prior is not centred.
    """
    # Far from the maximum numbers may overflow; such a step is rejected, not reported.
    with np.errstate(over='ignore', invalid='ignore', divide='ignore'):
        prior = Prior.of(start)
        return _fit_band(data, near or start, prior, max_steps, convergence)


def _fit_band(
    data: BandData, start: BandModel, prior: Prior, max_steps: int, convergence: ConvergenceLimits
) -> BandFit:
    model, damping, n_steps, converged = start, FIRST_DAMPING, 0, False
    current = evaluate(data, model, prior)
    if current is None and np.isfinite(start.force).all():
        model = replace(start, force=_without_negative(start.force))
        current = evaluate(data, model, prior)
    if current is None:
        unknown = np.full(start.n_free, np.nan)
        none = np.full((start.n_free, len(start.shapes), 0), np.nan + 0j)
        return BandFit(start, unknown, unknown, none, np.nan, False, 0, np.inf, np.inf)
    quadratic = _quadratic(data, model, prior, current)
    misfit = np.inf
    while n_steps < max_steps and damping < LARGEST_DAMPING and not converged:
        n_steps += 1
        if n_steps % convergence.every == 0:
            before, misfit = misfit, _misfit(data, current)
            if misfit > convergence.misfit and misfit > convergence.gain * before:
                break
        candidate = moved(model, _step(quadratic, damping))
        trial = evaluate(data, candidate, prior)
        if trial is not None and damping < NEARLY_UNDAMPED:
            converged = abs(trial.value - current.value) < CONVERGED_CHANGE
        if trial is None or trial.value > current.value:
            damping *= 10.0
            continue
        damping = max(damping / 4.0, LEAST_DAMPING)
        model, current = candidate, trial
        if not converged:  # so close, the information is the same
            quadratic = _quadratic(data, model, prior, current)
    covariance = _covariance(quadratic.information)
    deviation = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    size = 2 * len(model.shapes)
    poles = deviation[: start.n_free * size].reshape(start.n_free, -1)
    slope_std = float(deviation[start.n_free * size + len(start.force) ** 2])
    scatter = _shape_scatter(covariance, model)
    misfit = _misfit(data, current)
    return BandFit(
        model,
        poles[:, 0],
        poles[:, 1],
        scatter,
        slope_std,
        converged,
        n_steps,
        misfit,
        current.value,
    )


def evaluate(data: BandData, model: BandModel, prior: Prior) -> Evaluation | None:
    """Return the likelihood of a model; None where it is no covariance."""
    # Written so that a parameter that is no number is refused as well.
    if not (np.all(model.damping_ratio > 1e-5) and np.all(model.damping_ratio < 0.9)):
        return None
    bare = accelerance(data.frequency_hz, model.frequency_hz, model.damping_ratio)
    gain = bare * np.exp(0.5 * model.slope * _log_frequency(data, model))[:, None]
    amplitude = model.shapes * gain[:, None, :]
    identity = np.eye(len(model.shapes))
    covariance = amplitude @ model.force @ amplitude.conj().transpose(0, 2, 1)
    covariance += np.diag(model.noise)
    if not np.isfinite(covariance).all():
        return None
    try:
        factor = np.linalg.cholesky(covariance)
        whitening = np.asarray(np.linalg.inv(factor))
    except np.linalg.LinAlgError:
        return None
    pivots = np.einsum('kii->ki', factor).real
    if np.any(pivots**2 < LEAST_POWER * model.noise):
        return None
    white: Complex = whitening @ data.periodogram @ whitening.conj().transpose(0, 2, 1)
    logarithm = 2.0 * np.sum(np.log(pivots), axis=1)
    value = np.sum(data.n_averaged * (logarithm + np.einsum('kii->k', white).real))
    if model.one_noise:
        power = model.noise[0]
        value += data.n_noise * (np.log(power) + data.noise_power / power)
    value += prior.value(model)
    value += shape_prior.penalty(model.shapes[:, : model.n_free])
    if not np.isfinite(value):
        return None
    return Evaluation(
        float(value),
        whitening,
        bare,
        gain,
        amplitude,
        np.asarray(white - identity),
    )


def _without_negative(force: Complex) -> Complex:
    """Return a force with no power below zero.

    One band determines the forces of far tails badly: what it made of them may be no covariance
    beside the shapes of another pass.
    """
    power, directions = np.linalg.eigh(force)
    return np.asarray((directions * np.maximum(power, 0.0)) @ directions.conj().T)


def _quadratic(data: BandData, model: BandModel, prior: Prior, at: Evaluation) -> _Quadratic:
    evaluated = evaluated_at(data, model, at)
    information = fisher_information(evaluated, model.one_noise)
    if model.one_noise:
        information[-1, -1] += data.n_noise
    weight = prior.weight
    last = np.arange(len(information) - len(weight), len(information))
    information[last, last] += weight
    size, free = 2 * len(model.shapes), model.shapes[:, : model.n_free]
    shapes = [slice(mode * size + 2, (mode + 1) * size) for mode in range(model.n_free)]
    for own, known in zip(shapes, shape_prior.information(free, evaluated.across), strict=True):
        information[own, own] += known
    scale = np.sqrt(np.diag(information))
    for own in shapes:
        scale[own] = np.linalg.norm(scale[own]) / max(1.0, np.sqrt(size - 2))
    return _Quadratic(information, downhill_gradient(data, model, prior, at, evaluated), scale)


def downhill_gradient(
    data: BandData,
    model: BandModel,
    prior: Prior,
    at: Evaluation,
    evaluated: Evaluated | None = None,
) -> Real:
    """Return the downhill gradient, priors included."""
    evaluated = evaluated or evaluated_at(data, model, at)
    downhill = gradient(evaluated, model.one_noise)
    if model.one_noise:
        downhill[-1] += data.n_noise * (data.noise_power / model.noise[0] - 1.0)
    pull = prior.weight * prior.offset(model)
    downhill[-len(pull) :] += pull
    modes = downhill[: model.n_free * 2 * len(model.shapes)].reshape(model.n_free, -1)
    modes[:, 2:] += shape_prior.gradient(model.shapes[:, : model.n_free], evaluated.across)
    return downhill


def evaluated_at(data: BandData, model: BandModel, at: Evaluation) -> Evaluated:
    """Return what the derivatives of the likelihood are made of."""
    free = slice(0, model.n_free)
    beta = model.frequency_hz[free] / data.frequency_hz[:, None]
    by_damping = at.bare[:, free] * 2j * model.damping_ratio[free] * beta
    back = at.whitening.conj().transpose(0, 2, 1)
    return Evaluated(
        count=data.n_averaged,
        amplitude=at.amplitude,
        response=at.amplitude @ model.force[:, free],
        precision=np.asarray(back @ at.whitening),
        residual=np.asarray(back @ at.residual @ at.whitening),
        excess=np.einsum('kii->k', at.residual).real,
        gain=at.gain[:, free],
        by_frequency=at.bare[:, free] * 2.0 * beta**2 + by_damping,
        by_damping=by_damping,
        log_frequency=_log_frequency(data, model),
        noise=model.noise,
        across=_across(model.shapes[:, free]),
    )


def _across(shapes: Complex) -> Complex:
    """Return orthonormal bases of the directions across shapes: Householder's reflections.

    Shapes are columns; the bases are (n_shapes, n_channels, n_channels - 1).
    """
    normal = shapes.T.copy()
    first = np.abs(normal[:, 0])
    length = np.linalg.norm(normal, axis=1)
    phase = np.divide(normal[:, 0], first, out=np.ones_like(normal[:, 0]), where=first > 0.0)
    normal[:, 0] += length * phase
    mirrored = (-2.0 / np.sum(np.abs(normal) ** 2, axis=1))[:, None] * normal[:, 1:].conj()
    basis = normal[:, :, None] * mirrored[:, None]
    basis[:, 1:] += np.eye(len(shapes) - 1)
    return np.asarray(basis)


def _step(quadratic: _Quadratic, damping: float) -> Real:
    scale = quadratic.scale
    scaled = quadratic.information / np.outer(scale, scale)
    scaled[np.diag_indices_from(scaled)] += damping
    try:
        return np.asarray(np.linalg.solve(scaled, quadratic.gradient / scale) / scale)
    except np.linalg.LinAlgError:
        return np.full(len(scale), np.nan)


def moved(model: BandModel, step: Real) -> BandModel:
    """Return the model after a step in the parameters of :func:`downhill_gradient`."""
    frequency, damping = model.frequency_hz.copy(), model.damping_ratio.copy()
    shapes = model.shapes.copy()
    length = np.ones(len(frequency))
    poles = step[: model.n_free * 2 * len(shapes)].reshape(model.n_free, -1)
    free = slice(0, model.n_free)
    frequency[free] *= np.exp(np.clip(poles[:, 0], -LARGEST_LOG_STEP[0], LARGEST_LOG_STEP[0]))
    damping[free] *= np.exp(np.clip(poles[:, 1], -LARGEST_LOG_STEP[1], LARGEST_LOG_STEP[1]))
    turned = _across(shapes[:, free]) @ (poles[:, 2::2] + 1j * poles[:, 3::2])[:, :, None]
    shapes[:, free] += turned[:, :, 0].T
    length[free] = np.linalg.norm(shapes[:, free], axis=0)
    end = poles.size + len(frequency) ** 2
    force = _mixed(model, shapes, _force_step(model.force, step[poles.size : end]))
    force *= np.outer(length, length)
    noise = model.noise * np.exp(
        np.clip(step[end + 1 :], -LARGEST_LOG_STEP[2], LARGEST_LOG_STEP[2])
    )
    return replace(
        model,
        frequency_hz=frequency,
        damping_ratio=damping,
        shapes=shapes / length,
        force=force,
        noise=noise,
        slope=model.slope + float(step[end]),
    )


def _force_step(force: Complex, step: Real) -> Complex:
    first, second = pairs(len(force))
    off = first != second
    change = np.zeros_like(force)
    change[first, second] = step[: len(first)]
    change[first[off], second[off]] += 1j * step[len(first) :]
    return np.asarray(change + np.triu(change, 1).conj().T)


def _mixed(model: BandModel, shapes: Complex, change: Complex) -> Complex:
    """Return the force after a change of it and of the shapes.

    Modes of nearly the same pole have no shapes of their own: with Φ T for Φ and T⁻¹ S T⁻ᴴ for S
    the spectra are the same.  Added to S as it is, a step would leave that curved valley.
    """
    pole = model.frequency_hz * (1j - model.damping_ratio)
    width = model.frequency_hz * model.damping_ratio
    alike = np.abs(pole[:, None] - pole) < ALIKE * (width[:, None] + width)
    mixing = np.zeros_like(force := model.force)
    for mode in np.flatnonzero(alike[: model.n_free].sum(axis=1) > 1):
        near = alike[mode]
        step = shapes[:, mode] - model.shapes[:, mode]
        mixing[near, mode] = np.linalg.lstsq(model.shapes[:, near], step, rcond=0.1)[0]
    if not mixing.any():
        return np.asarray(force + change)
    change = change + mixing @ force + force @ mixing.conj().T
    back = np.linalg.inv(np.eye(len(mixing)) + mixing)
    return np.asarray(back @ (force + change) @ back.conj().T)


def _covariance(information: Real) -> Real:
    """Return the covariance of the parameters; NaN where the information is no number."""
    scale = np.sqrt(np.diag(information))
    if not (np.isfinite(information).all() and np.all(scale > 0.0)):
        return np.full_like(information, np.nan)
    scaled = information / np.outer(scale, scale)
    factor, failed = dpotrf(scaled, lower=True)
    if failed or np.diag(factor).min() ** 2 < NEARLY_SINGULAR:
        covariance = np.linalg.pinv(scaled, rcond=1e-12, hermitian=True)
    else:
        lower = np.tril(dpotri(factor, lower=True)[0])
        covariance = lower + np.tril(lower, -1).T
    return np.asarray(covariance / np.outer(scale, scale))


def _shape_scatter(covariance: Real, model: BandModel) -> Complex:
    """Return the shapes' errors along the principal directions of their covariance."""
    n_channels = len(model.shapes)
    size = 2 * n_channels
    scatter = np.full((model.n_free, n_channels, size - 2), np.nan, dtype=complex)
    across = _across(model.shapes[:, : model.n_free])
    for mode in range(model.n_free):
        own = slice(mode * size + 2, (mode + 1) * size)
        block = covariance[own, own]
        if not np.isfinite(block).all():
            continue
        variance, directions = np.linalg.eigh(block)
        steps = directions * np.sqrt(np.maximum(variance, 0.0))
        scatter[mode] = across[mode] @ (steps[::2] + 1j * steps[1::2])
    return scatter


def _misfit(data: BandData, at: Evaluation) -> float:
    """Return Σ n |residual|² over its expectation; a white Wishart average has E = r²/n."""
    squares = np.sum(np.abs(at.residual) ** 2, axis=(1, 2))
    n_channels = at.residual.shape[1]
    return float(np.sum(data.n_averaged * squares) / (len(squares) * n_channels**2))
