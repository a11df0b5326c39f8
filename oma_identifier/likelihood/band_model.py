"""What the likelihood of a band is a function of: data, model, and what a fit found."""

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True, slots=True)
class KnownInputs:
    """What averages hold of inputs that are known.

    Parameters
    ----------
    cross : (n_lines, n_channels, n_inputs) complex array
        F uᴴ averaged as F Fᴴ is.
    power : (n_lines, n_inputs, n_inputs) complex array
        u uᴴ, too.
    middle_hz, reach_hz : float [Hz]
        Middle and half the width of the band.
    spread : (n_lines, n_channels, n_channels) complex array or None
        Covariance of what was fitted as the inputs' doing, which what is left lacks.
    """

    cross: Complex
    power: Complex
    middle_hz: float
    reach_hz: float
    spread: Complex | None = None


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
    spread_hz : (n_lines,) array [Hz]
        Standard deviation of the frequencies in each average.
    known : KnownInputs or None
        Of inputs that drive the modes.
    """

    frequency_hz: Real
    periodogram: Complex
    n_averaged: Real
    spread_hz: Real = field(default_factory=lambda: np.zeros(1))
    known: KnownInputs | None = None


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
    reference_hz : float [Hz]
        Frequency at which ``force`` holds.
    slope : float
        Elsewhere it holds times exp(slope x + curvature x²/2), x = ln(f / reference): white over
        a band is too much to ask for.
    curvature : float
        What the slope changes by over x: a wide band has no one slope.
    root : (n_modes, n_forces) complex array or None
        L of ``force`` = L Lᴴ where few forces drive the modes; None where they may be as many.
    """

    frequency_hz: Real
    damping_ratio: Real
    shapes: Complex
    force: Complex
    noise: Real
    n_free: int
    reference_hz: float
    slope: float = 0.0
    curvature: float = 0.0
    root: Complex | None = None


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


def accelerance(frequency_hz: Real, natural_hz: Real, damping_ratio: Real) -> Complex:
    """Return acceleration per modal force, 1 / (1 - β² - 2iζβ), β = f_n / f, lines × modes."""
    beta = natural_hz / frequency_hz[:, None]
    return np.asarray(1.0 / (1.0 - beta**2 - 2j * damping_ratio * beta))


def force_orders(data: BandData, model: BandModel) -> Real:
    """Return x and x²/2, x = ln(f / reference): by slope and curvature, (2, n_lines) array."""
    x = np.log(data.frequency_hz) - np.log(model.reference_hz)
    return np.stack([x, 0.5 * x**2])


def force_colour(data: BandData, model: BandModel) -> Real:
    """Return the root of the force's density over that at the reference, (n_lines,) array."""
    exponent = np.array([model.slope, model.curvature]) @ force_orders(data, model)
    return np.asarray(np.exp(0.5 * exponent))


def forced_gain(data: BandData, model: BandModel) -> Complex:
    """Return accelerances times the root of the force's slope, lines × modes."""
    gain = accelerance(data.frequency_hz, model.frequency_hz, model.damping_ratio)
    gain *= force_colour(data, model)[:, None]
    return gain


def expected_spectra(model: BandModel, amplitude: Complex) -> Complex:
    """Return the cross spectra A S Aᴴ + diag s that a model expects, (n_lines, n, n).

    Parameters
    ----------
    model : BandModel
        With forces S and noise s.
    amplitude : (n_lines, n_channels, n_modes) complex array
        A: shapes times gains.
    """
    covariance = amplitude @ model.force @ amplitude.conj().transpose(0, 2, 1)
    covariance += np.diag(model.noise)
    return np.asarray(covariance)


def with_root(model: BandModel, root: Complex) -> BandModel:
    """Return a model under the forces of a root."""
    return replace(model, root=root, force=np.asarray(root @ root.conj().T))


def without_negative(model: BandModel) -> BandModel:
    """Return a model whose forces have no power below zero.

    One band determines the forces of far tails badly: what it made of them may be no covariance
    beside the shapes of another pass.
    """
    power, directions = np.linalg.eigh(model.force)
    force = (directions * np.maximum(power, 0.0)) @ directions.conj().T
    return replace(model, force=np.asarray(force))
