"""From records to complex spectra with their noise: what model and measurement are compared on."""

from dataclasses import dataclass, replace
from functools import cached_property
import itertools

import numpy as np
from numpy.typing import NDArray

from modal_core.errors import RecordingError
from model_gap.campaign.campaign import GapRecord
from model_gap.campaign.thresholds import CAMPAIGN

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
# A Hann window is this combination of neighbouring bins of the rectangular one.
HANN = (-0.25, 0.5, -0.25)
# E|Hann bin|² of white noise of unit rectangular bins.
HANN_POWER = 0.375
BLOCK = 64


@dataclass(frozen=True)
class Band:
    """Where model and measurement are compared.

    Parameters
    ----------
    low_hz, high_hz : float [Hz]
        Edges.
    """

    low_hz: float = 3.0
    high_hz: float = 60.0

    def within(self, rate_hz: float, where: str = '') -> 'Band':
        """Return what of the band samples of this rate tell of.

        Raises
        ------
        RecordingError
            Hardly anything: less than an octave.
        """
        high = min(self.high_hz, CAMPAIGN.usable_share * rate_hz)
        if high < CAMPAIGN.least_width * self.low_hz:
            raise RecordingError(
                'sensors too slow to compare anything',
                where=where,
                found=f'{rate_hz:.4g} Hz',
                expected=f'>= {CAMPAIGN.least_width * self.low_hz / CAMPAIGN.usable_share:.3g} Hz',
            )
        return replace(self, high_hz=high)


@dataclass(frozen=True)
class RecordSpectra:
    """One record in the frequency domain, scaled to one-sided amplitude over the root of the band.

    Parameters
    ----------
    record : GapRecord
        Where it came from.
    omega : (n_bins, 3) array [rad/s]
        Each compared bin with its two neighbours.
    motor_acceleration, motor_shift : (n_joints, n_bins, 3) complex array
        Motor motion on the same bins, rectangular window.
    measured : (n_channels, n_bins) complex array
        Readings, Hann window.
    noise_power : (n_channels, n_bins) array
        Expected |noise|² of ``measured`` less a right prediction: noise of the sensors, what the
        noise of the known motion makes of the prediction, and what a linear model misses.  Without
        bound for channels that the record does not have: they weigh nothing.
    tail : (BLOCK, n_blocks, 2 n_joints) array [rad/s²], [rad]
        Motor accelerations, then shifts from the start, in time, for what rings on after the
        record; the last sample first, running down the blocks.
    end_scale : float
        From a modal state to its spectrum.
    """

    record: GapRecord
    omega: Array
    motor_acceleration: Complex
    motor_shift: Complex
    measured: Complex
    noise_power: Array
    tail: Array
    end_scale: float

    @cached_property
    def long_motion(self) -> tuple[Array, Complex, Complex]:
        """Frequencies [rad/s], motor accelerations and shifts (n_joints, n) of the whole record.

        Twice as long, so that responses do not wrap around; up to where motion is known.
        """
        omega, acceleration, shift = _padded_motion(self.record)
        keep = omega <= 2.0 * np.pi * CAMPAIGN.motion_hz
        return omega[keep], acceleration[:, keep], shift[:, keep]

    @cached_property
    def whole_motion(self) -> tuple[Array, Complex, Complex]:
        """The same on all frequencies: what is to be transformed back."""
        return _padded_motion(self.record)

    @cached_property
    def places(self) -> NDArray[np.intp]:
        """Where the flattened triples are among the record's frequencies, (3 n_bins,)."""
        duration_s = len(self.record.acceleration) / self.record.sample_rate_hz
        return np.rint(self.omega.ravel() / (2.0 * np.pi) * duration_s).astype(np.intp)

    @property
    def count(self) -> int:
        """Number of complex data."""
        return int(np.count_nonzero(self.seen))

    @property
    def seen(self) -> NDArray[np.bool_]:
        """Which of the spectra are data, (n_channels, n_bins)."""
        return np.isfinite(self.noise_power)

    def over_noise(self, values: Complex) -> Complex:
        """Return spectra (n_channels, n_bins) over the noise."""
        return np.asarray(values / np.sqrt(self.noise_power))

    def squares(self, values: Complex) -> Array:
        """Return |values|² over the noise, (n_channels, n_bins); 0 where nothing is recorded."""
        return np.asarray(np.abs(values) ** 2 / self.noise_power)

    def from_noise(self, scaled: Complex) -> Complex:
        """Return spectra (n_channels, n_bins) of which ``over_noise`` makes these."""
        values, own = np.zeros_like(scaled), self.record.recorded
        values[own] = scaled[own] * np.sqrt(self.noise_power[own])
        return values

    @property
    def frequency_hz(self) -> Array:
        """Centres of the compared bins [Hz]."""
        return np.asarray(self.omega[:, 1] / (2.0 * np.pi))


