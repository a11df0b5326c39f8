"""Motion in step with the force of a mode, which turns its shape where the model lacks it.

A joint that shakes the arm moves its own sensors.  Over one band such motion is the force itself
along a fixed direction; left out, it turns the shape: at the peak it is what the mode lacks,
beside it what the mode has too much of.

References
----------
Rao (1948), doi:10.1017/S0305004100023987 (score test); Ewins (2000), Modal Testing, 2nd ed.,
section 4.4 (residuals).
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from oma_identifier.likelihood import BandData, BandIndex, BandModel, expected_spectra, forced_gain
from oma_identifier.refinement.thresholds import REFINEMENT


def moves_with_force(data: BandData, model: BandModel, position: BandIndex) -> bool:
    """Tell whether a band holds motion in step with the force of one mode that its model lacks.

    The derivative of the log-likelihood by cross spectra of such motion with the force, freed of
    what a turn of the shape would do, over its deviation.
    """
    gain = forced_gain(data, model)
    amplitude = model.shapes * gain[:, None, :]
    covariance = expected_spectra(model, amplitude)
    precision = np.linalg.inv(covariance)
    own, turn = amplitude[:, :, position], gain[:, position]
    pulled = np.einsum('kcd,kd->kc', precision, own)
    left = np.einsum('kcd,kd->kc', data.periodogram - covariance, pulled)
    weight = data.n_averaged * np.einsum('kc,kc->k', own.conj(), pulled).real
    turned = (weight @ turn.conj()) / (weight @ np.abs(turn) ** 2)
    weight *= np.abs(1.0 - turned * turn) ** 2
    score = np.einsum('k,kcd,kd->c', data.n_averaged, precision, left)
    return _chance(score, np.tensordot(weight, precision, axes=1)) < REFINEMENT.force_chance


def in_step(model: BandModel, position: BandIndex, added: Sequence[BandIndex]) -> bool:
    """Tell whether one force may drive a mode and one that the fit of its band had to add.

    Then nothing tells the added mode from motion that this force causes itself: a pole above the
    band took such motion for its own, and the shapes of the others turned.
    """
    others = [at for at in added if at != position]
    power = np.abs(np.diag(model.force))
    square = np.abs(model.force[position, others]) ** 2
    return bool(np.any(square > REFINEMENT.one_force * power[position] * power[others]))


def shares_force(data: BandData, model: BandModel, position: BandIndex) -> bool:
    """Tell whether one force may drive a mode and one beside its band that is seen there.

    Then what modes nobody found do there is in step with the mode as well, and bends its bell to
    one side; a model of as many forces as modes describes that, with another frequency.
    """
    power = np.abs(np.diag(model.force))
    each = np.abs(forced_gain(data, model)) ** 2 * power
    seen = np.mean(each, axis=0) * (1.0 / model.noise @ np.abs(model.shapes) ** 2) > 1.0
    seen[: model.n_free] = False
    square = np.abs(model.force[position]) ** 2
    return bool(np.any(square[seen] > REFINEMENT.one_force * power[position] * power[seen]))


def _chance(score: NDArray[np.complex128], metric: NDArray[np.complex128]) -> float:
    try:
        rise = float(np.vdot(score, np.linalg.solve(metric, score)).real)
    except np.linalg.LinAlgError:  # a model with next to no power in some direction
        return 0.0
    return float(chi2.sf(2.0 * rise, 2 * len(score)))
