"""One record of a family with all that is true about it, and what it can tell at best."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from benchmarks.families.bound import bound, local_bound
from benchmarks.families.family import STEADY, WHITE
from benchmarks.identifier.plant import Plant
from benchmarks.identifier.scatter import law


@dataclass(frozen=True)
class Record:
    """Responses and the truth.

    Parameters
    ----------
    family, seed : str, int
        They determine the rest.
    plant : Plant
        Poles, complex shapes and participation; the mean where frequencies drift.
    acceleration : (n_samples, n_channels) array
        With noise.
    rate_hz : float [Hz]
    share : (n_modes,) array
        Variance of the response within three half-widths of a mode that is its own, over the
        variance of the response without noise, a mean over the channels.
    lines_hz : tuple of float [Hz]
    drift : float
        From least to greatest natural frequency over the mean.
    noise : float
        Over the standard deviation of the responses.
    noise_std : (n_channels,) array [m/s²]
    n_forces : int
    forces : str
        Kind of forces.
    gain : (n_modes,) array
        Of the spectrum of the forces at the modes.
    steady : float
        Share of the record in which steady forces would tell as much: (mean power)² over the mean
        of its square.
    """

    family: str
    seed: int
    plant: Plant
    acceleration: NDArray[np.float64]
    rate_hz: float
    share: NDArray[np.float64]
    lines_hz: tuple[float, ...]
    drift: float
    noise: float
    noise_std: NDArray[np.float64]
    n_forces: int
    forces: str
    gain: NDArray[np.float64]
    steady: float

    @property
    def duration_s(self) -> float:
        """Samples over rate [s]."""
        return len(self.acceleration) / self.rate_hz

    @property
    def steady_s(self) -> float:
        """Length of a record under steady forces that would tell as much [s]."""
        return self.steady * self.duration_s

    @cached_property
    def law(self) -> NDArray[np.float64]:
        """Least relative deviations of f and ζ were a mode alone (Au 2014), (2, n_modes)."""
        return law(self.plant, self.steady_s)

    @cached_property
    def bound(self) -> NDArray[np.float64] | None:
        """The Cramér-Rao bound of the same; None where its model is not that of the record."""
        if self.forces != f'{WHITE} {STEADY}' or self.lines_hz or self.drift:
            return None
        return bound(self.plant, self.noise_std, self.rate_hz, self.duration_s)

    @cached_property
    def deviation(self) -> NDArray[np.float64]:
        """The larger of law and bound, or of what the bound is at least, (2, n_modes)."""
        least = self.bound
        if least is None:
            forced = self.plant.participation * self.gain[:, None]
            plant = replace(self.plant, participation=forced)
            least = local_bound(plant, self.noise_std, self.rate_hz, self.steady_s)
        # A bound that rounding has eaten is none.
        return np.fmax(self.law, least)

    def __str__(self) -> str:
        """Describe it in one line."""
        n_samples, n_channels = self.acceleration.shape
        zeta = 100.0 * self.plant.damping_ratio
        return (
            f'{self.family} {self.seed}: {n_channels} channels, {self.rate_hz:.4g} Hz,'
            f' {n_samples / self.rate_hz:.4g} s, {len(zeta)} modes, ζ {zeta.min():.2g} to'
            f' {zeta.max():.2g} %, noise {self.noise:.2g}, {self.n_forces} forces {self.forces},'
            f' lines {np.round(self.lines_hz, 3).tolist()}, drift {self.drift:.2g}'
        )
