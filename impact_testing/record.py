"""A recording of taps: the force of the hammer and what the structure answers."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modal_core.errors import RecordingError
from modal_core.samples import Samples

AGAINST = '-'


@dataclass(frozen=True, slots=True)
class ImpactRecord:
    """Taps on one point in one direction.

    Parameters
    ----------
    force_n : (n_samples,) array [N]
        Of the hammer, on the grid of the responses.
    responses : Samples
        What the sensors read.
    hit : str
        Channel that would read the motion of the point in the direction of the force, ``-``
        before it where the hammer struck against it: ``elbow.x``, ``-elbow.x``.  It need not be
        among the responses; empty: not known.
    name : str
        Of the recording, for people.
    """

    force_n: NDArray[np.float64]
    responses: Samples
    hit: str = ''
    name: str = 'recording'

    def __post_init__(self) -> None:
        """Refuse what cannot be a recording of taps.

        Raises
        ------
        RecordingError
            Lengths differ, or a force is not finite.
        """
        if self.force_n.shape != (len(self.responses.acceleration),):
            raise RecordingError(
                'force and responses differ in length',
                where=self.name,
                found=self.force_n.shape,
                expected=f'{len(self.responses.acceleration)} samples',
            )
        if not np.isfinite(self.force_n).all():
            row = int(np.argmin(np.isfinite(self.force_n)))
            raise RecordingError('force is not finite', where=f'{self.name}: row {row + 1}')

    @property
    def point(self) -> str:
        """The channel at the point that was hit, without its sign."""
        return self.hit.removeprefix(AGAINST)

    @property
    def sign(self) -> float:
        """-1 where the hammer struck against the channel's direction."""
        return -1.0 if self.hit.startswith(AGAINST) else 1.0

    @property
    def rate_hz(self) -> float:
        """Sample rate [Hz]."""
        return self.responses.sample_rate_hz
