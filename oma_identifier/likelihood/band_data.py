"""From the spectra of all channels to the few numbers the likelihood of one band needs."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from oma_identifier.likelihood.band_model import accelerance, BandData, BandModel, SlopePrior
from oma_identifier.likelihood.indices import ModeIndex
from oma_identifier.likelihood.line_spectra import Spectra, VALUES_AT_ONCE
from oma_identifier.likelihood.noise_scale import noise_scale, unexplained_scale

HALF_WIDTHS = 8.0
"""Reach of a band on both sides of a mode, in half-power half-widths."""
LEAST_HALF_WIDTHS = 2.0
MOST_MODES = 4
"""Modes estimated jointly; a longer chain of overlapping bands is narrowed until it breaks."""
MOST_TAILS, MOST_REMAINDERS = 9, 4
"""Beside a group: of modes, and of what is left of them after projecting them out."""
LOWEST_SHARE = 0.3
"""A band does not reach below this share of its lowest natural frequency."""
LINES_PER_HALF_WIDTH = 4.0
LINES_PER_DISTANCE = 6.0
"""Averaging over the width of a peak/4 or its distance/6 loses no information on the peak."""
FEW_CHANNELS = 12
"""So few channels are not reduced: all modes are in the model."""
LEAST_TAIL, LEAST_PART = 0.3, 0.15
"""Least part of a shape beside the band that is projected out: times its tail over the noise, or
of unit length."""
LEAST_REMAINDER = 1.0
"""Of a tail over the noise: what is left of it after projecting out and goes into the model."""
PEAK_LINES = 9
STRONG = 2.0
"""Power over that of the noise, of a direction in which the band's own modes move."""
LEAST_VISIBLE = 0.3
"""Least length a unit shape keeps across the shapes of the other modes."""

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True, slots=True)
class StartModes:
    """Poles and shapes a refinement starts from.

    Parameters
    ----------
    frequency_hz, damping_ratio : (n_modes,) array [Hz], [-]
        Natural frequencies and damping ratios.
    shapes : (n_channels, n_modes) complex array
        Of unit length.
    """

    frequency_hz: Real
    damping_ratio: Real
    shapes: Complex

    def indices(self) -> Iterator[ModeIndex]:
        """Yield the position of each mode."""
        return map(ModeIndex, range(len(self.frequency_hz)))

    @property
    def half_width_hz(self) -> Real:
        """Half-power half-widths ζf [Hz]."""
        return self.frequency_hz * self.damping_ratio


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
    """

    data: BandData
    model: BandModel
    scale: Real
    basis: Real
    blocked: Real
    lines: NDArray[np.intp]
    included: tuple[ModeIndex, ...]

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


def overlaps(frequency_hz: Real, half_width_hz: Real) -> NDArray[np.bool_]:
    """Tell of each two modes whether their half-power bandwidths touch, (n_modes, n_modes)."""
    apart = np.abs(frequency_hz[:, None] - frequency_hz)
    return np.asarray(apart <= half_width_hz[:, None] + half_width_hz)


def group_modes(start: StartModes, reach: float = HALF_WIDTHS) -> list[list[ModeIndex]]:
    """Group modes whose bands overlap; narrow the bands of groups that are too large."""
    return _grouped(
        start, [ModeIndex(int(mode)) for mode in np.argsort(start.frequency_hz)], reach
    )


def _grouped(start: StartModes, modes: list[ModeIndex], reach: float) -> list[list[ModeIndex]]:
    low = start.frequency_hz - reach * start.half_width_hz
    high = start.frequency_hz + reach * start.half_width_hz
    groups: list[list[ModeIndex]] = []
    for mode in modes:
        if groups and low[mode] < max(high[other] for other in groups[-1]):
            groups[-1].append(mode)
        else:
            groups.append([mode])
    result: list[list[ModeIndex]] = []
    for group in groups:
        if len(group) > MOST_MODES and reach > LEAST_HALF_WIDTHS:
            result += _grouped(start, group, 0.8 * reach)
        else:
            result.append(group)
    return result


def band_lines(
    spectra: Spectra, start: StartModes, group: list[ModeIndex], usable: NDArray[np.bool_]
) -> NDArray[np.intp]:
    """Return the usable frequencies around a group of modes.

    Those beside the peaks that lie nearer to another mode, in half-widths, are left out: it does
    not move in the fit.
    """
    width = start.half_width_hz
    reach = HALF_WIDTHS * width[group]
    low = np.min(start.frequency_hz[group] - reach)
    low = max(low, LOWEST_SHARE * start.frequency_hz[group[0]])
    high = np.max(start.frequency_hz[group] + reach)
    frequency = spectra.frequency_hz
    lines = np.flatnonzero(usable & (frequency >= low) & (frequency <= high))
    away = np.abs(frequency[lines, None] - start.frequency_hz) / width
    own = away[:, group].min(axis=1)
    return np.asarray(lines[(own <= away.min(axis=1)) | (own < LEAST_HALF_WIDTHS)])


def reduce_band(
    spectra: Spectra,
    start: StartModes,
    group: list[ModeIndex],
    lines: NDArray[np.intp],
    slope: SlopePrior,
) -> ReducedBand:
    """Whiten, project and average one band.

    Channels are scaled to equal noise.  With more channels than modes, what other modes contribute
    is projected out; otherwise they become tails of the model.
    """
    n_lines, frequency = len(lines), spectra.frequency_hz[lines]
    products = (parts @ parts.T for _, parts in spectra.parts(lines))
    plain: Real = np.asarray(sum(products)) / n_lines
    many = len(plain) > FEW_CHANNELS
    scale = noise_scale(plain, n_lines) if many else unexplained_scale(plain)
    shapes = _unit(start.shapes * scale[:, None])
    others = [mode for mode in start.indices() if mode not in group]
    parted = None
    if others and many:
        parted = _parted(spectra, start, group, others, scale, frequency[[0, -1]])
    if parted is None:
        tails = _largest(spectra, start, group, others, MOST_TAILS)
        parted = _Parted(np.empty((len(scale), 0)), np.eye(len(scale)), tails)
    basis = free = parted.free
    covariance = free.T @ (plain * np.outer(scale, scale)) @ free
    kept = free.shape[1]
    if kept > FEW_CHANNELS:
        levels, directions = np.linalg.eigh(covariance)
        strong = int(np.count_nonzero(levels > STRONG * np.median(levels)))
        most = (1 + parted.planes) * len(group)
        kept = min(kept, max(len(group), min(strong, most)) + len(parted.tails) + 1)
        basis = free @ directions[:, ::-1][:, :kept]
    included = [*group, *parted.tails]
    reduced = spectra.combined(scale[:, None] * basis, lines).T
    n_noise = (free.shape[1] - kept) * n_lines
    rest = n_lines * np.trace(covariance) - np.sum(np.abs(reduced) ** 2)
    noise = float(rest / n_noise) if n_noise else 0.3
    within = [m for m in others if frequency[0] < start.frequency_hz[m] < frequency[-1]]
    data = averages_from(
        frequency,
        reduced,
        start.frequency_hz[[*group, *within]],
        start.half_width_hz[[*group, *within]],
        n_noise,
        noise,
        spectra.durations_s,
    )
    inside = basis.T @ shapes[:, included]
    force = _force_levels(spectra, start, included, scale, free @ free.T)
    model = BandModel(
        start.frequency_hz[included],
        start.damping_ratio[included],
        _unit(inside),
        np.diag(force).astype(complex),
        np.full(kept, noise),
        len(group),
        one_noise=False,
        reference_hz=float(np.exp(np.mean(np.log(start.frequency_hz[group])))),
        slope=slope.mean,
        slope_prior=slope,
    )
    return ReducedBand(data, model, scale, basis, parted.blocked, lines, tuple(included))


def _unit(shapes: Complex) -> Complex:
    return np.asarray(shapes / np.linalg.norm(shapes, axis=0))


@dataclass(frozen=True, slots=True)
class _Parted:
    """Orthonormal bases along and across the shapes of some modes; what a mode shows there.

    Parameters
    ----------
    blocked, free : (n_channels, n) array
        Along and across the shapes.
    tails : list of int
        Modes beside the band of which more than noise is left across.
    planes : bool
        Across, complex shapes are described as well: each in a plane, not along a line.
    """

    blocked: Real
    free: Real
    tails: list[ModeIndex]
    planes: bool = False


def _parted(
    spectra: Spectra,
    start: StartModes,
    group: list[ModeIndex],
    others: list[ModeIndex],
    scale: Real,
    ends_hz: Real,
) -> _Parted | None:
    """Return bases along and across the shapes of the others; None where that is not the way.

    The imaginary part of a shape is another direction.  It is projected out where it stands out
    of the noise, unless the modes of the group would not be seen any more: the imaginary parts
    of a structure with uneven damping lie along the shapes of its other modes.  What is left of
    them then is for the model.
    """
    shapes = _unit(start.shapes * scale[:, None])
    by_length = np.full(len(others), 1.0 / LEAST_PART)
    over_noise = _tails(spectra, start, others, scale, ends_hz)
    by_noise = np.maximum(over_noise / LEAST_TAIL, by_length)
    for planes, weight in ((True, by_noise), (False, by_length)):
        weighted = shapes[:, others] * weight
        blocked = np.concatenate([weighted.real, weighted.imag], axis=1)
        left, values, _ = np.linalg.svd(blocked, full_matrices=True)
        rank = int(np.count_nonzero(values > 1.0))
        free = left[:, rank:]
        if free.shape[1] >= len(group) + 2:
            visible = np.linalg.svd(free.T @ shapes[:, group], compute_uv=False)
            if visible[-1] > LEAST_VISIBLE:
                remainder = over_noise * np.linalg.norm(free.T @ shapes[:, others], axis=0)
                largest = np.argsort(-remainder)[:MOST_REMAINDERS]
                tails = [others[at] for at in largest if remainder[at] > LEAST_REMAINDER]
                return _Parted(left[:, :rank], free, tails, planes)
    return None


def _tails(
    spectra: Spectra, start: StartModes, modes: list[ModeIndex], scale: Real, ends_hz: Real
) -> Real:
    """Return the amplitudes of modes beside a band, at the end nearer to each, over the noise.

    From a few lines at the peak of each: their order of magnitude is enough.
    """
    frequency, damping = start.frequency_hz[modes], start.damping_ratio[modes]
    places = frequency + np.linspace(-1.0, 1.0, PEAK_LINES)[:, None] * damping * frequency
    lines = np.searchsorted(spectra.frequency_hz, places - 0.5 * spectra.spacing_hz)
    lines = np.clip(lines, 1, len(spectra.frequency_hz) - 1)
    near = spectra.values[:, lines]
    shapes = _unit(start.shapes[:, modes] * scale[:, None])
    response = np.einsum('cm,clm->lm', scale[:, None] * shapes.conj(), near)
    beta = frequency / spectra.frequency_hz[lines]
    level = np.mean(np.abs(response * (1.0 - beta**2 - 2j * damping * beta)) ** 2, axis=0)
    gain = np.abs(accelerance(ends_hz, frequency, damping)).max(axis=0)
    return np.asarray(np.sqrt(level) * gain)


def _largest(
    spectra: Spectra, start: StartModes, group: list[ModeIndex], others: list[ModeIndex], most: int
) -> list[ModeIndex]:
    """Return the modes that reach furthest into the band of a group."""
    if len(others) <= most:
        return others
    centre = start.frequency_hz[group].mean()
    level = _force_levels(spectra, start, others, np.ones(len(start.shapes)), None)
    frequency, damping = start.frequency_hz[others], start.damping_ratio[others]
    tail = level * np.abs(accelerance(np.array([centre]), frequency, damping)[0]) ** 2
    return [others[index] for index in np.sort(np.argsort(tail)[::-1][:most])]


def _force_levels(
    spectra: Spectra,
    start: StartModes,
    modes: list[ModeIndex],
    scale: Real,
    projector: Real | None,
) -> Real:
    """Return the force density that each mode's own peak suggests, for its projected shape."""
    levels = np.empty(len(modes))
    shapes = start.shapes * scale[:, None]
    shapes = _unit(shapes)
    if projector is not None:
        shapes = projector @ shapes
    for index, mode in enumerate(modes):
        width = max(start.half_width_hz[mode], 2.0 * spectra.spacing_hz)
        near = spectra.near(start.frequency_hz[mode], width)
        shape = shapes[:, mode]
        length = np.linalg.norm(shape)
        response = spectra.along(scale * shape.conj(), near) / length
        gain = accelerance(
            spectra.frequency_hz[near], start.frequency_hz[[mode]], start.damping_ratio[[mode]]
        )
        levels[index] = np.mean(np.abs(response[:, None] / gain) ** 2)
    return levels


