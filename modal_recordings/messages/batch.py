"""What one look at a batch of raw messages gives: measurements, and what was refused and why."""

from collections.abc import Callable, Sequence
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


def one_by_one(raws: Sequence[bytes], decode_one: Callable[[bytes], Measurement]) -> DecodedBatch:
    """Decode messages one after the other; those that break their contract are refused."""
    measurements: list[Measurement] = []
    refused: list[MessageError] = []
    for raw in raws:
        try:
            measurements.append(decode_one(raw))
        except MessageError as error:
            refused.append(error)
    return DecodedBatch(tuple(measurements), tuple(refused))