def _padded_motion(record: GapRecord) -> tuple[Array, Complex, Complex]:
    padded = 2 * len(record.motor_acceleration)
    frequency = np.fft.rfftfreq(padded, 1.0 / record.sample_rate_hz)
    acceleration, shift = (
        np.asarray(np.fft.rfft(values, padded, axis=0).T)
        for values in (record.motor_acceleration, record.motor_shift)
    )
    return np.asarray(2.0 * np.pi * frequency), acceleration, shift


def hann(spectra: Complex) -> Complex:
    """Combine triples of rectangular bins (..., 3) into one Hann bin each."""
    return np.asarray(
        HANN[0] * spectra[..., 0] + HANN[1] * spectra[..., 1] + HANN[2] * spectra[..., 2]
    )


def record_spectra(
    record: GapRecord,
    band: Band,
    target_bins: int = CAMPAIGN.target_bins,
    lines_hz: tuple[float, ...] = (),
) -> RecordSpectra:
    """Transform a record.

    Leakage: what still rings when the record ends is computed (``PoseSystem.end_state``); the Hann
    window on both sides removes what remains of the ends.

    Raises
    ------
    RecordingError
        The sensors are too slow for the band.

    References
    ----------
    Pintelon and Schoukens (2012), System Identification: A Frequency Domain Approach, sec. 2.6.
    """
    count = len(record.acceleration)
    band = band.within(record.sample_rate_hz, record.name)
    frequency = np.fft.rfftfreq(count, 1.0 / record.sample_rate_hz)
    inside = np.flatnonzero((frequency >= band.low_hz) & (frequency <= band.high_hz))
    # Evenly spaced in the logarithm: a mode is as many of its widths away from the next bin at
    # every frequency.
    wanted = np.geomspace(inside[0], inside[-1], min(target_bins, len(inside)))
    bins = np.unique(np.rint(wanted).astype(int))
    for line in lines_hz:  # every bin of a line counts
        near = round(line * count / record.sample_rate_hz)
        bins = np.union1d(bins, np.arange(near - 3, near + 4))
    bins = bins[(bins >= 1) & (bins < len(frequency) - 1)]  # only those with two neighbours
    triples = bins[:, None] + np.array([-1, 0, 1])
    scale = 1.0 / np.sqrt(count)

    def transform(values: Array) -> Complex:
        return np.asarray(np.fft.rfft(values, axis=0) * scale)

    response = transform(record.acceleration - record.acceleration.mean(axis=0))
    sensor_noise = noise_power(response, np.asarray(frequency, dtype=float), band)
    motion = transform(record.motor_acceleration)
    share = motion_noise_share(record, motion, bins, 2.0 * np.pi * frequency[bins])
    power = smoothed(np.abs(response) ** 2, bins) * HANN_POWER
    noise = sensor_noise[:, None] + (share + CAMPAIGN.linearisation_error**2) * power.T
    noise[list(record.missing)] = np.inf
    return RecordSpectra(
        record=record,
        omega=2.0 * np.pi * frequency[triples],
        motor_acceleration=motion.T[:, triples],
        motor_shift=transform(record.motor_shift).T[:, triples],
        measured=hann(response.T[:, triples]),
        noise_power=noise,
        tail=tail_of(record.motor_acceleration, record.motor_shift, record.sample_rate_hz),
        end_scale=record.sample_rate_hz * scale,
    )


