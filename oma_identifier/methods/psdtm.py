"""Transmissibility between loading conditions as a method of the catalogue.

Under one dominant force the spectra of two channels have a ratio, the transmissibility, in which
the colour of the force and its lines cancel.  Its poles are not those of the structure.  But at a
pole of the structure it is the ratio of the mode's shape, whatever the force: there the
transmissibilities of two loading conditions are equal, and the inverse of their difference has a
pole.  A common-denominator polynomial is fitted to these inverses of all pairs of conditions.

A condition is a stretch in which the forces act alike: another joint that shakes, another pose,
another tool path.  They are found in the record: stretches whose principal direction at each
frequency agrees as well as that of either half of a stretch are one condition.  With one there is
nothing to compare.

Leaving out stretches tells which poles repeat, but not how far off they are: twice what it says
covers 80 to 100 % of simulated records, so that modes have no standard deviations.  Where a
second force acts at once the ratio depends on both, and modes are missed.

References
----------
Devriendt and Guillaume (2008), doi:10.1016/j.jsv.2008.02.026 (poles from transmissibilities);
Araújo and Laier (2014), doi:10.1016/j.ymssp.2014.02.008 (principal directions);
Maamar, Abdi and Gagnol (2019), transmissibility of a machining robot in operation.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
from numpy.typing import NDArray
from scipy.fft import rfft

from modal_core.errors import IdentificationError
from modal_core.numbers.tapers import hann
from modal_core.samples import Samples
from oma_identifier.methods.banded import BandedMethod, no_raw_poles, Problem
from oma_identifier.methods.half_spectra import HalfSpectra
from oma_identifier.methods.polyreference import NormalEquations
from oma_identifier.methods.solver import SolvedAnew, Solver
from oma_identifier.methods.thresholds import METHOD
from oma_identifier.motion import never, PeakTest
from oma_identifier.selection import Identified
from oma_identifier.settings import IdentificationSettings
from oma_identifier.subspace import RawPoles

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True, slots=True)
class Spectra:
    """Spectra of overlapping segments of a band.

    Parameters
    ----------
    first : (n_segments,) int array
        Row at which each begins.
    length : int
        Rows of a segment.
    angle : (n_lines,) array [rad]
        Frequency times the sampling interval.
    line : (n_segments, n_lines, n_channels) complex array
    """

    first: NDArray[np.int64]
    length: int
    angle: Real
    line: Complex

    @classmethod
    def of(cls, problem: Problem) -> 'Spectra':
        """Return the spectra of a band's rows."""
        rows, rate = problem.rows, problem.band.sample_rate_hz
        length = max(64, len(rows) // METHOD.transfer_segments)
        first = np.arange(0, len(rows) - length + 1, length // 2)
        angle = 2.0 * np.pi * np.arange(length // 2 + 1) / length
        low, high = 0.8 * problem.band.low_hz / rate, min(0.49, 1.05 * problem.band.high_hz / rate)
        kept = (angle > 2.0 * np.pi * low) & (angle < 2.0 * np.pi * high)
        taper = hann(length)[:, None]
        line = [rfft(rows[each : each + length] * taper, axis=0)[kept] for each in first]
        return cls(first, length, angle[kept], np.array(line))

    def without(self, left_out: tuple[int, int] | None) -> NDArray[np.bool_]:
        """Return which segments do not touch a stretch."""
        if left_out is None:
            return np.ones(len(self.first), dtype=bool)
        return np.asarray((self.first + self.length <= left_out[0]) | (self.first >= left_out[1]))

    def direction(self, chosen: NDArray[np.int64]) -> Complex:
        """Return the principal direction at each line, (n_lines, n_channels)."""
        line = self.line[chosen].transpose(1, 2, 0)
        n_channels, n_segments = line.shape[1:]
        turned = line.conj().transpose(0, 2, 1)
        if n_segments >= n_channels:
            return np.asarray(np.linalg.eigh(line @ turned)[1][:, :, -1])
        # Of few segments the smaller matrix has the same directions.
        direction = (line @ np.linalg.eigh(turned @ line)[1][:, :, -1:])[:, :, 0]
        size = np.linalg.norm(direction, axis=1, keepdims=True)
        return np.asarray(direction / np.maximum(size, np.finfo(float).tiny))


class Psdtm:
    """Poles where loading conditions agree; no deviations, all are NaN."""

    name = 'psdtm'
    needs_inputs = False

    def identify(
        self,
        samples: Samples,
        settings: IdentificationSettings,
        inputs: Real | None = None,
        explains: PeakTest = never,
    ) -> Identified:
        """Identify the modes of one stretch.

        Raises
        ------
        IdentificationError
            There is one loading condition, or one channel.
        """
        if len(samples.channels) < 2:
            raise IdentificationError(
                'psdtm compares channels', found='one channel', expected='two or more'
            )
        bands = _Bands()
        found = bands.identify(samples, settings, None, explains)
        if bands.most_conditions < 2:
            raise IdentificationError(
                'psdtm compares loading conditions',
                found='one, the forces act alike all the time',
                expected='two or more',
                advice='record other joints, poses or tool paths one after the other, '
                'or use ssi_cov',
            )
        modes = tuple(mode.untold for mode in found.modes)
        return replace(
            found,
            modes=replace(found.modes, modes=modes),
            n_conditions=bands.most_conditions,
        )


class _Bands(BandedMethod):
    """The bands of one record, and the most loading conditions that one of them shows."""

    name = Psdtm.name

    def __init__(self) -> None:
        self.most_conditions = 0

    def prepare(self, problem: Problem, settings: IdentificationSettings) -> Solver:
        """Find the conditions; a band that shows one, or noise, has no poles."""
        spectra = Spectra.of(problem)
        condition = conditions(spectra)
        n_conditions = int(condition.max()) + 1
        self.most_conditions = max(self.most_conditions, n_conditions)

        def solve(orders: Sequence[int], left_out: tuple[int, int] | None) -> RawPoles:
            kept = spectra.without(left_out)
            each = [np.flatnonzero(kept & (condition == one)) for one in range(n_conditions)]
            if n_conditions < 2 or min(map(len, each)) == 0:
                return no_raw_poles(problem.n_channels)
            return poles_of_conditions(
                spectra.angle, [spectra.direction(one) for one in each], orders
            )

        return SolvedAnew(solve)


def conditions(spectra: Spectra) -> NDArray[np.int64]:
    """Return the loading condition of each segment, counted from 0; -1 in a change of them."""
    n_parts = METHOD.transfer_parts
    if len(spectra.first) < 2 * n_parts:
        # Too few to tell a change of the forces from chance.
        return np.zeros(len(spectra.first), dtype=np.int64)
    part = np.arange(len(spectra.first)) * n_parts // len(spectra.first)
    by_chance = np.median([_halves_apart(spectra, part == each) for each in range(n_parts)])
    groups = [[each] for each in range(n_parts)]
    direction = [spectra.direction(np.flatnonzero(part == each)) for each in range(n_parts)]
    while len(groups) > 1:
        pairs = list(combinations(range(len(groups)), 2))
        apart = [_apart(direction[one], direction[other]) for one, other in pairs]
        nearest = int(np.argmin(apart))
        if apart[nearest] > METHOD.transfer_differs * by_chance:
            break
        one, other = pairs[nearest]
        groups[one] += groups.pop(other)
        direction.pop(other)
        direction[one] = spectra.direction(np.flatnonzero(np.isin(part, groups[one])))
    of_part = np.full(n_parts, -1)
    for number, group in enumerate(group for group in groups if len(group) > 1):
        of_part[group] = number
    return np.asarray(of_part[part])


def _halves_apart(spectra: Spectra, chosen: NDArray[np.bool_]) -> float:
    """Return how far the directions of every other segment are from those of the rest."""
    segments = np.flatnonzero(chosen)
    return _apart(spectra.direction(segments[::2]), spectra.direction(segments[1::2]))


def _apart(one: Complex, other: Complex) -> float:
    """Return 1 - MAC of directions, a median over the lines."""
    return float(np.median(1.0 - np.abs(np.sum(one.conj() * other, axis=1)) ** 2))


def poles_of_conditions(
    angle: Real, directions: Sequence[Complex], orders: Sequence[int]
) -> RawPoles:
    """Return the poles of the inverse differences of transmissibilities.

    Parameters
    ----------
    angle : (n_lines,) array [rad]
        Frequency times the sampling interval.
    directions : sequence of (n_lines, n_channels) complex array
        Of the response under each condition, times anything at each line.
    orders : sequence of int
        Orders of the polynomial.
    """
    strength = np.min([np.mean(np.abs(each) ** 2, axis=0) for each in directions], axis=0)
    reference = int(np.argmax(strength))
    ratios = [np.delete(each / each[:, [reference]], reference, axis=1) for each in directions]
    inverse = np.concatenate([1.0 / (a - b) for a, b in combinations(ratios, 2)], axis=1)
    # Ratios that differ much say more than those that differ little.
    inverse /= np.median(np.abs(inverse), axis=0) ** 2
    fitted = NormalEquations(HalfSpectra(angle, inverse[:, :, None], 0.0), orders[-1])
    order_of, value, shape = [], [], []
    for order in orders:
        raw = fitted.solve(order)
        near = np.abs(angle - np.angle(raw.eigenvalue)[:, None]).argmin(axis=1)
        order_of.append(np.full(len(raw.eigenvalue), order))
        value.append(raw.eigenvalue)
        shape.append(directions[0][near].T)
    return RawPoles(np.concatenate(order_of), np.concatenate(value), np.concatenate(shape, axis=1))
