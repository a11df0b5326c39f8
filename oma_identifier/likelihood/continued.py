"""Where a band was fitted before, in other coordinates or on other data, a fit may begin there."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from oma_identifier.likelihood.band_model import BandModel
from oma_identifier.likelihood.group_fits import GroupFit
from oma_identifier.likelihood.indices import ModeIndex
from oma_identifier.likelihood.reduced_band import ReducedBand
from oma_identifier.likelihood.thresholds import LIKELIHOOD

UNKNOWN = ModeIndex(-1)


def continued(
    band: ReducedBand, before: GroupFit | None, index: Mapping[ModeIndex, ModeIndex]
) -> BandModel | None:
    """Return the model to begin with; None where the fit before does not say.

    Poles and shapes are those of ``band`` already; forces, noise and slope are taken over.

    Parameters
    ----------
    band : ReducedBand
        To be fitted.
    before : GroupFit or None
        Of the same modes.
    index : mapping of ModeIndex to ModeIndex
        From the modes of ``band`` to those of ``before``.
    """
    if before is None or before.fit is None or before.band is None or not before.fit.converged:
        return None
    known = {mode: place for place, mode in enumerate(before.band.included)}
    places = [known.get(index.get(mode, UNKNOWN)) for mode in band.included]
    if len(places) != len(known) or None in places:
        return None
    order = np.array(places, dtype=np.intp)
    last = before.fit.model
    turn = band.project.T @ before.band.back
    scale = np.einsum('ij,ij->j', band.model.shapes.conj(), turn @ last.shapes[:, order])
    if np.any(np.abs(scale) < LIKELIHOOD.least_length):
        return None
    # What the coordinates before did not see has the noise that is supposed at first.
    unseen = np.maximum(0.0, 1.0 - np.sum(turn**2, axis=1))
    return replace(
        band.model,
        force=np.outer(scale, scale.conj()) * last.force[np.ix_(order, order)],
        noise=turn**2 @ last.noise + unseen * band.model.noise,
        slope=last.slope,
        curvature=last.curvature,
    )
