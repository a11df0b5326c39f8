"""A force that was measured beside the responses."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from modal_core.errors import IdentificationError
from modal_core.measurements import NANOSECONDS_PER_SECOND
from modal_core.samples import Samples
from oma_identifier.time_axis import interpolate


@dataclass(frozen=True, slots=True)
class KnownForce:
    """Forces on a uniform grid of their own.

    Parameters
    ----------
    value_n : (n_samples, n_forces) array [N]
        One column per force.
    rate_hz : float [Hz]
    start_ns : int [ns]
        Time of the first row, on the clock of the responses.
    name : str
        Of the channel.
    without_unit : tuple of str
        Whose unit was assumed, force or responses.
    """

    value_n: NDArray[np.float64]
    rate_hz: float
    start_ns: int
    name: str
    without_unit: tuple[str, ...] = ()

    def beside(self, samples: Samples) -> Samples:
        """Return samples with the force at their instants as the known input.

        Raises
        ------
        IdentificationError
            The force does not cover them.
        """
        begin = (samples.start_ns - self.start_ns) / NANOSECONDS_PER_SECOND * self.rate_hz
        step = self.rate_hz / samples.sample_rate_hz
        place = begin + step * np.arange(len(samples.acceleration))
        if place[0] < -0.5 or place[-1] > len(self.value_n) - 0.5:
            raise IdentificationError(
                'the force does not cover the responses',
                where=self.name,
                found=f'{-place[0] / self.rate_hz:.3g} s of responses before it, '
                f'{(place[-1] - len(self.value_n) + 1) / self.rate_hz:.3g} s after it',
                expected='one recording of both',
            )
        whole = np.abs(place - np.round(place)).max() < 1e-6 and abs(step - 1.0) < 1e-9
        if whole:
            known = self.value_n[np.round(place).astype(int)]
        else:
            inside = np.clip(place, 0.0, len(self.value_n) - 1.0)
            known = interpolate(self.value_n, inside, min(1.0, 1.0 / step))
        return replace(samples, known=known)
