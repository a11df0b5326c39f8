"""By how much the force is late, or early, against the responses.

Other filters or converters delay it.  Delayed, a sum of modes has terms beyond the residual ones
and every mode's residue is turned by ω times the delay: what is left of the FRFs is least, and the
residues are nearest to real ones, where the delay is taken out.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from impact_testing.fit import free_fit, start_poles
from impact_testing.measuring_chain.phases import common_phases
from impact_testing.responses import PointData, PointFrf

Complex = NDArray[np.complex128]
TRIED = np.arange(-6, 7) / 2.0
"""Delays of the force [samples]; filters of unlike converters differ by more, and are seen in the
taps themselves."""
LEAST_SAMPLES = 0.1
"""Less is not told: it turns no residue by more than 0.25 rad, at 0.4 of the sample rate."""
FEWEST_MODES = 3
"""Two phases have a scatter that says little."""
BEYOND = 6.0
"""Standard deviations, of the median over the modes."""
LEAST_GAIN = 0.5
"""Share of the cost without it that a delay leaves at most: it is a small part of what modes and
residual terms explain, and nearly all of what they do not.  Of 120 healthy random tests (0.5 to
5 %, 2 to 5 modes) none had a delay by these limits."""
OF_MEDIAN = 1.2533 * 1.4826
"""Median absolute deviation of n Gaussian values to the deviation of their median, times √n."""


@dataclass(frozen=True, slots=True)
class ForceDelay:
    """How late the force comes against the responses.

    Parameters
    ----------
    seconds, std_s : float [s]
        Negative: early.
    sure : bool
        Whether it is larger than chance makes it, and both what is left and phases say so.
    """

    seconds: float
    std_s: float
    sure: bool


def force_delay(data: Sequence[PointData]) -> ForceDelay:
    """Estimate one delay for all points."""
    step_s = 1.0 / data[0].frf.spectra.record.rate_hz
    none = ForceDelay(0.0, float('inf'), sure=False)
    pole = start_poles(data)
    if len(pole) < FEWEST_MODES:
        return none
    if abs(float(np.median(_late_by_phase(data, pole)))) < LEAST_SAMPLES * step_s:
        # Most modes say that there is none: nothing need be tried.
        return none
    costs, poles = [], []
    for tried in TRIED.tolist():
        moved = earlier(data, tried * step_s)
        poles.append(start_poles(moved))
        costs.append(_cost(moved, poles[-1]))
    best = int(np.argmin(costs))
    pole, samples, std = poles[best], float(TRIED[best]), float('inf')
    if len(pole) < FEWEST_MODES:
        return none
    for _ in range(2):
        late = _late_by_phase(earlier(data, samples * step_s), pole) / step_s
        samples += float(np.median(late))
        std = OF_MEDIAN * float(np.median(np.abs(late - np.median(late)))) / np.sqrt(len(pole))
    sure = abs(samples) > max(LEAST_SAMPLES, BEYOND * std)
    if sure:
        without = costs[int(np.flatnonzero(TRIED == 0.0)[0])]
        sure = _cost(earlier(data, samples * step_s), pole) < LEAST_GAIN * without
    return ForceDelay(samples * step_s, std * step_s, sure)


def earlier(data: Sequence[PointData], seconds: float) -> list[PointData]:
    """Return points whose forces come earlier by so much."""
    found = []
    for each in data:
        spectra = each.frf.spectra
        pulses = [pulse.earlier(seconds, spectra.record.rate_hz) for pulse in spectra.pulses]
        # The noise is the same: weights that move with the delay would weigh what is looked for.
        found.append(replace(each, frf=PointFrf(spectra.with_force(pulses))))
    return found


def _cost(data: Sequence[PointData], pole: Complex) -> float:
    return sum(each.cost for each in free_fit(data, pole))


def _late_by_phase(data: Sequence[PointData], pole: Complex) -> NDArray[np.float64]:
    """Return by how much each mode says that the force is late [s]."""
    phase, _ = common_phases(data, pole)
    return phase / pole.imag
