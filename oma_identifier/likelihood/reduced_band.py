"""From the spectra of all channels to the few numbers the likelihood of one band needs."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from oma_identifier.likelihood.averages import averages_from
from oma_identifier.likelihood.band_model import BandData, BandModel
from oma_identifier.likelihood.indices import ModeIndex
from oma_identifier.likelihood.known_motion import KnownMotion
from oma_identifier.likelihood.line_spectra import Spectra
from oma_identifier.likelihood.mode_groups import StartModes
from oma_identifier.likelihood.modes_beside import force_levels, split_channels, unit_columns
from oma_identifier.likelihood.noise_scale import noise_scale, unexplained_scale
from oma_identifier.likelihood.thresholds import LIKELIHOOD

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True, slots=True)
class ReducedBand:
    """One band in few coordinates.

    Parameters
    ----------
    data : BandData
        In the reduced coordinates.
    model : BandModel
        To start from; the free modes are those of the group.
    scale : (n_channels,) array
        That makes the noise of all channels equal.
    basis : (n_channels, n_reduced) array
        Orthonormal combinations of the scaled channels that were kept.
    blocked : (n_channels, n_blocked) array
        Orthonormal combinations that hold the shapes of other modes and were projected out.
    lines : (n_lines,) int array
        Frequencies of the spectra that the band is made of.
    included : tuple of ModeIndex
        Modes of the model.
    n_noise : int
        Number of further complex values that hold noise alone.
    noise_power : float
        Their mean squared magnitude.
    motion : KnownMotion or None
        What known inputs do, where they take part; the data are then what is left beside it.
    """

    data: BandData
    model: BandModel
    scale: Real
    basis: Real
    blocked: Real
    lines: NDArray[np.intp]
    included: tuple[ModeIndex, ...]
    n_noise: int
    noise_power: float
    motion: KnownMotion | None = None

    @property
    def project(self) -> Real:
        """Reduced value = projectᵀ · channel values, (n_channels, n_reduced) array."""
        return self.scale[:, None] * self.basis

    @property
    def back(self) -> Real:
        """A shape in channels = back · reduced shape, but for what was projected out."""
        return self.basis / self.scale[:, None]

    def projected_out(self, shape: Complex) -> Complex:
        """Return the part of a shape in channels along the shapes of the other modes."""
        return np.asarray(self.blocked @ (self.blocked.T @ (self.scale * shape)) / self.scale)

    @property
    def is_whole(self) -> bool:
        """Whether no combination of channels is left out."""
        return bool(self.back.shape[0] == self.back.shape[1])


def reduce_band(
    spectra: Spectra,
    start: StartModes,
    group: list[ModeIndex],
    lines: NDArray[np.intp],
    *,
    few_forces: bool = False,
) -> tuple[ReducedBand, Complex]:
    """Whiten, project and average one band; return it and its (n_lines, n_reduced) values.

    Channels are scaled to equal noise.  With more channels than modes, what other modes contribute
    is projected out; otherwise, or where few forces drive them all, they become tails
    of the model.
    """
    n_lines, frequency = len(lines), spectra.frequency_hz[lines]
    products = (parts @ parts.T for _, parts in spectra.parts(lines))
    plain: Real = np.asarray(sum(products)) / n_lines
    many = len(plain) > LIKELIHOOD.few_channels
    scale = noise_scale(plain, n_lines) if many else unexplained_scale(plain)
    shapes = unit_columns(start.shapes * scale[:, None])
    parted = split_channels(
        spectra, start, group, scale, frequency[[0, -1]], reduce=many, few_forces=few_forces
    )
    basis = free = parted.free
    covariance = free.T @ (plain * np.outer(scale, scale)) @ free
    kept = free.shape[1]
    if kept > LIKELIHOOD.few_channels:
        levels, directions = np.linalg.eigh(covariance)
        strong = int(np.count_nonzero(levels > LIKELIHOOD.strong * np.median(levels)))
        most = (1 + parted.planes) * len(group)
        kept = min(kept, max(len(group), min(strong, most)) + len(parted.tails) + 1)
        basis = free @ directions[:, ::-1][:, :kept]
    included = [*group, *parted.tails]
    reduced = spectra.combined(scale[:, None] * basis, lines).T
    n_noise = (free.shape[1] - kept) * n_lines
    rest = n_lines * np.trace(covariance) - np.sum(np.abs(reduced) ** 2)
    noise = float(rest / n_noise) if n_noise else 0.3
    others = [mode for mode in start.indices() if mode not in group]
    within = [m for m in others if frequency[0] < start.frequency_hz[m] < frequency[-1]]
    data = averages_from(
        frequency,
        reduced,
        start.frequency_hz[[*group, *within]],
        start.half_width_hz[[*group, *within]],
        spectra.durations_s,
    )
    inside = basis.T @ shapes[:, included]
    force = force_levels(spectra, start, included, scale, free @ free.T)
    model = BandModel(
        start.frequency_hz[included],
        start.damping_ratio[included],
        unit_columns(inside),
        np.diag(force).astype(complex),
        np.full(kept, noise),
        len(group),
        reference_hz=float(np.exp(np.mean(np.log(start.frequency_hz[group])))),
    )
    band = ReducedBand(
        data, model, scale, basis, parted.blocked, lines, tuple(included), n_noise, noise
    )
    return band, reduced
