"""A force that passed a high-pass: behind each tap it reads less than nothing, for a while.

Converters and sensors coupled by alternating current lose the mean of what they measure: of a
force f they read f' = f - ω z, where ż = f'.  Behind a tap of impulse I that is -ω I exp(-ωt)
instead of nothing: a window around the tap cuts most of it off, and the response has all.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from operator import is_

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from impact_testing.measuring_chain.corner import Corner, NO_CORNER
from impact_testing.measuring_chain.drift import drift_of
from impact_testing.record import ImpactRecord, runs_of
from impact_testing.taps import begin_of, FILTER_SAMPLES, taps_of

Real = NDArray[np.float64]
TWO_PI = 2.0 * np.pi
LOWEST_HZ, HIGHEST_HZ = 0.01, 10.0
"""Of corners: couplings of converters are at 0.1 to 5 Hz, those of sensors below."""
TRIED = 25
"""Corners, a third apart."""
LEAST_ROWS = 16
"""Before the first tap, from which what the force reads at rest is known."""
BEYOND = 6.0
"""Deviations by which a corner is one."""


def force_corner(records: Sequence[ImpactRecord]) -> Corner:
    """Estimate the corner of a force channel from what it reads apart from the taps.

    It must explain more than a drift does.
    """
    runs = [_RunForce.of(run) for record in records for run in runs_of(record)]
    if all(each.quiet.all() for each in runs):
        return NO_CORNER
    rough = _nearest(runs)
    settled = [each.settled(rough) for each in runs]
    found = rough if all(map(is_, runs, settled)) else _nearest(settled)
    left = np.concatenate([each.left(found) for each in settled])
    step = 1e-3 * found
    slope = [
        (each.left(found + step) - each.left(found - step)) / (2.0 * step) for each in settled
    ]
    noise, steep = float(np.mean(left**2)), sum(float(np.sum(each**2)) for each in slope)
    gain = _cost([each.settled(0.0) for each in runs], 0.0) - _cost(settled, found)
    std = float(np.sqrt(noise / steep)) if steep > 0.0 else np.inf
    return Corner(found / TWO_PI, std / TWO_PI, sure=gain > BEYOND**2 * noise)


def _nearest(runs: Sequence['_RunForce']) -> float:
    """Return the corner that leaves least [rad/s]."""
    grid = np.linspace(np.log(TWO_PI * LOWEST_HZ), np.log(TWO_PI * HIGHEST_HZ), TRIED).tolist()
    best = int(np.argmin([_cost(runs, np.exp(each)) for each in grid]))
    ends = grid[max(0, best - 1)], grid[min(TRIED - 1, best + 1)]
    return float(np.exp(minimize_scalar(lambda log: _cost(runs, np.exp(log)), bounds=ends).x))


def _cost(runs: Sequence['_RunForce'], corner_1_s: float) -> float:
    return sum(float(np.sum(each.left(corner_1_s) ** 2)) for each in runs)


def restored(record: ImpactRecord, corner: Corner) -> ImpactRecord:
    """Return a record with the force that was there before the high-pass."""
    runs = [_RunForce.of(run) for run in runs_of(record)]
    force = [each.force_n + each.rest_n + each.lost(TWO_PI * corner.hz) for each in runs]
    return replace(record, force_n=np.concatenate(force))


@dataclass(frozen=True)
class _RunForce:
    """Force of a run, and where there is no tap.

    Parameters
    ----------
    force_n : (n,) array [N]
        Without its rest.
    rest_n : float [N]
        What it reads before the first tap.
    quiet : (n,) bool array
        Rows apart from the taps.
    rate_hz : float [Hz]
    """

    force_n: Real
    rest_n: float
    quiet: NDArray[np.bool_]
    rate_hz: float

    @classmethod
    def of(cls, run: ImpactRecord) -> '_RunForce':
        """Find the taps of a record of one run."""
        force, quiet = run.force_n, np.ones(len(run.force_n), dtype=bool)
        for tap in taps_of(run):
            quiet[begin_of(run, tap) : tap.last + FILTER_SAMPLES + 1] = False
        before = int(np.argmin(quiet))
        rest = float(np.median(force[:before] if before >= LEAST_ROWS else force))
        return cls(force - rest, rest, quiet, run.rate_hz)

    def lost(self, corner_1_s: float) -> Real:
        """Return ω z: what the high-pass took away, by the taps alone."""
        step = corner_1_s / self.rate_hz
        edges = np.flatnonzero(np.diff(self.quiet)) + 1
        found, before = [np.zeros(0)], 0.0
        for part in np.split(np.arange(len(self.quiet)), edges):
            if self.quiet[part[0]]:
                now = before * np.exp(-step * np.arange(1, len(part) + 1))
            else:
                force = self.force_n[part]
                now = before + step * (np.cumsum(force) - 0.5 * (force + force[0]))
            found.append(now)
            before = float(now[-1])
        return np.concatenate(found)

    def left(self, corner_1_s: float) -> Real:
        """Return what the rows apart from the taps read beside what these left there."""
        apart = (self.force_n + self.lost(corner_1_s))[self.quiet]
        return np.asarray(apart - apart.mean()) if len(apart) else apart

    def settled(self, corner_1_s: float) -> '_RunForce':
        """Return the run without a drift that a corner leaves."""
        drift_n = drift_of(self.force_n + self.lost(corner_1_s), self.rate_hz)
        return replace(self, force_n=self.force_n - drift_n) if drift_n.any() else self
