"""How much of a gap torques in one joint could explain at best, whatever their law."""

import dataclasses
from dataclasses import dataclass

import numpy as np

from model_gap.fit import EFFECTIVE_DATA
from model_gap.hypothesis import Hypothesis
from model_gap.joint_vector import joint_vector
from model_gap.predict import Predictor


@dataclass(frozen=True)
class JointShares:
    """What free torques in single joints would account for.

    Parameters
    ----------
    explained : dict of str to float
        Σ|part of the residual|²/σ² per joint (``marked`` name); the parts overlap.
    total : float
        Of the whole residual.
    count, free : int
        Complex data, and those a free torque uses up: one per bin and record.
    """

    explained: dict[str, float]
    total: float
    count: int
    free: int


def joint_shares(hypothesis: Hypothesis, predictor: Predictor) -> JointShares:
    """Project the residual of every bin on what a torque in each joint makes the sensors read.

    Parameters
    ----------
    hypothesis : Hypothesis
        Its residual counts.
    predictor : Predictor
        Of the records.
    """
    setup = hypothesis.setup()
    systems = predictor.systems(setup.spec, setup.channels)
    predicted = predictor.predict(setup)
    model = dataclasses.replace(predictor.model, spec=setup.spec)
    explained = dict.fromkeys(hypothesis.scene.joint_marks, 0.0)
    total, count, bins = 0.0, 0, 0
    for item, group, reading in zip(predictor.records, predictor.groups, predicted, strict=True):
        system, omega = systems[group], item.omega[:, 1]
        scale = 1.0 / np.sqrt(item.noise_power)[:, None]
        rest = (item.measured - reading) * scale
        total += float(np.sum(np.abs(rest) ** 2))
        count += rest.size
        bins += rest.shape[1]
        transfer = system.transfer(omega)
        for place in explained:
            force = joint_vector(model, place, system.dof_names)
            response = np.einsum('cnb,n->cb', transfer, force)
            for step in setup.outputs:
                response = step(omega, response)
            response = response * scale
            size = np.maximum(np.sum(np.abs(response) ** 2, axis=0), 1e-300)
            part = np.abs(np.sum(response.conj() * rest, axis=0)) ** 2 / size
            explained[place] += float(part.sum())
    return JointShares(explained, total, count, bins)


def joint_reach(hypothesis: Hypothesis, predictor: Predictor) -> dict[str, float]:
    """Return the largest rise of log evidence by a torque in each joint, tolerances held.

    Noise alone reaches nothing: the data a free torque uses up are not counted.
    """
    found = joint_shares(hypothesis, predictor)
    before = found.total / found.count
    reach = {}
    for place, part in found.explained.items():
        left = max(found.total - part, 1e-9 * found.total) / (found.count - found.free)
        reach[place] = float(EFFECTIVE_DATA * np.log(before / left))
    return reach
