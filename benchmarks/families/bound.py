"""The Cramér-Rao bound of frequencies and damping ratios, every other parameter unknown too.

The responses are Gaussian with the spectrum

    S(ω) = ω⁴ Σₖ (ψₖ gₖᵀ / (iω - sₖ) + conjugate pole) + Hermitian transpose + N,

of which poles, shapes ψ, the covariances g between modes and responses, and the noise N of each
channel are unknown; nothing is said of the forces but that they are white.  Fisher's information
of a record of length T is (Whittle 1953) T ∫ tr(S⁻¹ ∂S S⁻¹ ∂S) df.  It holds where a record is
longer than the memory of its modes, ζ f T above about 2.

References
----------
Whittle (1953), Arkiv för Matematik 2, doi:10.1007/BF02590998; Au (2014),
doi:10.1016/j.ymssp.2014.03.002.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.families.response import poles
from benchmarks.identifier.plant import Plant

MOST_PARAMETERS = 450
"""Above, it takes longer than the identification."""
NEIGHBOURS, MOST_DIRECTIONS = 2, 3
"""Modes, itself among them, and combinations of channels, with which a mode is looked at."""
AT_ONCE, ROUNDING = 50, 1e-12

Complex = NDArray[np.complexfloating[Any, Any]]
Real = NDArray[np.float64]


def bound(
    plant: Plant, noise: Real, rate_hz: float, duration_s: float, edge: float = 0.42
) -> Real | None:
    """Return the least deviations of f and ζ over their values, (2, n_modes).

    Parameters
    ----------
    plant : Plant
        Complex form; each force is white with variance 1 a sample.
    noise : (n_channels,) array
        Standard deviation of the white noise.
    rate_hz, duration_s : float [Hz], [s]
        Of the record.
    edge : float
        End of the band as a share of the rate.

    Returns
    -------
    None where there are too many parameters.
    """
    n_channels, n_modes = plant.shapes.shape
    if n_modes * (2 + 4 * n_channels) + n_channels > MOST_PARAMETERS:
        return None
    hz = _grid(plant, rate_hz, duration_s, edge)
    weight = np.sqrt(np.gradient(hz) * duration_s)
    partner = _partners(plant) / rate_hz
    n_parameters = n_modes * (2 + 4 * n_channels) + n_channels
    information = np.zeros((n_parameters, n_parameters))
    for first in range(0, len(hz), AT_ONCE):
        part = slice(first, first + AT_ONCE)
        slopes = _slopes(plant, partner, noise**2 / rate_hz, 2.0 * np.pi * hz[part])
        rows = (slopes * weight[part, None, None]).transpose(0, 2, 1).reshape(-1, n_parameters)
        information += rows.T @ rows
    return _relative(plant, _covariance(information, 2 * n_modes))


def local_bound(plant: Plant, noise: Real, rate_hz: float, duration_s: float) -> Real:
    """Return what the bound is at least, (2, n_modes), for any number of modes and channels.

    Each mode is looked at with its nearest one, the others being known, in the combinations of
    channels in which these stand out most from the noise.
    """
    hz, width = plant.frequency_hz, plant.damping_ratio * plant.frequency_hz
    away = np.abs(hz[:, None] - hz) / (width[:, None] + width)
    found = np.empty((2, len(hz)))
    for mode, row in enumerate(away):
        near = np.argsort(row)[:NEIGHBOURS]
        part = _directions(plant, near, noise)
        least = bound(part, np.ones(len(part.shapes)), rate_hz, duration_s)
        assert least is not None
        found[:, mode] = least[:, 0]
    return found


def _directions(plant: Plant, modes: NDArray[np.intp], noise: Real) -> Plant:
    """Return some modes in the combinations of channels that show them best over unit noise."""
    shapes = plant.shapes[:, modes] / noise[:, None]
    strength = np.linalg.norm(plant.participation[modes], axis=1)
    both = np.concatenate([shapes.real * strength, shapes.imag * strength], axis=1)
    base = np.linalg.svd(both, full_matrices=False)[0][:, :MOST_DIRECTIONS]
    return Plant(
        plant.frequency_hz[modes],
        plant.damping_ratio[modes],
        base.T @ shapes,
        plant.participation[modes],
    )


def _grid(plant: Plant, rate_hz: float, duration_s: float, edge: float) -> Real:
    """Return frequencies that are dense where modes are, (n,) [Hz]."""
    hz, width = plant.frequency_hz, plant.damping_ratio * plant.frequency_hz
    around = np.sinh(np.linspace(-6.0, 6.0, 61)) / 4.0
    points = np.concatenate(
        [
            np.linspace(1.0 / duration_s, edge * rate_hz, 100),
            (hz[:, None] + width[:, None] * around).ravel(),
        ]
    )
    return np.unique(points[(points >= 1.0 / duration_s) & (points <= edge * rate_hz)])


def _partners(plant: Plant) -> Complex:
    """Return g = E[y x] of x' = s x + l u for white u of density 1, (n_channels, n_modes)."""
    s, force, shapes = poles(plant), plant.participation, plant.shapes
    with_conjugate = -(force @ force.conj().T) / (s[:, None] + s.conj())
    with_itself = -(force @ force.T) / (s[:, None] + s)
    return np.asarray((with_conjugate @ shapes.conj().T + with_itself @ shapes.T).T)


