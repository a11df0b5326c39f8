"""The fit of a band whose modes are driven by known inputs too."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from oma_identifier.likelihood.averages import averaged_again, divided, parts_wanted
from oma_identifier.likelihood.band_model import BandData, BandModel
from oma_identifier.likelihood.continued import continued
from oma_identifier.likelihood.fit_band import bends, fit_band, mean_at, with_spread
from oma_identifier.likelihood.group_fits import GroupFit
from oma_identifier.likelihood.known_mean import Mean
from oma_identifier.likelihood.known_motion import averages_with, KnownMotion, principal_inputs
from oma_identifier.likelihood.line_spectra import Spectra
from oma_identifier.likelihood.mode_groups import StartModes
from oma_identifier.likelihood.record_ends import without_ends
from oma_identifier.likelihood.reduced_band import reduce_band
from oma_identifier.likelihood.thresholds import LIKELIHOOD

Complex = NDArray[np.complex128]


def fit_known(
    spectra: Spectra, now: StartModes, before: GroupFit, inputs: NDArray[np.complex64]
) -> GroupFit | None:
    """Fit a group again, with inputs that are known.

    Parameters
    ----------
    spectra : Spectra
        Of the responses.
    now : StartModes
        All modes.
    before : GroupFit
        Without the inputs, or with them while other modes were elsewhere.
    inputs : (n_inputs, n_frequencies) complex array
        Transforms of the inputs at the frequencies of the spectra.

    Returns
    -------
    GroupFit or None
        None where the inputs explain no more than inputs that have nothing to do with the
        responses would.
    """
    if before.fit is None or before.band is None:
        return None
    lines = before.band.lines
    band, values = reduce_band(spectra, now, before.group, lines)
    same = {mode: mode for mode in now.indices()}
    model = continued(band, before, same) or band.model
    known = principal_inputs(inputs[:, lines].astype(complex), *band.model.shapes.shape[::-1])
    if not len(known):
        return None
    of = _KnownBand(spectra, lines, values, known)
    data = of.averages(band.data, without_ends(spectra, lines, values, band.data, model))
    mean = mean_at(data, model)
    if mean is None or mean.chance > LIKELIHOOD.known_chance:
        return None
    for _ in range(LIKELIHOOD.known_rounds):
        data = of.divided(data, model, mean)
        data = with_spread(data, model)
        fit = fit_band(data, band.model, near=model)
        model, mean = fit.model, mean_at(data, fit.model)
        if mean is None:
            return None
    coarse = bool(np.any(parts_wanted(data, model, mean) > LIKELIHOOD.coarse_parts))
    left = replace(data, periodogram=mean.left, known=None)
    motion = replace(of.motion(data, model, mean), bends=bends(data, model))
    band = replace(band, data=left, motion=motion)
    return GroupFit(before.group, band, fit, coarse, before.without or before)


@dataclass(frozen=True, slots=True)
class _KnownBand:
    """Lines of a band with their inputs."""

    spectra: Spectra
    lines: NDArray[np.intp]
    values: Complex
    inputs: Complex

    def averages(self, data: BandData, cleaned: Complex) -> BandData:
        """Return averages of values and inputs."""
        return averages_with(averaged_again(data, cleaned), cleaned, self.inputs)

    def motion(self, data: BandData, model: BandModel, mean: Mean) -> KnownMotion:
        """Return what the inputs do."""
        stretch = self.spectra.stretch[self.lines]
        frequency = self.spectra.frequency_hz[self.lines]
        return KnownMotion.of(frequency, stretch, self.inputs, data, model, mean)

    def divided(self, data: BandData, model: BandModel, mean: Mean) -> BandData:
        """Return averages fine enough for a model, without what the ends of the record do."""
        driven = self.motion(data, model, mean).values
        rest = replace(data, periodogram=mean.left, known=None)
        cleaned = driven + without_ends(
            self.spectra, self.lines, self.values - driven, rest, model
        )
        parts = parts_wanted(data, model, mean)
        finer = divided(data, parts, self.spectra.frequency_hz[self.lines], cleaned)
        return averages_with(finer, cleaned, self.inputs)
