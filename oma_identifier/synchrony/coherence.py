"""Sensors that do not show the motion the others show: their clock slips, or they hear else.

Where one mode outweighs all else, what one sensor reads is a combination of what the others read.
It is not where its clock drifts or steps within the window, where it sends old samples, images
of what lies above half its rate, or its own noise.
"""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from modal_core.numbers.chance import fisher_tail
from modal_core.samples import Samples
from oma_identifier.quality import noise_rms
from oma_identifier.synchrony.multiple_coherence import residual_of
from oma_identifier.synchrony.sensor_peaks import Columns, Peak
from oma_identifier.synchrony.thresholds import SYNCHRONY

INCOHERENT = 'incoherent'
NO_RESPONSE = 'no_response'
TINY = 1e-300
ROWS_AT_ONCE = 512

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
    left, shown = dict(columns), [_Shown.at(peak, floor) for peak in peaks]
    flags = {names[place]: NO_RESPONSE for place in _without_response(shown)}
    out: list[str] = []
    while len(left) > 1 and shown:
        found = np.array([peak.coherence(list(left.values())) for peak in shown])
        worst, surely = (dict(zip(left, each, strict=True)) for each in found.min(axis=0))
        name = min(worst, key=lambda each: worst[each])
        if worst[name] >= SYNCHRONY.least_coherence:
            break
        flags |= {names[place]: INCOHERENT for place in left[name]}
        if len(left) == 2:
            # Of two that contradict each other nobody knows which one is right.
            other = next(each for each in left if each != name)
            flags |= {names[place]: INCOHERENT for place in left[other]}
            break
        out += [name] if surely[name] < SYNCHRONY.left_out_coherence else []
        del left[name]
    return Coherence(frozenset(out), flags)


def _floor(samples: Samples) -> Real:
    """Return the power of each channel's noise in a line of the peaks' spectra, at most."""
    rows = samples.acceleration
    share = noise_rms(rows) ** 2 / np.maximum(variance(rows), TINY)
    # A line of a taper is a difference of two lines of a transform.
    return np.asarray(2.0 * len(rows) * share)


def variance(rows: NDArray[np.floating]) -> Real:
    """Return the variance of each column, without a copy of all of them."""
    mean, total = rows.mean(axis=0, dtype=np.float64), np.zeros(rows.shape[1])
    for first in range(0, len(rows), ROWS_AT_ONCE):
        part = rows[first : first + ROWS_AT_ONCE] - mean
        total += np.einsum('tc,tc->c', part, part)
    return np.asarray(total / len(rows))


def _without_response(shown: list['_Shown']) -> list[int]:
    """Return the channels that show no peak above their noise, nor anything of the others'."""
    if not shown:
        return []
    faint = [np.diag(peak.products).real < SYNCHRONY.above_noise * peak.floor for peak in shown]
    silent = np.all(faint, axis=0)
    if silent.any():
        silent &= np.min([peak.chance() for peak in shown], axis=0) * len(shown) > SYNCHRONY.deaf
    return np.flatnonzero(silent).tolist()


@dataclass(frozen=True, slots=True)
class _Shown:
    """What the channels show of one peak.

    Parameters
    ----------
    products : (n_channels, n_channels) complex array
        Sums over all lines of the channels' conjugate values times one another.
    floor : (n_channels,) array
        The same of their noise alone, at most, of each with itself.
    n_free : float
        Independent ones among them.
    """

    products: Complex
    floor: Real
    n_free: float

    @classmethod
    def at(cls, peak: Peak, floor: Real) -> '_Shown':
        values = peak.spectra.reshape(-1, peak.spectra.shape[2])
        return cls(values.conj().T @ values, len(values) * floor, peak.n_free)

    def coherence(self, sensors: list[Places]) -> Real:
        """Return each sensor's with the others; 1 where it does not show the peak.

        Neither does it where its noise hides the peak, or the others are too few to tell.

        Returns
        -------
        (2, n_sensors) array
            At what it shows at all, and at what it shows about as strongly as the others.
        """
        every = np.concatenate(sensors)
        ends = np.cumsum([len(own) for own in sensors])
        places = np.split(np.arange(len(every)), ends[:-1])
        total, noise, left, n_used = self._regressed(every, places)
        count = np.array([len(own) for own in sensors])
        n_others = len(every) - count
        beside = (total.sum() - total) / np.maximum(n_others, 1)
        shows = total > SYNCHRONY.above_noise * noise
        shows &= total / count > SYNCHRONY.alike * beside
        shows &= (n_used >= SYNCHRONY.fewest_used) & (n_others >= SYNCHRONY.fewest_others)
        share = 1.0 - left / np.maximum(total - noise, TINY)
        for sensor in np.flatnonzero(shows & (share < SYNCHRONY.least_coherence)):
            shows[sensor] = self._agree(np.delete(every, places[sensor]))
        strongly = shows & (total / count > SYNCHRONY.left_out_alike * beside)
        return np.array([np.where(shows, share, 1.0), np.where(strongly, share, 1.0)])

    def _agree(self, channels: Places) -> bool:
        """Tell whether channels explain one another: then they know all modes there are."""
        total, noise, left, _ = self._regressed(channels, _singles(len(channels)))
        return bool(left.sum() <= (1.0 - SYNCHRONY.agreed) * np.maximum(total - noise, TINY).sum())

    def _regressed(self, every: Places, sensors: list[Places]) -> tuple[Real, Real, Real, Real]:
        """Return each sensor's power, that of its noise, what others leave, and how many do."""
        own = np.diag(self.products).real[every], self.floor[every]
        total, noise = (np.array([x[places].sum() for places in sensors]) for x in own)
        rest = residual_of(self.products[np.ix_(every, every)], sensors, self.n_free)
        # Chance explains its share of what is not common.
        left = rest.power * self.n_free / (self.n_free - rest.n_used) - noise
        return total, noise, np.maximum(left, 0.0), rest.n_used

    def chance(self) -> Real:
        """Return the probability that noise has as much in common with the others as each has.

        Of each channel, (n_channels,).
        """
        total = np.diag(self.products).real
        rest = residual_of(self.products, _singles(len(total)), self.n_free)
        used = np.maximum(rest.n_used, 1e-9)
        free = self.n_free - used
        common = np.maximum(total - rest.power, 0.0) / used
        ratio = common / np.maximum(rest.power / free, TINY)
        return np.asarray(fisher_tail(ratio, 2.0 * used, 2.0 * free))


def _singles(n_channels: int) -> list[Places]:
    """Return every channel as if it were a sensor of its own."""
    return [np.array([channel]) for channel in range(n_channels)]
