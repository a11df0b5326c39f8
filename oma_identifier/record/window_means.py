"""What the windows of a record tell together of each mode, and whether they agree.

The mean of the windows is about as good as one estimate of the whole record where a window is
many decay times long.  Where the windows differ by more than their deviations allow there is no
one value: the mode drifts, or moves with the pose.  Then the scatter is part of the deviation.

References
----------
DerSimonian and Laird (1986), doi:10.1016/0197-2456(86)90046-2 (scatter between estimates).
"""

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
import logging
import math

import numpy as np
from numpy.typing import NDArray

from modal_core.mode import Mode, ModeSet
from modal_core.numbers.chance import fisher_tail
from modal_core.numbers.indicators import mac, mpc, mpd, normalise
from oma_identifier.likelihood import overlaps
from oma_identifier.record.thresholds import RECORD

log = logging.getLogger(__name__)
WHOLE_RANGE = math.sqrt(12.0)
"""Of what drifts evenly, over its standard deviation."""

Real = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class MeanMode:
    """A mode over the windows of a record.

    Parameters
    ----------
    mode : Mode
        Mean; its deviations hold the scatter between windows where they disagree.
    between : float
        Scatter of the frequency between windows, over the frequency; 0 where chance explains it.
    range_hz : tuple of float [Hz]
        Lowest and highest frequency of the windows.
    """

    mode: Mode
    between: float
    range_hz: tuple[float, float]

    @property
    def varies(self) -> bool:
        """Whether the windows' frequencies disagree."""
        return self.between > 0.0

    def is_image(self, mode: Mode) -> bool:
        """Tell whether a mode of the whole record is this one at some time."""
        reach = 1.0 + mode.damping_ratio
        low, high = self.range_hz[0] / reach, self.range_hz[1] * reach
        inside = low < mode.frequency_hz < high
        return inside and float(mac(self.mode.shape, mode.shape)[0, 0]) > RECORD.same_mac

    def moves(self, mode: Mode) -> bool:
        """Tell whether this mode of the record as one moves as its windows say.

        A bell of the half-width z that moves evenly by h to both sides has the half-width
        √(z² + h²).  One that is wider, beyond chance, is no mode of the windows that moved, and of
        one far narrower than h they were too short: it holds still, and its neighbours mix in.
        Of 62 modes that drifted (seeds 385002 to 385029) none was wider, the widest by 0.97.
        """
        half_way = 0.5 * WHOLE_RANGE * self.between
        least = mode.damping_ratio - 2.0 * mode.damping_ratio_std
        if least > math.hypot(self.mode.damping_ratio, half_way):
            return False
        return self.varies and mode.damping_ratio > RECORD.narrowest * half_way

    def widen(self, mode: Mode, modes: ModeSet) -> Mode:
        """Return this mode, one of those of the record as one, with the scatter between windows.

        Where it moved by much of its half-width its damping is that of the windows.  What moves is
        broader in the record: where windows show it broader, they are too short for it, and beyond
        chance nothing is known of its damping.  Windows of a mode that overlaps with another one
        mix the two, and their damping has no deviation: of four on made twin machines (seeds
        989708 to 989729) it was 1.7 to 6.9 of them too low.
        """
        moves = self.between * mode.frequency_hz
        wider = replace(mode, frequency_std_hz=math.hypot(mode.frequency_std_hz, moves))
        if WHOLE_RANGE * self.between < RECORD.smeared * mode.damping_ratio:
            return wider
        ratio, std = self.mode.damping_ratio, self.mode.damping_ratio_std
        if ratio > mode.damping_ratio:
            by_chance = ratio - 2.0 * std < mode.damping_ratio
            return wider if by_chance else replace(wider, damping_ratio_std=math.nan)
        others = [other for other in modes if other is not mode]
        std = math.nan if overlapping(mode, others).any() else std
        return replace(wider, damping_ratio=ratio, damping_ratio_std=std)


def overlapping(mode: Mode, modes: Iterable[Mode]) -> NDArray[np.bool_]:
    """Return which half-power bands of modes touch that of one, (n_modes,)."""
    hz, ratio = np.array([(each.frequency_hz, each.damping_ratio) for each in (mode, *modes)]).T
    return overlaps(hz, hz * ratio)[0, 1:]