def averages_from(
    frequency_hz: Real,
    values: Complex,
    centres_hz: Real,
    half_widths_hz: Real,
    n_noise: int = 0,
    noise: float = 1.0,
    durations_s: Sequence[float] = (0.0,),
) -> BandData:
    """Average the periodograms of a band, finely at its peaks and coarsely beside them.

    Parameters
    ----------
    frequency_hz : (n_lines,) array [Hz]
        Usable frequencies of the band.
    values : (n_lines, n_channels) complex array
        Discrete Fourier transforms there.
    centres_hz, half_widths_hz : (n_modes,) array [Hz]
        Peaks and their half-power half-widths.
    n_noise, noise : int, float
        Number and mean square of values that hold noise alone.
    durations_s : sequence of float [s]
        Of the stretches that the lines are of; only looked at where there are several.
    """
    apart = np.diff(frequency_hz)
    spacing = widest = float(apart.min())
    if len(durations_s) > 1:
        spacing, widest = 1.0 / sum(durations_s), 1.0 / min(durations_s)
    gaps = np.append(np.flatnonzero(apart > 1.5 * widest) + 1, len(frequency_hz))
    first = _first_of_averages(frequency_hz, gaps, spacing, centres_hz, half_widths_hz)
    count = np.diff(np.append(first, len(frequency_hz))).astype(float)
    periodogram = _summed_products(values, first) / count[:, None, None]
    mean_hz = np.add.reduceat(frequency_hz, first) / count
    return BandData(mean_hz, periodogram, count, float(n_noise), noise)


