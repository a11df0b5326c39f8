"""Peaks that end as no resonance does: of a narrow-band force, or of a line that wanders.

Far from its middle a resonance falls with the square of the distance.  A vortex street, a rotor
whose speed wanders or a fan that hunts shake a structure in a band of their own, and what answers
there has the shape of the structure and peaks as a mode does; but such a band ends.  Both bells
are fitted to the motion along the shape of a supposed mode, in the model of all that moves beside
it, and the likelihoods of the two are compared: they have as many parameters.

What a mode does where the band of such a force reaches is not the answer to a smooth force: it
looks sharper or broader, and nearer to the force.

References
----------
Vickery and Basu (1983), doi:10.1016/0167-6105(83)90080-9 (spectrum of forces of vortices, a
Gaussian bell); Cox (1961), tests of separate families of hypotheses, Proc. 4th Berkeley Symp. 1.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
import math

import numpy as np
from numpy.typing import NDArray

from oma_identifier.likelihood import (
    BandData,
    BandIndex,
    BandModel,
    expected_spectra,
    forced_gain,
    GroupFit,
    ModeIndex,
)
from oma_identifier.refinement.thresholds import REFINEMENT

Real = NDArray[np.float64]
Shape = Callable[[Real], tuple[Real, Real]]
"""Distances in widths to the logarithm of a bell, and its derivative."""
STEPS, FIRST_DAMPING = 12, 0.1
"""Scoring steps of a bell, and what damps the first of them.  Of 390 supposed modes (80 random
records, seeds 988000 to 988079) the same 13 end after 12 steps as after 200."""
MOST_LOG, TINY = 30.0, 1e-12
REACH = 2.0
"""Deviations of the frequencies of a force, where its power has fallen by 9 dB.  In 150 random
records with such forces (seeds 986000 to 986069, 988000 to 988079) it reached 8 half-power bands
beside it: 6 were of no modes, and the two modes were 2.4 and 2.9 deviations off.  From 2 to 4 were
4 bands, all of modes, 2.1 deviations off at most."""
STARTS = 1.5, 3.0
"""Widths of a bell that ends to begin with, in half-widths of the mode."""


@dataclass(frozen=True, slots=True)
class NarrowForce:
    """Where a force of a narrow band is, or a line that wanders.

    Parameters
    ----------
    frequency_hz, reach_hz : float [Hz]
        Its middle, and how far it reaches to both sides.
    """

    frequency_hz: float
    reach_hz: float

    def shakes(self, frequency_hz: float, half_width_hz: float) -> bool:
        """Tell whether it reaches the half-power band of a mode."""
        return abs(frequency_hz - self.frequency_hz) < self.reach_hz + half_width_hz


def narrow_forces(fits: Sequence[GroupFit]) -> dict[ModeIndex, NarrowForce]:
    """Return the forces that stand behind supposed modes, by these."""
    found = {}
    for each in fits:
        if each.fit is None or each.band is None or not each.fit.converged:
            continue
        if not each.misfit < REFINEMENT.incomplete_misfit:
            continue
        for position, mode in each.members():
            force = narrow_force(each.band.data, each.fit.model, position)
            if force is not None:
                found[mode] = force
    return found


def alone(found: Mapping[ModeIndex, NarrowForce]) -> list[ModeIndex]:
    """Return the supposed modes that are none: no other one lies where the force reaches.

    A mode there peaks differently too, and nothing says which of the two is the force's.
    """
    return [
        mode
        for mode, force in found.items()
        if not any(
            other is not force and other.shakes(force.frequency_hz, 0.0)
            for other in found.values()
        )
    ]


def narrow_force(data: BandData, model: BandModel, position: BandIndex) -> NarrowForce | None:
    """Return the force behind a peak that ends, None where it is a mode as far as can be told.

    Of modes with another one in their half-power band it is not told: they share one peak.

    Parameters
    ----------
    data : BandData
        Of a band.
    model : BandModel
        At the maximum of its likelihood.
    position : BandIndex
        Of the supposed mode.
    """
    hz = float(model.frequency_hz[position])
    half_width_hz = float(model.damping_ratio[position]) * hz
    apart_hz = np.delete(np.abs(model.frequency_hz[: model.n_free] - hz), position)
    if np.any(apart_hz < half_width_hz):
        return None
    try:
        motion = _Motion.of(data, model, position)
        resonance = motion.most_likely(_resonance, 1.0)
        ending = max((motion.most_likely(_ending, width) for width in STARTS), key=_value)
    except np.linalg.LinAlgError:  # a model with next to no power in some direction
        return None
    is_own = abs(ending.middle) < REFINEMENT.ending_apart
    if not (is_own and ending.value - resonance.value > REFINEMENT.ending_odds):
        return None
    middle_hz = hz + ending.middle * half_width_hz
    return NarrowForce(middle_hz, REACH * ending.width * half_width_hz)


@dataclass(frozen=True, slots=True)
class _Bell:
    """A bell, in half-widths from a supposed mode, and the logarithm of its likelihood."""

    middle: float
    width: float
    value: float


def _value(bell: _Bell) -> float:
    return bell.value


def _resonance(away: Real) -> tuple[Real, Real]:
    return -np.log1p(away**2), -2.0 * away / (1.0 + away**2)


def _ending(away: Real) -> tuple[Real, Real]:
    return -0.5 * away**2, -away


@dataclass(frozen=True, slots=True)
class _Motion:
    """Motion along the shape of a mode, over what is expected there without it.

    Parameters
    ----------
    away : (n_lines,) array
        Distance from the mode in its half-widths.
    level : (n_lines,) array
        Power, 1 expected without the mode.
    seen : (n_lines,) array
        Level that the mode adds for each unit of its power.
    count : (n_lines,) array
        Values in each average.
    tilt : (n_lines,) array
        Logarithm of the power of the mode, 0 at its peak, over a bell of displacements that is
        even: of accelerations, and of a force with a slope.
    highest : float
        Logarithm of the power of the mode at its peak.
    """

    away: Real
    level: Real
    seen: Real
    count: Real
    tilt: Real
    highest: float

    @classmethod
    def of(cls, data: BandData, model: BandModel, position: BandIndex) -> '_Motion':
        hz, ratio = model.frequency_hz[position], model.damping_ratio[position]
        gain = forced_gain(data, model)
        amplitude = model.shapes * gain[:, None, :]
        # Without the mode and what its force has in common with the others.
        kept = np.arange(len(model.force)) != position
        rest = replace(model, force=np.where(np.outer(kept, kept), model.force, 0.0))
        beside = expected_spectra(rest, amplitude)
        shape = model.shapes[:, position]
        best = np.linalg.inv(beside) @ shape
        seen = np.einsum('c,kc->k', shape.conj(), best).real
        power = np.einsum('kc,kcd,kd->k', best.conj(), data.periodogram, best).real
        peak = model.force[position, position].real / (4.0 * ratio**2)
        if not (np.all(seen > 0.0) and peak > 0.0):
            raise np.linalg.LinAlgError
        away = (data.frequency_hz - hz) / (ratio * hz)
        own = 4.0 * ratio**2 * np.abs(gain[:, position]) ** 2
        return cls(
            np.asarray(away),
            np.asarray(power / seen),
            np.asarray(seen),
            data.n_averaged,
            np.log(own) + np.log1p(away**2),
            math.log(peak),
        )

    def most_likely(self, shape: Shape, width: float) -> _Bell:
        """Fit height, middle and width of a bell by Fisher scoring."""
        at, damping = np.array([self.highest, 0.0, math.log(width)]), FIRST_DAMPING
        value, score, information = self._evaluated(shape, at)
        for _ in range(STEPS):
            scale = np.diag(np.diag(information) + TINY)
            step = np.linalg.solve(information + damping * scale, score)
            trial = self._evaluated(shape, at + step)
            if trial[0] > value:
                at, damping = at + step, 0.1 * damping
                value, score, information = trial
            else:
                damping *= 10.0
        return _Bell(float(at[1]), _width(at), value)

    def _evaluated(self, shape: Shape, at: Real) -> tuple[float, Real, Real]:
        """Return the log-likelihood, its gradient, and the information."""
        width = _width(at)
        away = (self.away - at[1]) / width
        bell, slope = shape(away)
        added = self.seen * np.exp(np.clip(at[0] + self.tilt + bell, -MOST_LOG, MOST_LOG))
        expected = 1.0 + added
        value = -float(np.sum(self.count * (np.log(expected) + self.level / expected)))
        by = (added / expected) * np.stack([np.ones(len(away)), -slope / width, -slope * away])
        left = self.count * (self.level / expected - 1.0)
        return value, by @ left, (by * self.count) @ by.T


def _width(at: Real) -> float:
    return math.exp(np.clip(at[2], -MOST_LOG, MOST_LOG))
