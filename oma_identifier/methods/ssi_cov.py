"""Covariance-driven subspace identification as a method of the catalogue."""

import numpy as np
from numpy.typing import NDArray

from modal_core.samples import Samples
from oma_identifier.identify import identify_samples
from oma_identifier.motion import never, PeakTest
from oma_identifier.selection import Identified
from oma_identifier.settings import IdentificationSettings


class SsiCov:
    """The method of the pipeline; deviations by first-order propagation and likelihood."""

    name = 'ssi_cov'
    needs_inputs = False

    def identify(
        self,
        samples: Samples,
        settings: IdentificationSettings,
        inputs: NDArray[np.float64] | None = None,
        explains: PeakTest = never,
    ) -> Identified:
        """Identify the modes of one stretch, see :func:`identify_samples`."""
        result = identify_samples(samples, settings, explains=explains)
        return Identified(result.modes, result.harmonics, result.poles)
