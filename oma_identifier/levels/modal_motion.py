"""How a mode moves in a record: its displacement within a band, and moments of that.

Under a white force k₁ E[q²] + k₃ E[q⁴] = E[q̇²] holds exactly for a mode with cubic stiffness,
whatever its damping (the equation of motion times q, on average): the second spectral moment over
the zeroth is the stiffness, and needs no linear fit of a peak that the level bends.
What a coloured force does to moments and widths is taken out of them, not of the motion: a filter
that does so is about a fixed frequency, and weights the moments when the mode is at another one.
"""

from collections.abc import Sequence
from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import NDArray

from oma_identifier.levels.amplitude import amplitude_half_width
from oma_identifier.levels.colour import Colour, common_colour
from oma_identifier.levels.envelope import Peak, peak
from oma_identifier.levels.narrow_band import mode_in_record, ModeInRecord, ModeRecord, Narrow
from oma_identifier.levels.thresholds import LEVELS

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True, slots=True)
class ModalMotion:
    """Motion of a mode at one channel over a record.

    Parameters
    ----------
    displacement_m, velocity_m_s : float [m], [m/s]
        Root mean squares.
    square_m2, square_m2_s2 : float [m²], [m²/s²]
        Fourth over second moment of displacement and of velocity: three times the mean square
        where the motion is Gaussian.
    relative_std : float
        Standard deviation of the root mean squares over their values.
    stiffness, stiffness_std : float [1/s²]
        Mean square of velocity over that of displacement.
    colour_std : float
        Of the stiffness, relative and alike at all levels, for what is not known of the force's
        colour.
    envelopes : tuple of complex arrays [m]
        Displacement about the mode's frequency, of each part of the record.
    rate_hz, carrier_hz : float [Hz]
        Of the envelopes, and the frequency they are about.
    noise_share : float
        Of the power in the band that is no peak, 0 to 1.
    cut_share : float
        Of the mode's power that is beyond the band of the envelopes, over what is within.
    moves_over_others : (float, float)
        Mean squares of displacement and of velocity, in all channels, over those of all other
        modes of the record; infinite where there are none.
    frequency_hz, frequency_std_hz : float [Hz]
        As identified; NaN: not known.
    damping_ratio, damping_ratio_std : float
        As identified; the latter NaN: not known.
    colour : float
        Power of frequency that the force goes with.
    """

    displacement_m: float
    velocity_m_s: float
    square_m2: float
    square_m2_s2: float
    relative_std: float
    stiffness: float
    stiffness_std: float
    colour_std: float
    envelopes: tuple[Complex, ...]
    rate_hz: float
    carrier_hz: float
    noise_share: float
    cut_share: float = 0.0
    moves_over_others: tuple[float, float] = (math.inf, math.inf)
    frequency_hz: float = math.nan
    frequency_std_hz: float = math.nan
    damping_ratio: float = math.nan
    damping_ratio_std: float = math.nan
    colour: float = 0.0

    @property
    def duration_s(self) -> float:
        """Length of the envelopes together [s]."""
        return sum(map(len, self.envelopes)) / self.rate_hz

    def share_beyond(self, gaps_m: Real) -> Real:
        """Return E[q f(q)] / E[q²], f the part of the displacement q beyond a gap, of each gap.

        Parameters
        ----------
        gaps_m : (n_gaps,) array [m]
            On either side of the middle.
        """
        amplitude = np.abs(np.concatenate(self.envelopes))
        amplitude *= math.sqrt(2.0) * self.displacement_m / np.sqrt(np.mean(amplitude**2))
        over = np.minimum(gaps_m[:, None] / np.maximum(amplitude, 1e-300), 1.0)
        inside = (np.arcsin(over) + over * np.sqrt(1.0 - over**2)) * 2.0 / math.pi
        return np.asarray(np.mean(amplitude**2 * (1.0 - inside), axis=1) / np.mean(amplitude**2))

    def half_width_hz(self, phase_rate: float = 0.0) -> tuple[float, float]:
        """Return the half-width of the peak without what amplitude does to the phase, and its std.

        The phase is turned back by what the amplitude turned it; a force that is white about the
        mode stays white.

        Parameters
        ----------
        phase_rate : float [rad/(s m²)]
            Angular frequency per square of the amplitude: 3 k₃ / (8 ω).

        Returns
        -------
        half_width, std : float [Hz]
        """
        turned_back = []
        for each in self.envelopes:
            square = np.abs(each) ** 2
            turn = np.cumsum(square - square.mean()) * phase_rate / self.rate_hz
            turned_back.append(each * np.exp(-1j * turn))
        found = peak(turned_back, self.rate_hz, self.carrier_hz, self.colour).half_width_hz
        return found, self._scatter_hz(found, LEVELS.width_scatter)

    def amplitude_half_width_hz(self) -> tuple[float, float]:
        """Return the half-width that the amplitude alone tells, and its std [Hz]."""
        found = amplitude_half_width(
            self.envelopes, self.rate_hz, self.noise_share, self.carrier_hz, self.colour
        )
        return found, self._scatter_hz(found, LEVELS.amplitude_width_scatter)

    def stiffness_within(self) -> tuple[float, float]:
        """Return what the stiffness changes with the square within the record, and its std.

        By the rate of the phase over the squared amplitude, a line by least squares: within a
        record the amplitude of a mode comes and goes by itself, between levels with all others.

        Returns
        -------
        slope, std : float [1/(m² s²)]
            As a cubic stiffness is.
        """
        square = np.concatenate([np.abs(each[1:-1]) ** 2 for each in self.envelopes])
        turned = np.concatenate(
            [(each[1:-1].conj() * _slope(each, self.rate_hz)).imag for each in self.envelopes]
        )
        square_m2 = 2.0 * self.displacement_m**2 * square / square.mean()
        turned *= square_m2.mean() / square.mean()
        away = square_m2 - np.mean(square_m2**2) / square_m2.mean()
        over = float(square_m2 @ away**2)
        rate = float(turned @ away) / over
        left = turned - square_m2 * (turned.sum() / square_m2.sum() + rate * away)
        per_rate = 2.0 * math.sqrt(self.stiffness) / 0.75
        return per_rate * rate, per_rate * float(np.linalg.norm(left * away)) / over

    def damping_within(self) -> tuple[float, float]:
        """Return what damping changes with the square within the record, and its std.

        Over what damping is: by the moments of the amplitude.  Under a white force it is Rayleigh
        distributed where damping is linear, and less spread where damping grows.

        Returns
        -------
        slope, std : float [s²/m²]
            As a cubic damping is, over the damping.
        """
        square = np.concatenate([np.abs(each) ** 2 for each in self.envelopes])
        square *= 2.0 * self.velocity_m_s**2 / square.mean()
        second, fourth, sixth = (float(np.mean(square**n)) for n in (1, 2, 3))
        # What the band cut off is force that has not yet turned: it is alike at all amplitudes.
        beyond = (1.0 + self.cut_share) ** 3
        spread = max(sixth - 2.0 * second * fourth, LEVELS.least_spread * second**3)
        ratio = (2.0 * second**2 - fourth) / (beyond * spread)
        half_width_hz = self.half_width_hz()[0]
        std = 1.0 / (second * math.sqrt(4.0 * math.pi * half_width_hz * self.duration_s))
        return ratio / (0.75 * (1.0 + ratio * fourth / second)), std / 0.75

    def _scatter_hz(self, half_width_hz: float, at_bands: tuple[float, float]) -> float:
        """Return the standard deviation of a half-width in the band of the envelopes."""
        bands = (LEVELS.half_widths, LEVELS.flank_half_widths)
        over_least = float(np.interp(0.5 * self.rate_hz / half_width_hz, bands, at_bands))
        return over_least * _least_scatter_hz(half_width_hz, self.duration_s)


