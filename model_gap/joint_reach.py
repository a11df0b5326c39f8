"""How much of a gap torques in one joint could explain at best, whatever their law."""

import dataclasses

import numpy as np

from model_gap.fit import EFFECTIVE_DATA
from model_gap.hypothesis import Hypothesis
from model_gap.joint_vector import joint_vector
from model_gap.predict import Predictor


def joint_reach(hypothesis: Hypothesis, predictor: Predictor) -> dict[str, float]:
    """Return the largest rise of log evidence per joint (``marked`` name), tolerances held.

    In every bin of every record the residual is projected on what a torque in the joint would
    make the sensors read.  Noise alone reaches nothing: the data this takes up are not counted.

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
    places = hypothesis.scene.joint_marks
    explained = dict.fromkeys(places, 0.0)
    total, count, bins = 0.0, 0, 0
    for item, group, reading in zip(predictor.records, predictor.groups, predicted, strict=True):
        system, omega = systems[group], item.omega[:, 1]
        scale = 1.0 / np.sqrt(item.noise_power)[:, None]
        rest = (item.measured - reading) * scale
        total += float(np.sum(np.abs(rest) ** 2))
        count += rest.size
        bins += rest.shape[1]
        transfer = system.transfer(omega)
        for place in places:
            force = joint_vector(model, place, system.dof_names)
            response = np.einsum('cnb,n->cb', transfer, force)
            for step in setup.outputs:
                response = step(omega, response)
            response = response * scale
            size = np.maximum(np.sum(np.abs(response) ** 2, axis=0), 1e-300)
            explained[place] += float(
                np.sum(np.abs(np.sum(response.conj() * rest, axis=0)) ** 2 / size)
            )
    left = {
        place: max(total - part, 1e-9 * total) / (count - bins)
        for place, part in explained.items()
    }
    return {
        place: float(EFFECTIVE_DATA * np.log(total / count / chi)) for place, chi in left.items()
    }
