"""Methods that solve every frequency band afresh from conditioned samples."""

from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
import math

import numpy as np
from numpy.typing import NDArray

from modal_core.samples import Samples
from oma_identifier.covariance import Band, BandConditioner, plan_bands
from oma_identifier.identify_bands import band_source, taken
from oma_identifier.methods.jackknife import jackknife, stretches
from oma_identifier.methods.solver import Solver
from oma_identifier.methods.thresholds import METHOD
from oma_identifier.motion import never, PeakTest
from oma_identifier.selection import (
    BandPoles,
    Identified,
    join_bands,
    line_evidence,
    select_in_band,
    SELECTION,
    without_explained,
)
from oma_identifier.settings import IdentificationSettings
from oma_identifier.spectra import line_at, peaks_hz, SpectralPeaks
from oma_identifier.subspace import deviation_from, PoleDeviation, RawPoles

Real = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Problem:
    """One band, ready to be solved.

    Parameters
    ----------
    rows : (n_samples, n_columns) array
        Conditioned responses, then inputs; each of unit root mean square.
    n_channels : int
        Columns that are responses.
    band : Band
        Which band.
    orders : range
        Even model orders.
    scale : (n_channels,) array [m/s²]
        Root mean square of the responses before.
    duration_s : float [s]
        Length of the record, as far as it counts.
    """

    rows: Real
    n_channels: int
    band: Band
    orders: range
    scale: Real
    duration_s: float


@dataclass(frozen=True, slots=True)
class JackknifedBand:
    """Poles of one band whose scatter the jackknife of blocks tells.

    Parameters
    ----------
    problem : Problem
        The band.
    solver : Solver
        Solves it at any order, and without stretches.
    poles : BandPoles
        All orders.
    trials : sequence of float
        Which members of a cluster are compared, as shares of it by model order.
    """

    problem: Problem
    solver: Solver
    poles: BandPoles
    trials: Sequence[float]

    @classmethod
    def of(cls, problem: Problem, solver: Solver, trials: Sequence[float]) -> 'JackknifedBand':
        """Solve all orders."""
        raw = solver.solve(problem.orders)
        rate_hz = problem.band.sample_rate_hz
        pole = np.asarray(np.log(raw.eigenvalue) * rate_hz, dtype=complex)
        poles = BandPoles(raw.model_order, raw.eigenvalue, pole, raw.shape)
        return cls(problem, solver, poles, trials)

    @property
    def band(self) -> Band:
        """Which band."""
        return self.problem.band

    @property
    def n_orders(self) -> int:
        """How many model orders were solved."""
        return len(np.unique(self.poles.model_order))

    @property
    def scale(self) -> Real:
        """Root mean square of the channels in the band, (n_channels,) array [m/s²]."""
        return self.problem.scale

    @property
    def duration_s(self) -> float:
        """Length of the record, as far as it counts [s]."""
        return self.problem.duration_s

    @property
    def least_members(self) -> int:
        """Model orders over which a mode repeats: more than half, spurious poles over fewer."""
        return max(3, math.ceil(METHOD.least_share * self.n_orders))

    @property
    def is_blind(self) -> bool:
        """Whether no force is known, so that the limit of scatter under random forces holds."""
        return bool(self.problem.rows.shape[1] == self.problem.n_channels)

    def influence(self, rows: NDArray[np.int64]) -> NDArray[np.complex128]:
        """Return what each block of time does to the poles in these rows.

        Returns
        -------
        (n_blocks, n_rows) complex array [rad/s]
            Of NaN for a pole that is not found again without some of the blocks.
        """
        responses = self.problem.rows[:, : self.problem.n_channels]
        order, shape = self.poles.model_order[rows], self.poles.shape[:, rows]
        pole = np.log(self.poles.eigenvalue[rows])
        found = self.solver.without(stretches(len(responses)), order, pole, shape)
        series = jackknife(responses, found, pole, shape)
        return np.asarray(series * self.band.sample_rate_hz)

    def deviation(self, series: NDArray[np.complex128], pole: complex) -> PoleDeviation:
        """Return the standard deviations of a pole; blocks left out in turn are independent."""
        return deviation_from(series, pole, math.inf)


class BandedMethod(ABC):
    """A parametric method that solves band after band."""

    name: str
    needs_inputs = False
    raises_order = False
    """Whether a crowded band is solved at higher orders; methods that choose theirs do not."""
    trials: Sequence[float] = SELECTION.trials

    @abstractmethod
    def prepare(self, problem: Problem, settings: IdentificationSettings) -> Solver:
        """Sum what the method needs of the rows, once per band; what it returns solves."""

    def counted_s(self, samples: Samples, settings: IdentificationSettings) -> float:
        """Return the length of samples of equal weight that tell as much [s]."""
        return samples.duration_s

    def weighted(self, problem: Problem, settings: IdentificationSettings) -> Problem:
        """Return a band with its samples by their weights."""
        return problem

    def identify(
        self,
        samples: Samples,
        settings: IdentificationSettings,
        inputs: Real | None = None,
        explains: PeakTest = never,
    ) -> Identified:
        """Identify the modes of one stretch."""
        peaks = SpectralPeaks(samples)
        known = inputs if self.needs_inputs else None
        counted_s = self.counted_s(samples, settings)
        problems = (
            self.weighted(problem, settings)
            for problem in _problems(samples, settings, known, counted_s, self.raises_order)
        )
        selections = [
            select_in_band(
                JackknifedBand.of(problem, self.prepare(problem, settings), self.trials),
                settings,
                peaks,
            )
            for problem in problems
        ]
        found = join_bands(
            selections,
            samples.channels,
            self.name,
            partial(line_at, samples),
            explains,
            peaks_hz(samples),
        )
        return without_explained(found, line_evidence(samples, found))


def no_raw_poles(n_channels: int) -> RawPoles:
    """Return that a band has none."""
    nothing = np.zeros((n_channels, 0), dtype=complex)
    return RawPoles(np.zeros(0, dtype=np.int64), np.zeros(0, dtype=complex), nothing)


def _problems(
    samples: Samples,
    settings: IdentificationSettings,
    inputs: Real | None,
    counted_s: float,
    raises_order: bool,
) -> Iterator[Problem]:
    """Condition every band that has samples enough."""
    data = samples.acceleration
    if inputs is not None:
        data = np.concatenate([data, inputs], axis=1)
    n_channels, parts = len(samples.channels), taken([samples])
    for band in plan_bands(samples.sample_rate_hz, counted_s, settings):
        rows = BandConditioner(band).condition(data)
        if len(rows) < 10 * METHOD.samples_per_order:
            continue
        scale = rows.std(axis=0)
        rows = np.divide(rows, scale, out=np.zeros_like(rows), where=scale > 0.0)
        if inputs is not None:
            rows[:, n_channels:][
                :, scale[n_channels:] <= METHOD.still * inputs.std(axis=0).max()
            ] = 0.0
        seconds = min(counted_s, len(rows) / band.sample_rate_hz)
        source = band_source(band, parts, counted_s, settings) if raises_order else None
        wanted = settings.max_order if source is None else source.max_order
        highest = min(wanted, round(seconds * band.sample_rate_hz) // METHOD.samples_per_order)
        # Twice the order is for many modes: half as high there are fewer, broader ones.
        lowest = settings.max_order if highest > settings.max_order else settings.min_order
        orders = range(lowest + lowest % 2, highest + 1, 2)
        yield Problem(rows, n_channels, band, orders, scale[:n_channels], seconds)