def motions_at_levels(records: Sequence[ModeRecord]) -> list[ModalMotion | str]:
    """Return how a mode moves in records, or why that is not known: too short, too much noise.

    Bands are the same in all, for the widest peak, and so is the colour that the force is taken
    to have.

    Parameters
    ----------
    records : sequence of ModeRecord
        Of one mode, excited alike but for the level.
    """
    half_width_hz = max(each.mode.damping_ratio * each.mode.frequency_hz for each in records)
    seen = [mode_in_record(each, half_width_hz) for each in records]
    known = [each for each in seen if isinstance(each, ModeInRecord)]
    if not known:
        return [each for each in seen if isinstance(each, str)]
    colour = common_colour([_flanks(each) for each in known])
    return [each if isinstance(each, str) else _motion(each, colour) for each in seen]


def _flanks(seen: ModeInRecord) -> tuple[float, Peak]:
    """Return the mean square of the displacement and the peak that flanks have."""
    flanks = seen.within(seen.wide_hz)
    square = np.concatenate([np.abs(each.displacement) ** 2 for each in flanks])
    return float(square.mean()), _peak(flanks, None)


def _motion(seen: ModeInRecord, colour: Colour) -> ModalMotion | str:
    f, zeta = seen.mode.frequency_hz, seen.mode.damping_ratio
    found, flanks = seen.within(seen.reach_hz), seen.within(seen.wide_hz)
    narrow, broad = (_peak(each, colour.exponent) for each in (found, flanks))
    flanks_agree = _alike(narrow.half_width_hz, broad.half_width_hz, _length_s(found))
    envelopes = flanks if flanks_agree else found
    # A wide band has more noise: what else a narrow one has is of a peak that the level bends.
    within = min(narrow.noise_share, broad.noise_share)
    noise_share = broad.noise_share if flanks_agree else within
    if not noise_share < LEVELS.largest_noise:
        return f'{100.0 * noise_share:.0f} % of the power about it are noise'
    displacement = _moments([each.displacement for each in found])
    velocity = _moments([each.velocity for each in found])
    duration_s = _length_s(found)
    linear = _linear_mode(f, zeta, seen.reach_hz, duration_s, colour.exponent)
    ratio, ratio_std, share, by_colour = linear
    reach_hz = seen.wide_hz if flanks_agree else seen.reach_hz
    whole = (1.0 - within) / share
    stiffness = velocity[0] / displacement[0] / ratio
    return ModalMotion(
        math.sqrt(whole * displacement[0]),
        math.sqrt(whole * velocity[0]),
        whole * displacement[1] / displacement[0],
        whole * velocity[1] / velocity[0],
        min(1.0, LEVELS.amplitude_scatter / math.sqrt(zeta * f * duration_s)),
        stiffness,
        stiffness * ratio_std,
        by_colour * colour.std,
        tuple(each.displacement for each in envelopes),
        envelopes[0].rate_hz,
        envelopes[0].carrier_hz,
        noise_share,
        max(1.0 / _linear_mode(f, zeta, reach_hz, duration_s, colour.exponent)[2] - 1.0, 0.0),
        seen.moves_over_others,
        f,
        seen.mode.frequency_std_hz,
        zeta,
        seen.mode.damping_ratio_std,
        colour.exponent,
    )


