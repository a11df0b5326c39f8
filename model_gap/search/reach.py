"""How much of a gap a force at one place could explain at best, whatever its law.

A change of the arm along one coordinate w acts like a force w·f(ω): a stiffer spring, friction,
play, a swinging mass.  What no f explains, no such effect does.
"""

from collections.abc import Mapping, Sequence
import dataclasses
from dataclasses import dataclass
import logging

import numpy as np
from numpy.typing import NDArray

from model_gap.campaign import Complex
from model_gap.cell import CellModel, force_vector
from model_gap.effects import Effect
from model_gap.fit import FIT
from model_gap.hypothesis import Hypothesis
from model_gap.predict import Predictor

Array = NDArray[np.float64]
log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Shares:
    """What free forces at single places would account for.

    Parameters
    ----------
    explained : dict of str to float
        Σ|part of the residual|²/σ² per place; the parts overlap.
    total : float
        Of the whole residual.
    count, free : int
        Complex data, and those a free force uses up: one per bin and record.
    """

    explained: dict[str, float]
    total: float
    count: int
    free: int

    def gain(self, place: str) -> float:
        """Return the rise of log evidence; noise alone makes none."""
        left = max(self.total - self.explained[place], 1e-9 * self.total)
        chi = left / max(self.count - self.free, 1)
        return float(FIT.effective_data * np.log(self.total / self.count / chi))


def joint_shares(hypothesis: Hypothesis, predictor: Predictor) -> Shares:
    """Return what a free torque in each joint (``marked`` name) would account for."""
    cell = hypothesis.cell()
    probes = {place: (cell, place) for place in hypothesis.scene.joint_marks}
    return shares(hypothesis, predictor, probes)


def shares(
    hypothesis: Hypothesis, predictor: Predictor, probes: Mapping[str, tuple[CellModel, str]]
) -> Shares:
    """Project the residual of every bin on what a force at each place makes the sensors read.

    Parameters
    ----------
    hypothesis : Hypothesis
        Its residual counts.
    predictor : Predictor
        Of the records.
    probes : dict of str to (CellModel, str)
        Place to an arm and a degree of freedom or joint of it.
    """
    predicted = predictor.predict(hypothesis.cell())
    rest = [
        item.measured - reading for item, reading in zip(predictor.records, predicted, strict=True)
    ]
    explained = dict.fromkeys(probes, 0.0)
    for cell in {id(cell): cell for cell, _ in probes.values()}.values():
        systems = predictor.systems(cell.spec, cell.channels)
        model = dataclasses.replace(predictor.model, spec=cell.spec)
        for place in [name for name, (own, _) in probes.items() if own is cell]:
            force = force_vector(model, probes[place][1], systems[0].dof_names)
            for number, item in enumerate(predictor.records):
                omega = item.omega[:, 1]
                response = systems[predictor.groups[number]].response(omega, force)
                response = cell.seen(omega, response)
                free, weight = free_force(rest[number], response, item.noise_power)
                explained[place] += float(np.sum(weight * np.abs(free) ** 2))
    return Shares(
        explained,
        sum(
            float(np.sum(item.squares(part)))
            for part, item in zip(rest, predictor.records, strict=True)
        ),
        sum(item.count for item in predictor.records),
        sum(part.shape[1] for part in rest),
    )


def free_force(rest: Complex, response: Complex, noise_power: Array) -> tuple[Complex, Array]:
    """Return the force that explains most of a residual, bin by bin, and its weight, (n_bins,).

    Parameters
    ----------
    rest : (n_channels, n_bins) complex array
        The residual.
    response : (n_channels, n_bins) complex array
        To a unit of the force.
    noise_power : (n_channels, n_bins) array
        Of the residual; the weight is one over the force's noise power.
    """
    weight = np.maximum(np.sum(np.abs(response) ** 2 / noise_power, axis=0), 1e-300)
    force = np.sum(response.conj() * rest / noise_power, axis=0) / weight
    return force, np.asarray(weight)


def within_reach(
    candidates: Sequence[Effect],
    hypotheses: Sequence[Hypothesis],
    predictor: Predictor,
    least_gain: float,
    least_share: float,
) -> list[Effect]:
    """Return the candidates whose place could explain something; others need no trial.

    Parameters
    ----------
    candidates : sequence of Effect
        Those that do not act along one coordinate stay.
    hypotheses : sequence of Hypothesis
        What they would be added to; the residual of one is enough.
    predictor : Predictor
        Of the records.
    least_gain : float
        Of log evidence.
    least_share : float
        Of the gain of the best place.
    """
    kept: set[int] = set()
    most: dict[int, tuple[float, float]] = {}
    for hypothesis in hypotheses:
        cell = hypothesis.cell()
        probes: dict[str, tuple[CellModel, str]] = {}
        place_of: dict[int, str] = {}
        for number, effect in enumerate(candidates):
            probe = effect.probe(cell, hypothesis.scene)
            if probe is not None:
                place_of[number] = probe[1]
                probes.setdefault(probe[1], probe)
        if not probes:
            return list(candidates)
        found = shares(hypothesis, predictor, probes)
        gains = {place: found.gain(place) for place in probes}
        least = max(least_gain, least_share * max(gains.values()))
        most |= {number: (gains[place], least) for number, place in place_of.items()}
        kept |= {
            number
            for number in range(len(candidates))
            if number not in place_of or gains[place_of[number]] >= least
        }
    for number, effect in enumerate(candidates):
        if number not in kept:
            log.debug(
                '%r not tried: any force at its place gains %.3g of log evidence, %.3g needed',
                effect,
                *most[number],
            )
    return [candidates[number] for number in sorted(kept)]
