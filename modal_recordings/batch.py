"""What one look at a batch of raw messages gives: measurements, and what was refused and why."""

from dataclasses import dataclass

from modal_core.errors import MessageError
from modal_core.measurements import Measurement


@dataclass(frozen=True, slots=True)
class DecodedBatch:
    """Decoded messages of one topic.

    Parameters
    ----------
    measurements : tuple of Measurement
        In order of arrival.
    refused : tuple of MessageError
        One per message that breaks its contract.
    """

    measurements: tuple[Measurement, ...] = ()
    refused: tuple[MessageError, ...] = ()
