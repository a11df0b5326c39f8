"""Sensors that do not show the motion the others show: their clock slips, or they hear else.

Where one mode outweighs all else, what one sensor reads is a combination of what the others read.
It is not where its clock drifts or steps within the window, where it sends old samples, images
of what lies above half its rate, or its own noise.
"""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh

from modal_core.samples import Samples
from oma_identifier.quality import noise_rms
from oma_identifier.synchrony.sensor_peaks import Columns, Peak

INCOHERENT = 'incoherent'
NO_RESPONSE = 'no_response'
ROWS_AT_ONCE = 4096
ROUNDING = 1e-13
"""Share of the strongest direction's power that is none of its own."""
RANK = 3
"""Modes that overlap at a peak.  Fewer other channels cannot tell so many apart: of two healthy
channels two of three pairs came below ``LEAST_COHERENCE``, hence nothing is said of them."""
LEAST_COHERENCE = 0.8
"""Share of a sensor's power at a peak, noise left out, that the others explain.  In 200 records of
random structures each, up to twelve modes below 70 Hz damped by up to 5 %: 0.4 % of 1,011 healthy
sensors of three axes came below, 1.2 % of 1,371 of one axis; of sensors whose samples were old, or
whose clock drifted, all 267, of those with images of higher frequencies 94 % of 133."""
LEFT_OUT_COHERENCE = 0.6
"""The same below which a sensor is left out; between the two it is named only.  Of the healthy
sensors above, 0.1 % of three axes and 0.4 % of one axis come below."""
ABOVE_NOISE = 4.0
"""Power of a peak over that of the noise, from where on it is looked at."""
ALIKE = 0.2
"""Power over the others', both in shares of their variance, from where on a peak is compared.  One
that a sensor shows alone may be an image of what lies above half its rate, or a part of its own
that rattles: the two cannot be told apart, and neither is a mode of the structure."""

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]


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
    left, shown = dict(columns), [_Shown.at(peak) for peak in peaks]
    out: list[str] = []
    while len(left) > 1:
        worst = {name: _worst(name, left, shown, floor) for name in left}
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
    share = noise_rms(rows) ** 2 / np.maximum(_variance(rows), 1e-300)
    # A line of a taper is a difference of two lines of a transform.
    return np.asarray(2.0 * len(rows) * share)


def _variance(rows: Real) -> Real:
    """Return the variance of each column, without a copy of all of them."""
    mean, total = rows.mean(axis=0), np.zeros(rows.shape[1])
    for first in range(0, len(rows), ROWS_AT_ONCE):
        total += np.sum((rows[first : first + ROWS_AT_ONCE] - mean) ** 2, axis=0)
    return np.asarray(total / len(rows))


def _without_response(peaks: list[Peak], floor: Real) -> list[int]:
    """Return the channels that show no peak above their noise."""
    if not peaks:
        return []
    power = np.array([np.mean(np.abs(peak.spectra) ** 2, axis=(0, 1)) for peak in peaks])
    return np.flatnonzero((power < ABOVE_NOISE * floor).all(axis=0)).tolist()


@dataclass(frozen=True, slots=True)
class _Shown:
    """What all channels show of one peak.

    Parameters
    ----------
    products : (n_channels, n_channels) complex array
        Sums over all lines of the channels' conjugate values times one another.
    n_values : int
        Of each channel.
    n_free : float
        Independent ones among them.
    """

    products: Complex
    n_values: int
    n_free: float

    @classmethod
    def at(cls, peak: Peak) -> '_Shown':
        values = peak.spectra.reshape(-1, peak.spectra.shape[2])
        return cls(values.conj().T @ values, len(values), peak.n_free)

    def explained(self, own: NDArray[np.int64], others: NDArray[np.int64]) -> float:
        """Return the power of some channels along the strongest directions of others."""
        among = self.products[np.ix_(others, others)]
        strongest = (len(others) - RANK, len(others) - 1)
        power, weights = eigh(among, subset_by_index=strongest)
        along = np.sum(np.abs(weights.conj().T @ self.products[np.ix_(others, own)]) ** 2, axis=1)
        real = power > ROUNDING * power[-1]
        return float(np.sum(along[real] / power[real]))


@dataclass(frozen=True, slots=True)
class _View:
    """One peak as a sensor and the others see it: power in shares of variance, and coherence."""

    own: float
    others: float
    coherence: float


def _views(name: str, columns: Columns, peaks: list[_Shown], floor: Real) -> list[_View]:
    own = columns[name]
    others = np.concatenate([each for other, each in columns.items() if other != name])
    seen = [_view(peak, own, others, floor) for peak in peaks]
    return [view for view in seen if view is not None]


def _view(
    peak: _Shown, own: NDArray[np.int64], others: NDArray[np.int64], floor: Real
) -> _View | None:
    """Return None where a sensor's noise hides the peak, or the others are too few to tell."""
    each = np.diag(peak.products).real
    total = float(each[own].sum())
    noise = float(peak.n_values * floor[own].sum())
    enough = min(len(others), int(peak.n_free) // 4) >= RANK
    if total < ABOVE_NOISE * noise or not enough:
        return None
    rest = total - peak.explained(own, others)
    # Chance explains its share of what is not common.
    rest *= peak.n_free / (peak.n_free - RANK)
    power = float(each[others].mean()) / peak.n_values
    coherence = 1.0 - max(0.0, rest - noise) / (total - noise)
    return _View(total / (peak.n_values * len(own)), power, coherence)


def _worst(name: str, columns: Columns, peaks: list[_Shown], floor: Real) -> float:
    """Return the least coherence of the peaks that a sensor shows, beside the others or alone."""
    views = _views(name, columns, peaks, floor)
    return min((v.coherence for v in views if v.own > ALIKE * v.others), default=1.0)