@dataclass(slots=True)
class Sightings:
    """One mode in window after window; the shapes summed, of those with the same largest entry."""

    last: Mode
    rows: list[tuple[float, ...]] = field(default_factory=list)
    weight: float = 0.0
    shape: NDArray[np.complex128] | None = None
    variance: NDArray[np.complex128] | None = None
    loss: float = 0.0
    loss_spread: float = 0.0

    def add(self, mode: Mode, share: float) -> None:
        """Add the mode of one window, of which a share of the samples is new."""
        self.rows.append(
            (
                math.log(mode.frequency_hz),
                mode.frequency_std_hz / mode.frequency_hz,
                mode.damping_ratio,
                mode.damping_ratio_std,
                share,
            )
        )
        self.last = mode
        if mode.shape_std is None or not mode.mac_loss > 0.0:
            return
        if self.shape is None or self.variance is None:
            self.shape = np.zeros(len(mode.shape), dtype=complex)
            self.variance = np.zeros(len(mode.shape), dtype=complex)
        elif np.argmax(np.abs(self.shape)) != np.argmax(np.abs(mode.shape)):
            return
        weight = share / mode.mac_loss
        self.weight += weight
        self.shape += weight * mode.shape
        square = mode.shape_std.real**2 + 1j * mode.shape_std.imag**2
        self.variance += weight**2 / share * square
        self.loss += weight**2 / share * mode.mac_loss
        self.loss_spread = mode.mac_loss_std / mode.mac_loss

    @property
    def n_independent(self) -> float:
        """Windows it was seen in, each sample counted once."""
        return sum(row[-1] for row in self.rows)

    def mean(self) -> MeanMode:
        """Return the mode over its windows."""
        log_f, f_std, damping, d_std, share = np.array(self.rows).T
        # Variances are proportional to the damping estimated: by them, low damping would weigh.
        frequency = _combined(log_f, f_std, share, damping)
        ratio = _combined(damping, d_std, share, damping)
        f_hz = math.exp(frequency.mean)
        moved = WHOLE_RANGE * frequency.between / share.sum()
        mode = replace(
            self.last,
            frequency_hz=f_hz,
            frequency_std_hz=frequency.std * f_hz,
            damping_ratio=ratio.mean,
            damping_ratio_std=ratio.std if moved < RECORD.smeared * ratio.mean else math.nan,
        )
        low, high = float(np.exp(log_f.min())), float(np.exp(log_f.max()))
        return MeanMode(self._shaped(mode), frequency.between, (low, high))

    def _shaped(self, mode: Mode) -> Mode:
        """Return the mode with the mean of the shapes, where any has a deviation."""
        if self.shape is None or self.variance is None:
            return mode
        shape, loss = normalise(self.shape), self.loss / self.weight**2
        std = np.sqrt(self.variance.real) + 1j * np.sqrt(self.variance.imag)
        return replace(
            mode,
            shape=shape,
            shape_std=std / self.weight,
            mac_loss=loss,
            mac_loss_std=self.loss_spread * loss,
            mpc=float(mpc(shape[:, None])[0]),
            mpd=float(mpd(shape[:, None])[0]),
        )


@dataclass(frozen=True, slots=True)
class _Combined:
    mean: float
    own_std: float
    between: float = 0.0

    @property
    def std(self) -> float:
        return math.hypot(self.own_std, self.between)


def _combined(values: Real, std: Real, share: Real, level: Real) -> _Combined:
    """Combine estimates of windows, each of which has a share of new samples.

    Parameters
    ----------
    values, std, share : (n_windows,) array
        Estimates, their deviations, and the part of each window that no other one holds.
    level : (n_windows,) array
        What the variances are proportional to: weights shall not follow from it.
    """
    known = np.isfinite(std) & (std > 0.0)
    if not known.any():
        return _Combined(float(np.average(values, weights=share)), math.nan)
    values, variance, share = values[known], std[known] ** 2, share[known]
    weight = share * level[known] / variance
    weight = weight / weight.sum()
    mean = float(weight @ values)
    own = float(weight**2 @ (variance / share))
    away = (values - mean) ** 2
    degrees = share.sum() - 1.0
    if degrees < 1.0:
        return _Combined(mean, math.sqrt(own))
    ratio = float(share @ (away / variance)) / degrees
    if fisher_tail(ratio, degrees, RECORD.degrees) > RECORD.varies_chance:
        return _Combined(mean, math.sqrt(own))
    between = max(float(weight @ (away - variance)), 0.0)
    return _Combined(mean, math.sqrt(own), math.sqrt(between))


class WindowMeans:
    """Collects the tracked modes of windows; of each only numbers are kept, shapes are summed.

    Attributes
    ----------
    n_independent : float
        Windows, each sample counted once.
    """

    def __init__(self) -> None:
        self._seen: dict[int, Sightings] = {}
        self.n_independent = 0.0

    def add(self, modes: ModeSet, share: float) -> None:
        """Add the modes of a window, of which a share of the samples is new."""
        self.n_independent += share
        for mode in modes:
            self._seen.setdefault(mode.id, Sightings(mode)).add(mode, share)

    def share_of(self, mode: Mode) -> float:
        """Return the share of the time of the windows that show a mode, by its id."""
        seen = self._seen.get(mode.id)
        return 0.0 if seen is None else seen.n_independent / self.n_independent

    def means(self) -> list[MeanMode]:
        """Return the modes that are in the record by what the windows show, by frequency."""
        least = max(RECORD.least_windows, RECORD.least_share * self.n_independent)
        means = []
        for seen in self._seen.values():
            if seen.n_independent >= least:
                means.append(seen.mean())
            else:
                log.debug(
                    '%.4g Hz: no mode of the record by its windows, in %.2g of %.2g',
                    seen.last.frequency_hz,
                    seen.n_independent,
                    least,
                )
        return sorted(means, key=lambda mean: mean.mode.frequency_hz)
