"""What every method of identification offers; a new one is a file and a line of the catalogue."""

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from modal_core.samples import Samples
from oma_identifier.motion import never, PeakTest
from oma_identifier.selection import Identified
from oma_identifier.settings import IdentificationSettings


class Method(Protocol):
    """Identifies modes from responses.

    What tells their uncertainty differs: each method says in its docstring what its standard
    deviations are of; a method that has none leaves them NaN.
    """

    @property
    def name(self) -> str:
        """As in settings and results."""

    @property
    def needs_inputs(self) -> bool:
        """Whether it cannot do without known inputs."""

    def identify(
        self,
        samples: Samples,
        settings: IdentificationSettings,
        inputs: NDArray[np.float64] | None = None,
        explains: PeakTest = never,
    ) -> Identified:
        """Identify the modes of one stretch.

        Parameters
        ----------
        samples : Samples
            Responses.
        settings : IdentificationSettings
            Band and model orders.
        inputs : (n_samples, n_inputs) array or None
            Known inputs on the grid of the samples.
        explains : callable
            Tells a peak that motion of the robot explains from a mode.
        """
