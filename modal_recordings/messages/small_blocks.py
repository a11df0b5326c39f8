"""Blocks of samples in parts that are not larger than a message should be."""

from collections.abc import Iterator
from dataclasses import replace

from modal_core.measurements import NANOSECONDS_PER_SECOND, SampleBlock

LARGEST_BLOCK_BYTES = 64_000
"""Below the size of a datagram."""
SAMPLE_BYTES = 4


def most_rows(n_channels: int) -> int:
    """Return how many samples of so many channels a message holds."""
    return max(1, LARGEST_BLOCK_BYTES // (SAMPLE_BYTES * n_channels))


def small_blocks(block: SampleBlock) -> Iterator[SampleBlock]:
    """Yield a block in parts that fit into a message each."""
    n_rows = most_rows(block.acceleration.shape[1])
    for first in range(0, len(block.acceleration), n_rows):
        yield replace(
            block,
            stamp_ns=block.stamp_ns + round(first * NANOSECONDS_PER_SECOND / block.sample_rate_hz),
            first_index=block.first_index + first,
            acceleration=block.acceleration[first : first + n_rows],
        )
