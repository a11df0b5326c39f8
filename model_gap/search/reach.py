"""How much of a gap a force at one place could explain at best, whatever its law.

A change of the arm along one coordinate w acts like a force w·f(ω): a stiffer spring, friction,
play, a swinging mass.  What no f explains, no such effect does.  Where the direction of w is to be
fitted, it is forces along all axes of the place that bound it: along none of them alone need there
be much.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
import dataclasses
from dataclasses import dataclass
import logging
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from model_gap.campaign import Complex
from model_gap.cell import CellModel, force_vector
from model_gap.effects import Effect
from model_gap.fit import FIT
from model_gap.hypothesis import Hypothesis
from model_gap.predict import Predictor

Array = NDArray[np.float64]
# An arm, and a degree of freedom or joint of it.
Probe = tuple[CellModel, str]
log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Shares:
    """What free forces at single places would account for.

    Parameters
    ----------
    explained : dict of str to float
        Σ|part of the residual|²/σ² per place; the parts overlap.
    forces : dict of str to int
        At every place, in each bin.
    total : float
        Of the whole residual.
    count, free : int
        Complex data, and those a free force uses up: one per bin and record.
    """

    explained: dict[str, float]
    forces: dict[str, int]
    total: float
    count: int
    free: int

    def gain(self, place: str) -> float:
        """Return the rise of log evidence; noise alone makes none."""
        left = max(self.total - self.explained[place], 1e-9 * self.total)
        chi = left / max(self.count - self.free * self.forces[place], 1)
        return float(FIT.effective_data * np.log(self.total / self.count / chi))


def joint_shares(hypothesis: Hypothesis, predictor: Predictor) -> Shares:
    """Return what a free torque in each joint (``marked`` name) would account for."""
    cell = hypothesis.cell()
    probes = {place: (cell, place) for place in hypothesis.scene.joint_marks}
    return shares(hypothesis, predictor, probes)


def shares(
    hypothesis: Hypothesis,
    predictor: Predictor,
    probes: Mapping[str, Probe],
    together: Mapping[str, Sequence[str]] = MappingProxyType({}),
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
    together : dict of str to sequence of str
        Further places, each with those whose forces act there together.
    """
    predicted = predictor.predict(hypothesis.cell())
    rest = [
        item.measured - reading for item, reading in zip(predictor.records, predicted, strict=True)
    ]
    places = {**{name: [name] for name in probes}, **together}
    explained = dict.fromkeys(places, 0.0)
    for part, item, seen in zip(
        rest, predictor.records, _responses(probes, predictor), strict=True
    ):
        for place, names in places.items():
            explained[place] += _explained(part, [seen[name] for name in names], item.noise_power)
    return Shares(
        explained,
        {place: len(names) for place, names in places.items()},
        sum(
            float(np.sum(item.squares(part)))
            for part, item in zip(rest, predictor.records, strict=True)
        ),
        sum(item.count for item in predictor.records),
        sum(part.shape[1] for part in rest),
    )


def _responses(probes: Mapping[str, Probe], predictor: Predictor) -> Iterator[dict[str, Complex]]:
    """Yield, of every record, what a unit force at each place makes the sensors read."""
    cells = {id(cell): cell for cell, _ in probes.values()}
    systems = {at: predictor.systems(cell.spec, cell.channels) for at, cell in cells.items()}
    forces = {
        place: force_vector(
            dataclasses.replace(predictor.model, spec=cell.spec),
            where,
            systems[id(cell)][0].dof_names,
        )
        for place, (cell, where) in probes.items()
    }
    for item, group in zip(predictor.records, predictor.groups, strict=True):
        omega = item.omega[:, 1]
        yield {
            place: cell.seen(omega, systems[id(cell)][group].response(omega, forces[place]))
            for place, (cell, _) in probes.items()
        }


def _explained(rest: Complex, responses: Sequence[Complex], noise_power: Array) -> float:
    """Return what free forces take away of a residual, bin by bin."""
    if len(responses) == 1:
        free, weight = free_force(rest, responses[0], noise_power)
        return float(np.sum(weight * np.abs(free) ** 2))
    root = np.sqrt(noise_power)
    columns = np.stack([item / root for item in responses], axis=-1).transpose(1, 0, 2)
    basis, size, _ = np.linalg.svd(columns, full_matrices=False)
    pull = np.einsum('fck,cf->fk', basis.conj(), rest / root)
    return float(np.sum(np.abs(pull[size > 1e-9 * size[:, :1]]) ** 2))


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
        Those that do not act along one coordinate stay; one whose direction is to be fitted stays
        where forces along all its axes together explain enough, unless another axis does more.
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
        probes: dict[str, Probe] = {}
        place_of: dict[int, str] = {}
        for number, effect in enumerate(candidates):
            probe = effect.probe(cell, hypothesis.scene)
            if probe is not None:
                place_of[number] = probe[1]
                probes.setdefault(probe[1], probe)
        if not probes:
            return list(candidates)
        axes = _axes(candidates, place_of)
        found = shares(hypothesis, predictor, probes, axes)
        gains = {place: found.gain(place) for place in (*probes, *axes)}
        least = _least(gains, probes, least_gain, least_share)
        most |= {number: (gains[place], least) for number, place in place_of.items()}
        kept |= {
            number
            for number in range(len(candidates))
            if number not in place_of or gains[place_of[number]] >= least
        }
        # Like is compared with like: forces along all axes explain more than one, at any place.
        least = _least(gains, axes, least_gain, least_share)
        for number, place in place_of.items():
            together = _any_axis(candidates[number])
            near = together in axes and gains[together] >= least
            if near and gains[place] >= least_share * max(gains[name] for name in axes[together]):
                kept.add(number)
    for number, effect in enumerate(candidates):
        if number not in kept:
            log.debug(
                '%r not tried: any force at its place gains %.3g of log evidence, %.3g needed',
                effect,
                *most[number],
            )
    return [candidates[number] for number in sorted(kept)]


def _least(
    gains: Mapping[str, float], places: Iterable[str], least_gain: float, least_share: float
) -> float:
    return max(least_gain, least_share * max((gains[place] for place in places), default=0.0))


def _any_axis(effect: Effect) -> str:
    """Return the name of all axes of an effect's place together."""
    return f'{effect.type} along any axis of {effect.location}'


def _axes(candidates: Sequence[Effect], place_of: Mapping[int, str]) -> dict[str, list[str]]:
    """Return the axes of every place at which the direction is one of an effect's numbers."""
    found: dict[str, dict[str, None]] = {}
    for number, place in place_of.items():
        if candidates[number].turns:
            found.setdefault(_any_axis(candidates[number]), {})[place] = None
    return {place: list(names) for place, names in found.items() if len(names) > 1}
