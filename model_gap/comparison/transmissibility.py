"""What the sensors read per what the model says they should, for the same motion of the joints.

The motion is known, so the model's prediction carries it to each sensor; the ratio of the
measured to the predicted spectrum is the ratio of the two transmissibilities: 1 at 0° with
coherence 1 where the model is right.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from model_gap.campaign import Complex
from model_gap.comparison.spectra_pairs import SpectraPair, used_bands
from model_gap.comparison.thresholds import LIMITS


@dataclass(frozen=True)
class Ratio:
    """Measured over predicted, of one or several channels in one band.

    Parameters
    ----------
    magnitude, phase_rad, coherence : float
        Of the averaged cross spectrum; coherence squared, 0..1.
    magnitude_sigma, phase_sigma_rad : float
        Standard deviations.

    References
    ----------
    Bendat and Piersol (2010), Random Data, Eqs. (9.90) and (9.91).
    """

    magnitude: float
    phase_rad: float
    coherence: float
    magnitude_sigma: float
    phase_sigma_rad: float


@dataclass(frozen=True)
class SensorBand:
    """One sensor in one band, over all recordings.

    Parameters
    ----------
    sensor : str
        Its name.
    low_hz, high_hz : float [Hz]
        The band.
    measured, predicted_before, predicted_after : float [m/s²]
        Root mean square in the band, over recordings and axes.
    level_sigma_db : float [dB]
        Standard deviation of a level.
    noise : float [m/s²]
        What noise of sensors and motion makes of the difference.
    before, after : Ratio
        Measured over predicted.
    """

    sensor: str
    low_hz: float
    high_hz: float
    measured: float
    predicted_before: float
    predicted_after: float
    level_sigma_db: float
    noise: float
    before: Ratio
    after: Ratio


def ratio(measured: Complex, predicted: Complex, noise: float = 0.0) -> Ratio:
    """Return measured over predicted of two sets of bins.

    Parameters
    ----------
    measured, predicted : (n_bins,) complex array
        Spectra.
    noise : float
        Expected power of their difference when the model is right, summed over the bins.  Noise of
        the known motion makes the magnitude too small by its share of the power; that share counts
        as uncertainty.
    """
    cross = complex(np.vdot(predicted, measured))
    one, two = float(np.vdot(predicted, predicted).real), float(np.vdot(measured, measured).real)
    if one <= 0.0 or two <= 0.0:
        return Ratio(0.0, 0.0, 0.0, float('inf'), float('inf'))
    coherence = min(abs(cross) ** 2 / (one * two), 1.0)
    count = max(LIMITS.independent * measured.size, 1.0)
    relative = float(
        np.sqrt((1.0 - coherence) / (2.0 * count * max(coherence, LIMITS.least_coherence)))
    )
    size = abs(cross) / one
    magnitude_sigma = size * float(np.hypot(relative, noise / one))
    return Ratio(size, float(np.angle(cross)), coherence, magnitude_sigma, relative)


def sensor_bands(pairs: Sequence[SpectraPair], channels: Sequence[str]) -> tuple[SensorBand, ...]:
    """Return the table of sensors and bands.

    Parameters
    ----------
    pairs : sequence of SpectraPair
        All recordings.
    channels : sequence of str
        Names of the channels.
    """
    names = [name.rsplit('.', 1)[0] for name in channels]
    found = []
    for sensor in dict.fromkeys(names):
        rows = [number for number, name in enumerate(names) if name == sensor]
        for low, high in used_bands(pairs):
            found.append(_sensor_band(pairs, sensor, rows, low, high))
    return tuple(found)


def _sensor_band(
    pairs: Sequence[SpectraPair], sensor: str, rows: list[int], low: float, high: float
) -> SensorBand:
    masks = [pair.inside(low, high) for pair in pairs]
    cut = [
        tuple(
            spectra[np.intersect1d(rows, pair.item.record.recorded)][:, mask].ravel()
            for spectra in (pair.item.measured, pair.before, pair.after, pair.item.noise_power)
        )
        for pair, mask in zip(pairs, masks, strict=True)
    ]
    measured, before, after, noise = (np.concatenate(part) for part in zip(*cut, strict=True))
    # A bin's power is the density over the record; the band's is the sum over all its bins.
    shares = [2.0 * (high - low) / pair.item.record.sample_rate_hz / 0.375 for pair in pairs]
    scale = float(np.mean(shares))

    def level(power: np.ndarray) -> float:
        return float(np.sqrt(np.mean(power) * scale))

    return SensorBand(
        sensor=sensor,
        low_hz=low,
        high_hz=high,
        measured=level(np.abs(measured) ** 2),
        predicted_before=level(np.abs(before) ** 2),
        predicted_after=level(np.abs(after) ** 2),
        level_sigma_db=float(
            10.0 / np.log(10.0) / np.sqrt(max(LIMITS.independent * len(measured), 1.0))
        ),
        noise=level(noise),
        before=ratio(measured, before, float(noise.sum())),
        after=ratio(measured, after, float(noise.sum())),
    )
