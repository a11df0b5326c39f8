"""The odds that one sensor is late, from how the others see it at the peaks of a window.

A delay turns the phase of a cross spectrum by frequency times delay, the same delay at all modes,
and moves the beat of each narrow band by itself.  Shapes that are complex turn phases as well, but
each by its own angle, and move no beat.  So much may they be complex as ``COMPLEX`` says, each as
likely: what the phases scatter by is part of the evidence.  The odds of a delay against none are
taken over all delays there might be (a Bayes factor): as far as healthy shapes are like that, odds
of 1 to ``ODDS`` come up in less than one of ``ODDS`` synchronous sensors (Markov's inequality).

References
----------
Kass and Raftery (1995), doi:10.1080/01621459.1995.10476572 (Bayes factors).
"""

from collections.abc import Sequence
from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import NDArray
from scipy.special import logsumexp

from oma_identifier.synchrony.peak_view import LATEST_S, PeakView

SHORT_S = 2e-4
"""Nobody knows the order of magnitude of a delay: from here on all are as likely."""
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
ODDS = 1e3
"""Of a delay against none, from where on it is believed.  Of 968 synchronous sensors of random
structures, shapes of up to 30 % imaginary part, one came there; none was said to be late."""
SURE = 0.99
"""Share of what speaks for delays that must speak for one of them."""
FINE = 0.15
"""Radians between two delays that are tried, at the highest peak."""
MOST_TRIED = 30_000
NEAR = 0.7
"""Radians at the highest peak around the best delay that belong to it; the next is π away."""
N_NEAR = 801

Real = NDArray[np.float64]


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
    """

    seconds: float = 0.0
    std_s: float = math.inf
    log_odds: float = 0.0
    share: float = 0.0
    highest_hz: float = 0.0

    @property
    def is_odd(self) -> bool:
        """Whether its phases are not those of a synchronous sensor."""
        return self.log_odds > math.log(ODDS)

    @property
    def is_in_doubt(self) -> bool:
        """Whether neither a delay nor none is proved."""
        return not (self.is_odd or self.log_odds < 0.0)

    @property
    def is_known(self) -> bool:
        """Whether it is one delay that explains them."""
        return self.share > SURE


def delay_of(views: Sequence[PeakView]) -> SensorDelay:
    """Return the delay of a sensor, and the odds of it."""
    if not views:
        return SensorDelay()
    highest_hz = max(view.frequency_hz for view in views)
    step_s = max(FINE / (2.0 * math.pi * highest_hz), 2.0 * LATEST_S / MOST_TRIED)
    n_steps = math.ceil(LATEST_S / step_s)
    tried_s = _about(0.0, n_steps * step_s, 2 * n_steps + 1)
    likelihood = _likelihood(views, tried_s)
    weight = likelihood + np.log(_prior(tried_s) * step_s)
    best_s = float(tried_s[np.argmax(weight)])
    # The likelihood may be narrower than the steps.
    near_s = _about(best_s, 1.5 * step_s, 61)
    best_s = float(near_s[np.argmax(_likelihood(views, near_s))])
    reach_s = max(NEAR / (2.0 * math.pi * highest_hz), 2.0 * step_s)
    near_s = _about(best_s, reach_s, N_NEAR)
    near = _likelihood(views, near_s) + np.log(_prior(near_s) * 2.0 * reach_s / N_NEAR)
    others = logsumexp(weight[np.abs(tried_s - best_s) > reach_s])
    this = float(logsumexp(near))
    any_delay = float(logsumexp([this, others, _any_phases(views)]))
    found = SensorDelay(
        log_odds=any_delay - float(likelihood[n_steps]),
        share=math.exp(this - any_delay),
        highest_hz=highest_hz,
    )
    return _with_delay(found, near_s, np.exp(near - this))


def _about(middle: float, reach: float, n: int) -> Real:
    return np.asarray(np.linspace(middle - reach, middle + reach, n), dtype=np.float64)


def _with_delay(found: SensorDelay, near_s: Real, chance: Real) -> SensorDelay:
    if not (found.is_odd and found.is_known):
        return found
    mean = float(chance @ near_s)
    std_s = math.sqrt(float(chance @ (near_s - mean) ** 2))
    return SensorDelay(mean, std_s, found.log_odds, found.share, found.highest_hz)


def _prior(delay_s: Real) -> Real:
    """Return the density of delays [1/s]: as many within each factor of two."""
    return np.asarray(
        0.5 / (np.abs(delay_s) + SHORT_S) / math.log1p(LATEST_S / SHORT_S), dtype=np.float64
    )


def _likelihood(views: Sequence[PeakView], tried_s: Real) -> Real:
    """Return the logarithm of the likelihood of delays."""
    levels = np.array(COMPLEX)[:, None]
    by_level = np.zeros((len(COMPLEX), len(tried_s)))
    for view in views:
        square = np.interp(tried_s, view.lag_s, view.square.real) + 1j * np.interp(
            tried_s, view.lag_s, view.square.imag
        )
        angle = 0.5 * np.angle(square * np.exp(4j * math.pi * view.frequency_hz * tried_s))
        variance = view.phase_std**2 + (levels * view.complexity) ** 2
        by_level += np.log((1.0 - ODD) * _wrapped(angle, variance) + ODD / math.pi)
    phases = logsumexp(by_level, axis=0) - math.log(len(COMPLEX))
    return np.asarray(phases + _beats(views, tried_s), dtype=np.float64)


def _beats(views: Sequence[PeakView], tried_s: Real) -> Real:
    likelihood = np.zeros(len(tried_s))
    for view in views:
        if view.width_hz > 0.0:
            bent = 2.0 * math.pi * view.width_hz * (tried_s - view.beat_s)
            density = np.full(len(tried_s), ODD / (2.0 * LATEST_S))
            for share, factor, bend in BENDS:
                std = math.hypot(factor * view.phase_std, bend)
                density += share * view.width_hz * _normal(bent / std) * 2.0 * math.pi / std
            likelihood += np.log(density)
    return likelihood


def _normal(value: Real) -> Real:
    return np.asarray(np.exp(-0.5 * value**2) / math.sqrt(2.0 * math.pi), dtype=np.float64)


def _any_phases(views: Sequence[PeakView]) -> float:
    """Return the same for phases that have nothing to do with each other."""
    return float(_beats(views, np.zeros(1))[0]) - len(views) * math.log(math.pi)


def _wrapped(angle: Real, variance: Real) -> Real:
    """Return the normal density wrapped to half a turn."""
    density = sum(
        np.exp(-0.5 * (angle + turn) ** 2 / variance) for turn in (-math.pi, 0.0, math.pi)
    )
    return np.asarray(density / np.sqrt(2.0 * math.pi * variance), dtype=np.float64)
