"""Identification with a measured force, such as that of a cut, as a method of the catalogue.

The equations are those of `csi`; what the force does not explain, chips that break, floor and
drives, is noise.  Noise of its sensor counts for more between the lines of teeth than on them,
which is why these are two inputs (:mod:`oma_identifier.known_force.lines_apart`).  Modal masses
follow from the same force (:mod:`oma_identifier.known_force`).

References
----------
Nguyen and Melkote (2020), doi:10.1016/j.promfg.2020.05.034 (milling forces and response);
Reynders and De Roeck (2008), doi:10.1016/j.ymssp.2007.09.004 (reference-based combined
identification).
"""

import numpy as np
from numpy.typing import NDArray

from modal_core.samples import Samples
from oma_identifier.known_force import lines_apart
from oma_identifier.methods.csi import Csi
from oma_identifier.motion import never, PeakTest
from oma_identifier.selection import Identified, SELECTION
from oma_identifier.settings import IdentificationSettings


class Force(Csi):
    """A force is measured; deviations by the jackknife of blocks."""

    name = 'force'
    trials = SELECTION.trials_measured

    def identify(
        self,
        samples: Samples,
        settings: IdentificationSettings,
        inputs: NDArray[np.float64] | None = None,
        explains: PeakTest = never,
    ) -> Identified:
        """Identify the modes of one stretch."""
        if inputs is not None:
            inputs, rows = lines_apart(inputs, samples.sample_rate_hz)
            samples, inputs = samples.part(rows), inputs[rows]
        return super().identify(samples, settings, inputs, explains)
