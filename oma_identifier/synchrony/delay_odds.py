"""The odds that one sensor is late, from how the others see it at the peaks of a window.

A delay turns the phase of a cross spectrum by frequency times delay, the same delay at all modes,
and moves the beat of each narrow band by itself.  Shapes that are complex turn phases as well, but
each by its own angle, and move no beat.  So much may they be complex as ``COMPLEX`` says, each as
likely: what the phases scatter by is part of the evidence.  One structure in a hundred has phases
of any kind: a shaft that turns moves round and not to and fro.  A peak that a sensor hardly shows
says nothing of it.  The odds of a delay against none are taken over all delays there might be (a
Bayes factor), and those beyond the ones that are looked for, whose phases and beats may be
anything: as far as healthy shapes are like that, odds of one to ``delay_odds`` come up in less
than one of ``delay_odds`` synchronous sensors (Markov's inequality).

References
----------
Kass and Raftery (1995), doi:10.1080/01621459.1995.10476572 (Bayes factors).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
import math

import numpy as np
from numpy.typing import NDArray

from oma_identifier.synchrony.delay_likelihood import DelayLikelihood
from oma_identifier.synchrony.peak_view import PeakView
from oma_identifier.synchrony.thresholds import SYNCHRONY

SHORT_S = 2e-4
"""Nobody knows the order of magnitude of a delay: from here on all are as likely."""
DELAY_STEP_RAD = 0.15
"""Radians between two delays that are tried, at the highest peak."""
MOST_DELAYS = 30_000
NEAR = 0.7
"""Radians at the highest peak around the best delay that belong to it; the next is π away."""
SPACED = np.sinh(np.linspace(-5.0, 5.0, 161)) / math.sinh(5.0)
"""Where such delays are tried, in shares of that: most densely in the middle."""
LEAST_LIKELY = 1e-8
"""How likely, against the best, a delay is that need not be looked at."""
DEEP = 1e-26
"""How likely the best may be, against what is likeliest at each peak, to be found at once."""
CELL = 16
"""Delays that are ruled out together."""
ROUND = 0.01
"""Share of structures whose sensors differ by phases of any kind, none of them being late."""

Real = NDArray[np.float64]
Places = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class SensorDelay:
    """What the data say of one sensor.

    Parameters
    ----------
    seconds, std_s : float [s]
        How late it is, and the standard deviation; 0 and infinite where no delay is proved.
    log_odds : float
        Natural logarithm of the odds of a delay, whichever, against none; 0 where nothing tells.
    share : float
        Of what speaks against none, what speaks for this delay.
    highest_hz : float
        Highest peak it was compared at.
    turned_odds : float
        Natural logarithm of the odds of phases of any kind without a delay, against those of most
        structures.
    """

    seconds: float = 0.0
    std_s: float = math.inf
    log_odds: float = 0.0
    share: float = 0.0
    highest_hz: float = 0.0
    turned_odds: float = -math.inf

    @property
    def is_odd(self) -> bool:
        """Whether its phases are not those of a synchronous sensor."""
        return self.log_odds > math.log(SYNCHRONY.delay_odds)

    @property
    def is_turned(self) -> bool:
        """Whether its phases are those of no delay, nor of a structure that moves to and fro."""
        return not self.is_odd and self.turned_odds > math.log(SYNCHRONY.delay_odds)

    @property
    def is_undecided(self) -> bool:
        """Whether neither a delay nor none is proved."""
        return not (self.is_odd or self.log_odds < 0.0)

    @property
    def is_known(self) -> bool:
        """Whether it is one delay that explains them."""
        return self.share > SYNCHRONY.sure


def delays_of(views: Sequence[PeakView]) -> list[SensorDelay]:
    """Return the delay of each sensor, and the odds of it."""
    if not views:
        return []
    found = [SensorDelay()] * len(views[0].phase_std)
    seen = np.flatnonzero(np.any([view.is_seen for view in views], axis=0))
    if len(seen):
        search = _Search([view.of(seen) for view in views])
        for place, delay in zip(seen, search.found(), strict=True):
            found[place] = delay
    return found


class _Search:
    """The search for the delays of sensors.

    Parameters
    ----------
    views : sequence of PeakView
        Each sensor is seen at one of them at least.
    """

    def __init__(self, views: Sequence[PeakView]) -> None:
        self._likelihood = DelayLikelihood(views)
        seen_hz = [np.where(view.is_seen, view.frequency_hz, 0.0) for view in views]
        self._highest_hz = np.max(seen_hz, axis=0)
        step_s = DELAY_STEP_RAD / (2.0 * math.pi * self._highest_hz)
        self._step_s = np.maximum(step_s, 2.0 * SYNCHRONY.latest_s / MOST_DELAYS)
        self._all = np.arange(len(step_s))
        self._none = self._likelihood.of(self._all, np.zeros(len(step_s)), np.zeros(len(step_s)))

    def found(self) -> list[SensorDelay]:
        """Return what was found of each sensor."""
        sensor, tried_s, likelihood = self._everywhere()
        chance = likelihood * _prior(tried_s) * self._step_s[sensor]
        # The likelihood may be narrower than the steps.
        best_s = self._best(sensor, tried_s, chance)
        near_s, near = self._around(best_s, 1.5 * self._step_s, np.linspace(-1.0, 1.0, 61))
        best_s = near_s[self._all, np.argmax(near, axis=1)]
        reach_s = np.maximum(NEAR / (2.0 * math.pi * self._highest_hz), 2.0 * self._step_s)
        near_s, near = self._around(best_s, reach_s, SPACED)
        near *= _prior(near_s) * reach_s[:, None] * np.gradient(SPACED)
        this = near.sum(axis=1)
        far = np.abs(tried_s - best_s[sensor]) > reach_s[sensor]
        others = np.bincount(sensor[far], chance[far], len(self._all))
        turned, beyond = self._likelihood.any_phases(), self._likelihood.anything()
        delayed, none = this + others + beyond, self._none + ROUND * turned
        share, log_odds = this / (delayed + turned), np.log(delayed / none)
        turned_odds = np.log(ROUND * turned / self._none)
        found = [
            SensorDelay(
                log_odds=float(log_odds[k]),
                share=float(share[k]),
                highest_hz=float(self._highest_hz[k]),
                turned_odds=float(turned_odds[k]),
            )
            for k in self._all
        ]
        chances = near / this[:, None]
        return [_with_delay(*each) for each in zip(found, near_s, chances, strict=True)]

    def _everywhere(self) -> tuple[Places, Real, Real]:
        """Return sensors, delays [s] and their likelihood: of all that may count."""
        least = LEAST_LIKELY * np.maximum(self._none, DEEP * self._likelihood.most)
        while True:
            sensor, tried_s = self._worth_trying(least)
            likelihood = self._likelihood.of(sensor, tried_s, least)
            most = self._none.copy()
            np.maximum.at(most, sensor, likelihood)
            if (LEAST_LIKELY * most >= least).all():
                return sensor, tried_s, likelihood
            least = np.minimum(least, LEAST_LIKELY * most)

    def _worth_trying(self, least: Real) -> tuple[Places, Real]:
        """Return the sensors and delays that the beats leave, a grid through no delay."""
        n_cells = np.ceil(SYNCHRONY.latest_s / self._step_s / CELL).astype(np.int64)
        sensor = np.repeat(self._all, 2 * n_cells)
        cell = np.concatenate([np.arange(-n, n) for n in n_cells])
        cell_s = CELL * self._step_s[sensor]
        bound = self._likelihood.within(sensor, cell * cell_s, (cell + 1) * cell_s)
        left = bound >= least[sensor]
        sensor, cell = sensor[left], cell[left]
        step = (CELL * cell[:, None] + np.arange(CELL)).ravel()
        sensor = np.repeat(sensor, CELL)
        delay_s = step * self._step_s[sensor]
        inside = np.abs(delay_s) < SYNCHRONY.latest_s + self._step_s[sensor]
        return sensor[inside], delay_s[inside]

    def _best(self, sensor: Places, tried_s: Real, weight: Real) -> Real:
        order = np.lexsort((weight, sensor))
        last = np.searchsorted(sensor[order], self._all, side='right') - 1
        return np.asarray(tried_s[order][last])

    def _around(self, middle_s: Real, reach_s: Real, places: Real) -> tuple[Real, Real]:
        """Return delays about those of all sensors, and their likelihood, (n_sensors, n)."""
        delay_s = middle_s[:, None] + reach_s[:, None] * places
        at_middle = self._likelihood.of(self._all, middle_s, np.zeros(len(middle_s)))
        sensor = np.repeat(self._all, len(places))
        found = self._likelihood.of(sensor, delay_s.ravel(), LEAST_LIKELY * at_middle)
        return delay_s, found.reshape(delay_s.shape)


def _with_delay(found: SensorDelay, near_s: Real, chance: Real) -> SensorDelay:
    if not (found.is_odd and found.is_known):
        return found
    mean = float(chance @ near_s)
    std_s = math.sqrt(float(chance @ (near_s - mean) ** 2))
    return replace(found, seconds=mean, std_s=std_s)


def _prior(delay_s: Real) -> Real:
    """Return the density of delays [1/s]: as many within each factor of two."""
    decades = math.log1p(SYNCHRONY.latest_s / SHORT_S)
    return np.asarray(0.5 / (np.abs(delay_s) + SHORT_S) / decades, dtype=np.float64)
