"""Sensors that do not show the motion the others show: their clock slips, or they hear else.

Where one mode outweighs all else, what one sensor reads is a combination of what the others read.
It is not where its clock drifts or steps within the window, where it sends old samples, images
of what lies above half its rate, or its own noise.
"""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from modal_core.samples import Samples
from oma_identifier.quality import noise_rms
from oma_identifier.synchrony.explained_power import explained, nearly_explained, RANK
from oma_identifier.synchrony.sensor_peaks import Columns, Peak

INCOHERENT = 'incoherent'
NO_RESPONSE = 'no_response'
ROWS_AT_ONCE = 512
LEAST_COHERENCE = 0.8
"""Share of a sensor's power at a peak, noise left out, that the others explain.  In 200 records of
random structures each, up to twelve modes below 70 Hz damped by up to 5 %: 0.4 % of 1,011 healthy
sensors of three axes came below, 1.2 % of 1,371 of one axis; of sensors whose samples were old, or
whose clock drifted, all 267, of those with images of higher frequencies 94 % of 133."""
LEFT_OUT_COHERENCE = 0.6
"""The same below which a sensor is left out; between the two it is named only.  Of the healthy
sensors above, 0.1 % of three axes and 0.4 % of one axis come below."""
SURELY = 0.95
"""Coherence, told of all sensors at once, from where on none is looked at by itself.  Of 251 views
of random structures that were below ``LEAST_COHERENCE`` none came there, the highest to 0.9."""
ABOVE_NOISE = 4.0
"""Power of a peak over that of the noise, from where on it is looked at."""
ALIKE = 0.2
"""Power over the others', both in shares of their variance, from where on a peak is compared.  One
that a sensor shows alone may be an image of what lies above half its rate, or a part of its own
that rattles: the two cannot be told apart, and neither is a mode of the structure."""

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]
Places = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class Coherence:
    """What the sensors of a window have in common.

    Parameters
    ----------
    left_out : frozenset of str
        Sensors that most others contradict.
    flags : dict of str to str
        What was found, by channel.
    """

    left_out: frozenset[str] = frozenset()
    flags: dict[str, str] = field(default_factory=dict)


def check_coherence(samples: Samples, peaks: list[Peak], columns: Columns) -> Coherence:
    """Compare each sensor with all others.

    Parameters
    ----------
    samples : Samples
        Of all sensors.
    peaks : list of Peak
        Of these samples.
    columns : mapping of str to int array
        Channels of each sensor.
    """
    floor = _floor(samples)
    names = samples.channel_names
    flags = {names[place]: NO_RESPONSE for place in _without_response(peaks, floor)}
    left, shown = dict(columns), [_Shown.at(peak, floor) for peak in peaks]
    out: list[str] = []
    while len(left) > 1 and shown:
        least = np.min([peak.coherence(list(left.values())) for peak in shown], axis=0)
        worst = dict(zip(left, least, strict=True))
        name = min(worst, key=lambda each: worst[each])
        if worst[name] >= LEAST_COHERENCE:
            break
        flags |= {names[place]: INCOHERENT for place in left[name]}
        if len(left) == 2:
            # Of two that contradict each other nobody knows which one is right.
            other = next(each for each in left if each != name)
            flags |= {names[place]: INCOHERENT for place in left[other]}
            break
        out += [name] if worst[name] < LEFT_OUT_COHERENCE else []
        del left[name]
    return Coherence(frozenset(out), flags)


def _floor(samples: Samples) -> Real:
    """Return the power of each channel's noise in a line of the peaks' spectra, at most."""
    rows = samples.acceleration
    share = noise_rms(rows) ** 2 / np.maximum(variance(rows), 1e-300)
    # A line of a taper is a difference of two lines of a transform.
    return np.asarray(2.0 * len(rows) * share)


def variance(rows: NDArray[np.floating]) -> Real:
    """Return the variance of each column, without a copy of all of them."""
    mean, total = rows.mean(axis=0, dtype=np.float64), np.zeros(rows.shape[1])
    for first in range(0, len(rows), ROWS_AT_ONCE):
        part = rows[first : first + ROWS_AT_ONCE] - mean
        total += np.einsum('tc,tc->c', part, part)
    return np.asarray(total / len(rows))


def _without_response(peaks: list[Peak], floor: Real) -> list[int]:
    """Return the channels that show no peak above their noise."""
    if not peaks:
        return []
    power = np.array([np.mean(np.abs(peak.spectra) ** 2, axis=(0, 1)) for peak in peaks])
    return np.flatnonzero((power < ABOVE_NOISE * floor).all(axis=0)).tolist()


@dataclass(frozen=True, slots=True)
class _Shown:
    """What the channels show of one peak.

    Parameters
    ----------
    products : (n_channels, n_channels) complex array
        Sums over all lines of the channels' conjugate values times one another.
    floor : (n_channels,) array
        The same of their noise alone, at most, of each with itself.
    n_values : int
        Of each channel.
    n_free : float
        Independent ones among them.
    """

    products: Complex
    floor: Real
    n_values: int
    n_free: float

    @classmethod
    def at(cls, peak: Peak, floor: Real) -> '_Shown':
        values = peak.spectra.reshape(-1, peak.spectra.shape[2])
        return cls(values.conj().T @ values, len(values) * floor, len(values), peak.n_free)

    def coherence(self, sensors: list[Places]) -> Real:
        """Return each sensor's with the others; 1 where it does not show the peak.

        Neither does it where its noise hides the peak, or the others are too few to tell.
        """
        every = np.concatenate(sensors)
        products, each = self.products[np.ix_(every, every)], np.diag(self.products).real
        count = np.array([len(own) for own in sensors])
        total, noise = (np.array([x[own].sum() for own in sensors]) for x in (each, self.floor))
        n_others = len(every) - count
        beside = (each[every].sum() - total) / np.maximum(n_others, 1)
        shows = (total > ABOVE_NOISE * noise) & (total / count > ALIKE * beside)
        shows &= np.minimum(n_others, int(self.n_free) // 4) >= RANK
        found = np.ones(len(sensors))
        if not shows.any():
            return found
        places = np.split(np.arange(len(every)), np.cumsum(count)[:-1])
        power = nearly_explained(products, places)
        found[shows] = self._share(power[shows], total[shows], noise[shows])
        for sensor in np.flatnonzero(found < SURELY):
            others = np.delete(np.arange(len(every)), places[sensor])
            exactly = np.asarray(explained(products, places[sensor], others))
            found[sensor] = self._share(exactly, total[sensor], noise[sensor])
        return found

    def _share(self, power: Real, total: Real, noise: Real) -> Real:
        # Chance explains its share of what is not common.
        rest = (total - power) * self.n_free / (self.n_free - RANK)
        return np.asarray(1.0 - np.maximum(0.0, rest - noise) / (total - noise))