def _peak(found: Sequence[Narrow], colour: float | None) -> Peak:
    envelopes = [each.displacement for each in found]
    return peak(envelopes, found[0].rate_hz, found[0].carrier_hz, colour)


def _length_s(found: Sequence[Narrow]) -> float:
    return sum(len(each.displacement) for each in found) / found[0].rate_hz


def _alike(narrow_hz: float, wide_hz: float, duration_s: float) -> bool:
    """Tell whether a wider band has the same peak: other modes and coloured forces bend flanks.

    The wider one has all that the narrow one has, so that their difference scatters by what it
    knows better (Hausman 1978, doi:10.2307/1913827).
    """
    least_hz = _least_scatter_hz(narrow_hz, duration_s)
    return abs(wide_hz - narrow_hz) < LEVELS.widths_apart * least_hz


def _least_scatter_hz(half_width_hz: float, duration_s: float) -> float:
    """Return the least standard deviation that the length of a record allows."""
    return half_width_hz / math.sqrt(2.0 * math.pi * half_width_hz * duration_s)


def _slope(envelope: Complex, rate_hz: float) -> Complex:
    """Return the change of a periodic envelope in a second, without its first and last sample."""
    hz = np.fft.fftfreq(len(envelope), 1.0 / rate_hz)
    return np.asarray(np.fft.ifft(2j * np.pi * hz * np.fft.fft(envelope)))[1:-1]


def _moments(envelopes: Sequence[Complex]) -> tuple[float, float]:
    """Return second and fourth moment of a narrow band: E[|z|²]/2, 3/8 E[|z|⁴]."""
    square = np.concatenate([np.abs(each) ** 2 for each in envelopes])
    return float(square.mean()) / 2.0, 0.375 * float(np.mean(square**2))


def _linear_mode(
    f: float, zeta: float, reach_hz: float, duration_s: float, colour: float
) -> tuple[float, float, float, float]:
    """Return the ratio of moments over ω² of a linear mode in a band, its deviation, its share.

    And how the ratio changes with the colour, the power of frequency that the force goes with.

    Lines scatter as their own expectation, so that the variance of a ratio of their sums is that
    of the sum of (ω² - ratio) times the density.  The share is over π f / (4 ζ), the integral of
    the density under a white force (Crandall and Mark 1963, Random Vibration).
    """
    step = 1.0 / duration_s
    hz = np.arange(max(step, f - reach_hz), f + reach_hz, step)
    square = (hz / f) ** 2
    density = (hz / f) ** colour / ((1.0 - square) ** 2 + 4.0 * zeta**2 * square)
    ratio = float(density @ square / density.sum())
    std = float(np.linalg.norm((square - ratio) * density) / density.sum())
    share = float(density.sum()) * step / (math.pi * f / (4.0 * zeta))
    by_colour = float(density @ ((square - ratio) * np.log(hz / f)) / density.sum()) / ratio
    return ratio, std / ratio, share, by_colour
