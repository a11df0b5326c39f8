"""Whether a calibration stands for encoders that read wrong, where gravity leaves them open.

Mounts, places and centres of mass that are all turned alike look as an encoder that is off does.
From there a fit does not find back: it is made once more from the beginning with the encoders as
free as gravity leaves them.  What explains the recordings nearly as well is another explanation,
and deviations of what is calibrated contain the way between both.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
import math

import numpy as np
from numpy.typing import NDArray

from model_gap.cell import encoder_nuisance, encoder_of
from model_gap.fit import Fit, fit
from model_gap.hypothesis import Hypothesis
from model_gap.named_at_rest import CLEARLY
from model_gap.predict import Predictor
from model_gap.search import EVIDENCE_BETWEEN

Array = NDArray[np.float64]
# Of a tolerance, in deviations: where all moved less nothing is sought, which saves the fit.
# Chosen, not measured; of seven healthy arms of an independent simulator none was told an encoder.
MOVED = 2.0


@dataclass(frozen=True)
class OtherEncoders:
    """Encoders that explain as well what was calibrated.

    Parameters
    ----------
    offsets : dict of str to (float, float) [deg]
        By joint: how much further it would stand, and the deviation of that.
    apart : (n_tolerances,) array
        From the calibration to the numbers that hold then, in prior deviations.
    """

    offsets: Mapping[str, tuple[float, float]]
    apart: Array


def other_encoders(
    fitted: Fit, predictor: Predictor, told: Mapping[str, float]
) -> OtherEncoders | None:
    """Return encoders that explain as well what a fit puts down to tolerances; None: none do.

    Parameters
    ----------
    fitted : Fit
        With the encoders as they read.
    predictor : Predictor
        Of the records it was made on.
    told : dict of str to float [deg]
        Deviation of every joint's encoder; inf: gravity tells nothing of it, and it stays.
    """
    hypothesis = fitted.hypothesis
    size = len(hypothesis.tolerances)
    wider = _opened(hypothesis, told)
    if len(wider.tolerances) == size or np.abs(hypothesis.tolerance_values).max() < MOVED:
        return None
    found = fit(wider, predictor, relinearise=3)
    if found.log_evidence < fitted.log_evidence - EVIDENCE_BETWEEN:
        return None
    values = found.hypothesis.tolerance_values
    deviations = np.sqrt(np.diag(np.linalg.inv(found.precision)))
    offsets = {
        item.joint: (math.degrees(item.sigma * value), math.degrees(item.sigma * left))
        for item, value, left in zip(
            wider.tolerances[size:], values[size:], deviations[size:], strict=False
        )
        if abs(value) > CLEARLY * left
    }
    apart = values[:size] - hypothesis.tolerance_values
    return OtherEncoders(offsets, apart) if offsets else None


def _opened(hypothesis: Hypothesis, told: Mapping[str, float]) -> Hypothesis:
    """Return a hypothesis with the encoders that gravity tells of free, all at nominal."""
    names = {item.name for item in hypothesis.tolerances}
    encoders = [
        encoder_nuisance(joint, sigma)
        for joint, sigma in told.items()
        if math.isfinite(sigma) and encoder_of(joint) not in names
    ]
    tolerances = (*hypothesis.tolerances, *encoders)
    return replace(hypothesis, tolerances=tolerances, tolerance_values=np.zeros(len(tolerances)))