def _slopes(plant: Plant, partner: Complex, noise: Real, omega: Real) -> Real:
    """Return the whitened slopes of S over its parameters, (n_frequencies, n_parameters, n)."""
    n_channels = len(plant.shapes)
    one = np.eye(n_channels)
    spectrum = _times(np.ones_like(omega), 0.5 * np.diag(noise) + 0j)
    of_poles: list[Complex] = []
    of_vectors: list[Complex] = []
    for s, shape, g in zip(poles(plant), plant.shapes.T, partner.T, strict=True):
        near = omega**4 / (1j * omega - s)
        far = omega**4 / (1j * omega - np.conj(s))
        own, image = np.outer(shape, g), np.outer(shape, g).conj()
        spectrum = spectrum + _times(near, own) + _times(far, image)
        of_poles += _real_and_imaginary(
            _times(near / (1j * omega - s), own), _times(far / (1j * omega - np.conj(s)), image)
        )
        for unit in one:
            for first, second in ((unit, g), (shape, unit)):
                pair = np.outer(first, second)
                of_vectors += _real_and_imaginary(_times(near, pair), _times(far, pair.conj()))
    of_noise = [_times(np.ones_like(omega), 0.5 * np.diag(unit) + 0j) for unit in one]
    slopes = np.stack([*of_poles, *of_vectors, *of_noise], axis=1)
    spectrum = spectrum + _adjoint(spectrum)
    # Where one force shakes, all channels are one but for the noise: 120 dB of it are kept.
    spectrum += _times(ROUNDING * np.trace(spectrum, axis1=1, axis2=2), np.eye(n_channels) + 0j)
    white = np.linalg.inv(np.linalg.cholesky(spectrum))[:, None]
    slopes = white @ (slopes + _adjoint(slopes)) @ _adjoint(white)
    flat = slopes.reshape(len(omega), slopes.shape[1], -1)
    return np.concatenate([flat.real, flat.imag], axis=2)


def _times(factor: Complex | Real, matrix: Complex) -> Complex:
    return np.asarray(factor[:, None, None] * matrix)


def _adjoint(matrices: Complex) -> Complex:
    return np.asarray(np.swapaxes(matrices, -1, -2).conj())


def _real_and_imaginary(near: Complex, far: Complex) -> list[Complex]:
    """Return the slopes over both parts of a parameter that the far pole has conjugate."""
    return [near + far, 1j * (near - far)]


def _covariance(information: Real, n_free: int) -> Real:
    """Invert but for the scales of shapes, a complex one a mode, which are free."""
    scale = 1.0 / np.sqrt(np.diag(information))
    values, vectors = np.linalg.eigh(information * np.outer(scale, scale))
    vectors = scale[:, None] * vectors[:, n_free:]
    return np.asarray((vectors / values[n_free:]) @ vectors.T)


def _relative(plant: Plant, covariance: Real) -> Real:
    """Return deviations of f and ζ over their values, from those of the poles."""
    found = np.empty((2, len(plant.frequency_hz)))
    for mode, (s, zeta) in enumerate(zip(poles(plant), plant.damping_ratio, strict=True)):
        own = covariance[2 * mode : 2 * mode + 2, 2 * mode : 2 * mode + 2]
        along = np.array([s.real, s.imag]) / abs(s) ** 2
        across = np.array([-(s.imag**2), s.real * s.imag]) / abs(s) ** 3 / zeta
        found[:, mode] = np.sqrt([along @ own @ along, across @ own @ across])
    return found