def _summed_products(values: Complex, first: NDArray[np.intp]) -> Complex:
    """Return the products of the channels with one another, summed from each first line on.

    Some averages at a time: a broad band has tens of thousands of lines.
    """
    n_lines, n_channels = values.shape
    at_once = max(1, VALUES_AT_ONCE // n_channels**2)
    summed = np.empty((len(first), n_channels, n_channels), dtype=complex)
    ends = np.append(first[1:], n_lines)
    begin = 0
    while begin < len(first):
        end = max(begin + 1, int(np.searchsorted(ends, first[begin] + at_once, side='right')))
        part = values[first[begin] : ends[end - 1]]
        products = part[:, :, None] * part[:, None, :].conj()
        summed[begin:end] = np.add.reduceat(products, first[begin:end] - first[begin], axis=0)
        begin = end
    return summed


def _first_of_averages(
    frequency_hz: Real,
    gaps: NDArray[np.intp],
    spacing: float,
    centres_hz: Real,
    half_widths_hz: Real,
) -> NDArray[np.intp]:
    """Return where each average starts: narrow at the peaks, wider away from them.

    None reaches over lines that are left out.
    """
    distance = np.abs(frequency_hz[:, None] - centres_hz)
    width = np.maximum(
        half_widths_hz / LINES_PER_HALF_WIDTH, (distance - half_widths_hz) / LINES_PER_DISTANCE
    ).min(axis=1)
    count = np.maximum(1, (width / spacing).astype(int))
    first, at = [], 0
    while at < len(frequency_hz):
        first.append(at)
        at = min(at + int(count[at]), int(gaps[np.searchsorted(gaps, at, side='right')]))
    return np.array(first)
