"""Fit a model's numbers to a few published natural frequencies, and say what they leave open."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from modal_core.errors import ModelError
from modal_core.work.progress import Progress
from structural_model.flexible_joint_model import FlexibleJointModel

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class FreeParameter:
    """One number to fit, standing for one or more numbers of the model.

    Parameters
    ----------
    name : str
        What to call it.
    targets : tuple of str
        Names in ``model.parameters()`` that take its value.
    low, high : float
        Range it may take, both positive; the fit works on its logarithm.
    source : str
        Where the range comes from.
    """

    name: str
    targets: tuple[str, ...]
    low: float
    high: float
    source: str = ''


@dataclass(frozen=True, slots=True)
class PoseTarget:
    """Published frequencies at one pose.

    Parameters
    ----------
    pose : str
        Named pose of the robot.
    frequency_hz : tuple of float [Hz]
        Rising.
    candidates : tuple of tuple of int
        Which model modes (counted from 0) they may be; every candidate is tried.
    lowest_hz : float [Hz]
        No model mode ought to lie below.
    """

    pose: str
    frequency_hz: tuple[float, ...]
    candidates: tuple[tuple[int, ...], ...]
    lowest_hz: float = 0.0


@dataclass(frozen=True, slots=True)
class FitProblem:
    """What to fit and how.

    Parameters
    ----------
    parameters : tuple of FreeParameter
        Free numbers.
    targets : tuple of PoseTarget
        What to match.
    frequency_sd : float
        Relative standard deviation of a published frequency.
    starts : int
        Random starts for each assignment.
    """

    parameters: tuple[FreeParameter, ...]
    targets: tuple[PoseTarget, ...]
    frequency_sd: float = 0.004
    starts: int = 2


@dataclass(frozen=True, slots=True)
class TriedAssignment:
    """One way of saying which model modes were published.

    Parameters
    ----------
    modes : tuple of tuple of int
        For each target.
    cost : float
        The least reached, before polishing.
    """

    modes: tuple[tuple[int, ...], ...]
    cost: float


@dataclass(frozen=True)
class FitResult:
    """The best fit.

    Parameters
    ----------
    model : FlexibleJointModel
        With the fitted numbers.
    values : dict of str to float
        Free parameters.
    modes : dict of str to tuple of int
        Which model modes the published frequencies are.
    frequency_hz : dict of str to (n_modes,) array [Hz]
        All frequencies of the fitted model.
    residual : dict of str to tuple of float
        Relative deviations.
    determined : dict of str to float
        1 - posterior sd / prior sd: 0 for what the frequencies say nothing about.
    rank : int
        Number of parameter combinations the frequencies determine better than the ranges do.
    cost : float
        Half the sum of squares, ranges included.
    tried : tuple of TriedAssignment
        Every assignment with the best cost it reached, cheapest first.
    """

    model: FlexibleJointModel
    values: dict[str, float]
    modes: dict[str, tuple[int, ...]]
    frequency_hz: dict[str, Array]
    residual: dict[str, tuple[float, ...]]
    determined: dict[str, float]
    rank: int
    cost: float
    tried: tuple[TriedAssignment, ...]


class FrequencyFit:
    """Maximum a posteriori fit of frequencies, over every assignment of modes.

    Parameters
    ----------
    model : FlexibleJointModel
        Where to start from.
    problem : FitProblem
        What to fit.
    """

    def __init__(self, model: FlexibleJointModel, problem: FitProblem) -> None:
        known = model.parameters()
        for parameter in problem.parameters:
            if not 0.0 < parameter.low < parameter.high:
                raise ModelError(
                    'range of a fit parameter is empty',
                    where=parameter.name,
                    found=(parameter.low, parameter.high),
                )
            for name in parameter.targets:
                if name not in known:
                    raise ModelError('unknown model parameter', where=parameter.name, found=name)
        self.model = model
        self.problem = problem
        self.low = np.log([parameter.low for parameter in problem.parameters])
        self.high = np.log([parameter.high for parameter in problem.parameters])
        self.centre, self.half = (self.low + self.high) / 2.0, (self.high - self.low) / 2.0
        self.poses = {target.pose: model.pose(target.pose) for target in problem.targets}

    def changed(self, logs: Array) -> FlexibleJointModel:
        """Return the model with these logarithms of the parameters."""
        values = {
            name: float(value)
            for parameter, value in zip(self.problem.parameters, np.exp(logs), strict=True)
            for name in parameter.targets
        }
        return self.model.with_parameters(values)

    def frequencies(self, logs: Array) -> dict[str, Array]:
        """Return all frequencies at the poses [Hz]."""
        model = self.changed(logs)
        return {name: model.modes(q).frequency_hz for name, q in self.poses.items()}

    def residuals(self, logs: Array, modes: Sequence[tuple[int, ...]]) -> Array:
        """Return deviations in standard deviations: frequencies, floors, ranges."""
        found = self.frequencies(logs)
        rows = []
        for target, picked in zip(self.problem.targets, modes, strict=True):
            frequency = found[target.pose]
            wanted = np.array(target.frequency_hz)
            rows.extend(np.log(frequency[list(picked)] / wanted) / self.problem.frequency_sd)
            if target.lowest_hz > 0.0:
                gap = np.log(target.lowest_hz / frequency[0])
                rows.append(max(0.0, gap) / (5.0 * self.problem.frequency_sd))
        return np.concatenate([rows, (logs - self.centre) / self.half])

    def run(self, rng: np.random.Generator, progress: Progress | None = None) -> FitResult:
        """Fit from random starts for every assignment and return the best.

        Parameters
        ----------
        rng : numpy.random.Generator
            Draws the starts.
        progress : callable, optional
            Told the share done, 0..1.
        """
        assignments = list(product(*(target.candidates for target in self.problem.targets)))
        tries = [modes for modes in assignments for _ in range(self.problem.starts)]
        best_cost, best_logs, best_modes = np.inf, self.centre, assignments[0]
        least = dict.fromkeys(assignments, np.inf)
        for number, modes in enumerate(tries):
            spread = rng.normal(size=len(self.centre)) * 0.3 * self.half
            start = np.clip(self.centre + spread, self.low + 1e-9, self.high - 1e-9)
            found = self._solve(start, modes, 40)
            least[modes] = min(least[modes], float(found.cost))
            if found.cost < best_cost:
                best_cost, best_logs, best_modes = found.cost, found.x, modes
            if progress is not None:
                progress((number + 1) / len(tries))
        polished = self._solve(best_logs, best_modes, 400)
        tried = sorted(least.items(), key=lambda item: item[1])
        return self._result(
            polished.x,
            best_modes,
            float(polished.cost),
            tuple(TriedAssignment(modes, cost) for modes, cost in tried),
        )

    def _solve(self, start: Array, modes: Sequence[tuple[int, ...]], evaluations: int):  # type: ignore[no-untyped-def]
        return least_squares(
            self.residuals,
            start,
            bounds=(self.low, self.high),
            args=(modes,),
            x_scale=self.half,
            max_nfev=evaluations,
        )

    def _result(
        self,
        logs: Array,
        modes: Sequence[tuple[int, ...]],
        cost: float,
        tried: tuple[TriedAssignment, ...],
    ) -> FitResult:
        frequency = self.frequencies(logs)
        slope = self._slope(logs, modes) * self.half / self.problem.frequency_sd
        information = np.eye(len(logs)) + slope.T @ slope
        kept = np.sqrt(np.diag(np.linalg.inv(information)))
        names = [parameter.name for parameter in self.problem.parameters]
        return FitResult(
            model=self.changed(logs),
            values=dict(zip(names, (float(value) for value in np.exp(logs)), strict=True)),
            modes={
                target.pose: tuple(picked)
                for target, picked in zip(self.problem.targets, modes, strict=True)
            },
            frequency_hz=frequency,
            residual={
                target.pose: tuple(
                    float(value)
                    for value in frequency[target.pose][list(picked)]
                    / np.array(target.frequency_hz)
                    - 1.0
                )
                for target, picked in zip(self.problem.targets, modes, strict=True)
            },
            determined=dict(zip(names, (float(1.0 - sd) for sd in kept), strict=True)),
            rank=int(np.sum(np.linalg.svd(slope, compute_uv=False) > 1.0)),
            cost=cost,
            tried=tried,
        )

    def _slope(self, logs: Array, modes: Sequence[tuple[int, ...]]) -> Array:
        """Return the derivative of the picked log frequencies, (n_frequencies, n_parameters)."""

        def picked(at: Array) -> Array:
            found: Mapping[str, Array] = self.frequencies(at)
            pairs = zip(self.problem.targets, modes, strict=True)
            rows = [found[target.pose][list(chosen)] for target, chosen in pairs]
            return np.asarray(np.log(np.concatenate(rows)))

        step = 1e-4
        columns = [
            (picked(logs + step * unit) - picked(logs - step * unit)) / (2.0 * step)
            for unit in np.eye(len(logs))
        ]
        return np.column_stack(columns)
