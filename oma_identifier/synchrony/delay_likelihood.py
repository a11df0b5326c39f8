"""How likely delays are, from how sensors are seen at the peaks of a window.

Delays are tried in thousands, of all sensors at once.  Each peak can say no more for one than if
its phase and its beat were just right: a delay that could not come up to the best with what is
left of the peaks is given up.
"""

from collections.abc import Sequence
import math

import numpy as np
from numpy.typing import NDArray

from oma_identifier.synchrony.peak_view import PeakView
from oma_identifier.synchrony.thresholds import SYNCHRONY

COMPLEX = (0.01, 0.03, 0.1, 0.3, 0.5)
"""Imaginary parts over the size of a shape, root mean square, that a structure may have; with 0.3
at most in the truth, forces that are correlated make it up to 0.5."""
ODD = 0.05
"""Share of peaks that are no single mode: their phases say nothing."""
BENDS = ((0.8, 1.0, 0.003), (0.15, 4.0, 0.03))
"""Shares of peaks, and by how much their phase bends from one side to the other: in deviations of
that phase, and in radians beside.  In 1,450 pairs of synchronous sensors of random structures half
were bent by 0.5 deviations, a tenth by more than 2, a hundredth by more than 5 to 24, by tails of
other modes.  The rest are no single mode (``ODD``)."""

DELAYS_AT_ONCE = 8192
"""Delays whose densities are made together."""
NOTHING = 1e-9
"""Share of a density that does not count."""

Real = NDArray[np.float64]
Places = NDArray[np.int64]


class DelayLikelihood:
    """How likely delays are.

    Parameters
    ----------
    views : sequence of PeakView
        At least one; of so few peaks that the product of their densities is a number.
    """

    def __init__(self, views: Sequence[PeakView]) -> None:
        # The sharpest first: it rules out most.
        self._views = sorted(views, key=_sharpness)
        self._phases = [_Phases(view) for view in self._views]
        self._beats = [_Beats(view) for view in self._views]
        most = [p.most * b.most for p, b in zip(self._phases, self._beats, strict=True)]
        # What the peaks from each on come to at most.
        self._most = np.cumprod([np.ones_like(most[0]), *most[::-1]], axis=0)[::-1]

    @property
    def most(self) -> Real:
        """Nothing is more likely, (n_sensors,)."""
        return np.asarray(self._most[0].max(axis=0))

    def of(self, sensor: Places, delay_s: Real, least: Real) -> Real:
        """Return the likelihood of delays of sensors, each (n,).

        Parameters
        ----------
        sensor, delay_s : (n,) array
            What is tried.
        least : (n_sensors,) array
            What is less likely may be given as 0.
        """
        found = np.zeros(len(sensor))
        for first in range(0, len(sensor), DELAYS_AT_ONCE):
            part = slice(first, first + DELAYS_AT_ONCE)
            found[part] = self._part(sensor[part], delay_s[part], least)
        return found

    def _part(self, sensor: Places, delay_s: Real, least: Real) -> Real:
        found = np.zeros(len(sensor))
        place, levels = (
            np.arange(len(sensor)),
            np.flatnonzero((self._most[0] >= least).any(axis=1)),
        )
        product = np.ones((len(levels), len(sensor)))
        for phases, beats, most in zip(self._phases, self._beats, self._most[1:], strict=True):
            product *= phases.density(levels, sensor, delay_s) * beats.density(sensor, delay_s)
            wanted = least / most[levels]
            stays = product >= wanted[:, sensor]
            lasting, kept = stays.any(axis=1), stays.any(axis=0)
            levels, product = levels[lasting], product[lasting][:, kept]
            place, sensor, delay_s = place[kept], sensor[kept], delay_s[kept]
        found[place] = product.sum(axis=0) / len(COMPLEX)
        return found

    def within(self, sensor: Places, low_s: Real, high_s: Real) -> Real:
        """Return what no delay of a range exceeds: by the beats, each (n,)."""
        bound = np.prod([phases.most for phases in self._phases], axis=0).max(axis=0)[sensor]
        for view, beats in zip(self._views, self._beats, strict=True):
            bound *= beats.density(sensor, np.clip(view.beat_s[sensor], low_s, high_s))
        return np.asarray(bound)

    def any_phases(self) -> Real:
        """Return that of phases that have nothing to do with each other, beside beats in step.

        Of each sensor, (n_sensors,).
        """
        every = np.arange(len(self._views[0].phase_std))
        beats = [beats.density(every, np.zeros(len(every))) for beats in self._beats]
        return np.asarray(np.prod(beats, axis=0) * self._of_any_phase)

    def anything(self) -> Real:
        """Return that of phases and beats that have nothing to do with each other."""
        beats = [beats.anywhere for beats in self._beats]
        return np.asarray(np.prod(beats, axis=0) * self._of_any_phase)

    @property
    def _of_any_phase(self) -> Real:
        n_seen = np.sum([view.is_seen for view in self._views], axis=0)
        return np.asarray(math.pi ** -n_seen.astype(float))