def tail_of(acceleration: Array, shift: Array, rate_hz: float) -> Array:
    """Return what ``RecordSpectra.tail`` holds of a motion, (n_samples, n_joints) each.

    Every sample: sums of fewer end elsewhere than those of the spectra.
    """
    motion = np.hstack([acceleration, shift - shift[0]])
    newest_first = motion[::-1][: int(CAMPAIGN.tail_s * rate_hz)]
    blocks = -(-len(newest_first) // BLOCK)
    padded = np.zeros((blocks * BLOCK, motion.shape[1]), dtype=np.float32)
    padded[: len(newest_first)] = newest_first
    return np.ascontiguousarray(padded.reshape(blocks, BLOCK, -1).transpose(1, 0, 2))


def motion_noise_share(
    record: GapRecord, motion: Complex, bins: NDArray[np.intp], omega: Array
) -> Array:
    """Return by how much of its power the prediction is wrong for noise of the known motion.

    What moves the joints and what is only noise on their angles goes through the same arm, so the
    prediction's share of noise is the motion's: S_n / (S - S_n), summed over the joints.

    Parameters
    ----------
    record : GapRecord
        With the noise of its motion.
    motion : (n_frequencies, n_joints) complex array [rad/s²]
        Rectangular window, over the root of the number of samples.
    bins : (n_bins,) array of int
        Which rows.
    omega : (n_bins,) array [rad/s]
        Their frequencies.

    Returns
    -------
    (n_bins,) array
        At most ten: there the motion is not known at all.
    """
    if not record.motion_noise.density.size:
        return np.zeros(len(bins))
    noise = record.motion_noise.acceleration_density(omega).sum(axis=0) * record.sample_rate_hz
    known = smoothed(np.sum(np.abs(motion) ** 2, axis=1, keepdims=True), bins)[:, 0]
    return np.asarray(noise / np.maximum(known - noise, 0.1 * np.maximum(noise, 1e-300)))


def smoothed(power: Array, bins: NDArray[np.intp]) -> Array:
    """Return the mean of a power over the bins around some, (n_bins, n_columns)."""
    total = np.concatenate([np.zeros((1, power.shape[1])), np.cumsum(power, axis=0)])
    low = np.maximum(bins - CAMPAIGN.smoothing_bins, 0)
    high = np.minimum(bins + CAMPAIGN.smoothing_bins + 1, len(power))
    return np.asarray((total[high] - total[low]) / (high - low)[:, None])


def noise_power(response: Complex, frequency: Array, band: Band) -> Array:
    """Return the expected |noise|² of a Hann bin of every channel, from the quietest band above.

    Parameters
    ----------
    response : (n_frequencies, n_channels) complex array
        Rectangular window.
    frequency : (n_frequencies,) array [Hz]
        Of its rows.
    band : Band
        The compared band; noise is read above it.
    """
    full = np.arange(1, len(response) - 1)
    power = np.abs(hann(response[full[:, None] + np.array([-1, 0, 1])].transpose(2, 0, 1))) ** 2
    top = CAMPAIGN.noise_top * frequency[-1]
    edges = np.linspace(min(band.high_hz * 1.1, 0.5 * top), top, 9)
    floors = []
    for low, high in itertools.pairwise(edges):
        chosen = (frequency[full] >= low) & (frequency[full] < high)
        if chosen.sum() >= 20:
            # The median of an exponential variable is ln 2 times its mean: robust against lines.
            floors.append(np.median(power[:, chosen], axis=1) / np.log(2.0))
    floor = (
        np.percentile(floors, CAMPAIGN.quietest, axis=0) if floors else np.median(power, axis=1)
    )
    return np.asarray(np.maximum(floor, 1e-6 * np.mean(power, axis=1)))


def quiet_rate_hz(band: Band) -> float:
    """Return the rate below which noise is read within the band for want of room above it [Hz]."""
    return 2.0 * band.high_hz / (CAMPAIGN.noise_top * (1.0 - 0.5 * CAMPAIGN.quietest / 100.0))