def _sharpness(view: PeakView) -> float:
    return float(np.min(view.phase_std, initial=math.inf, where=view.is_seen))


class _Phases:
    """What the phases of one peak say of delays."""

    def __init__(self, view: PeakView) -> None:
        self._view = view
        levels = np.array(COMPLEX)[:, None]
        variance = view.phase_std**2 + (levels * view.complexity) ** 2
        # A sensor that is not seen says nothing: its phase is as likely whatever it is.
        self._bend = np.where(view.is_seen, -0.5 / variance, -1.0)
        height = (1.0 - ODD) / np.sqrt(2.0 * math.pi * variance)
        self._height = np.where(view.is_seen, height, 0.0)
        self._floor = np.where(view.is_seen, ODD / math.pi, 1.0)
        # Of narrow densities nothing comes round half a turn.
        round_about = self._height * np.exp(self._bend * (math.pi / 2.0) ** 2)
        self._wraps = np.any(round_about > NOTHING * self._floor, axis=1)[:]
        every = np.arange(len(view.phase_std))
        self.most = self._density(np.arange(len(COMPLEX)), every, np.zeros(len(every)))

    def density(self, levels: Places, sensor: Places, delay_s: Real) -> Real:
        """Return the density, (n_levels, n)."""
        view = self._view
        at = (delay_s - view.lag_s[0]) / (view.lag_s[1] - view.lag_s[0])
        lag = np.minimum(np.maximum(at.astype(np.int64), 0), len(view.lag_s) - 2)
        below, above = view.square[sensor, lag], view.square[sensor, lag + 1]
        square = below + np.minimum(np.maximum(at - lag, 0.0), 1.0) * (above - below)
        half_turns = np.angle(square) / (2.0 * math.pi) + 2.0 * view.frequency_hz * delay_s
        return self._density(levels, sensor, math.pi * (half_turns - np.rint(half_turns)))

    def _density(self, levels: Places, sensor: Places, angle: Real) -> Real:
        """Return the normal density wrapped to half a turn."""
        bend = self._bend[levels[:, None], sensor]
        density = np.exp(bend * angle**2)
        for level in np.flatnonzero(self._wraps[levels]):
            for turn in (-math.pi, math.pi):
                density[level] += np.exp(bend[level] * (angle + turn) ** 2)
        return np.asarray(self._height[levels[:, None], sensor] * density + self._floor[sensor])


class _Beats:
    """What the beat of one peak says of delays."""

    def __init__(self, view: PeakView) -> None:
        self._beat_s = view.beat_s
        tells = view.is_seen & (view.width_hz > 0.0)
        self._turns = np.where(tells, 2.0 * math.pi * view.width_hz, 0.0)
        self.anywhere = np.where(tells, 1.0 / (2.0 * SYNCHRONY.latest_s), 1.0)
        self._floor = np.where(tells, ODD * self.anywhere, 1.0)
        self._bend, self._height = [], []
        for share, factor, bend in BENDS:
            std = np.hypot(factor * np.where(tells, view.phase_std, 1.0), bend)
            self._bend.append(-0.5 / std**2)
            self._height.append(share * self._turns / (math.sqrt(2.0 * math.pi) * std))
        self.most = self.density(np.arange(len(tells)), view.beat_s)

    def density(self, sensor: Places, delay_s: Real) -> Real:
        """Return the density, (n,)."""
        square = (self._turns[sensor] * (delay_s - self._beat_s[sensor])) ** 2
        density = self._floor[sensor]
        for bend, height in zip(self._bend, self._height, strict=True):
            density = density + height[sensor] * np.exp(bend[sensor] * square)
        return np.asarray(density)
