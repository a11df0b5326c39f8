"""Blocks that continue those before pass; others wait until the next ones confirm them.

A block says three things that must agree with its neighbours: its stamp, its counter and its
rate.  One block alone proves nothing: 1000 samples may claim to last 100 microseconds.
"""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace

from modal_core.measurements import NANOSECONDS_PER_SECOND, SampleBlock
from modal_recordings.messages import LOWEST_BLOCK_RATE_HZ
from oma_identifier.time_axis.candidates import Candidates, Run
from oma_identifier.time_axis.thresholds import TIME_AXIS


@dataclass(frozen=True, slots=True)
class Passed:
    """Blocks that pass.

    Parameters
    ----------
    blocks : sequence of SampleBlock
        In order of arrival.
    anew : bool
        They do not continue what passed before.
    """

    blocks: Sequence[SampleBlock] = ()
    anew: bool = False


class BlockGate:
    """Lets the blocks of one source through that others confirm.

    Parameters
    ----------
    set_aside : Counter
        Where blocks that did not pass are counted, by reason.
    """

    def __init__(self, set_aside: 'Counter[str]') -> None:
        self._counts = set_aside
        self._newest: SampleBlock | None = None
        self._waiting: Candidates[SampleBlock] = Candidates(
            _follows, lambda block: block.acceleration.nbytes, self._drop
        )

    @property
    def is_waiting(self) -> bool:
        """Whether nothing has passed, but something is there."""
        return self._newest is None and len(self._waiting) > 0

    @property
    def awaited_s(self) -> float:
        """Time within which the blocks that wait will have been confirmed, if ever [s]."""
        run = self._waiting.longest()
        if run is None:
            return 0.0
        length_s = len(run.first.acceleration) / run.first.sample_rate_hz
        # As many as tell a rate, and others may be a block ahead.
        return min(TIME_AXIS.longest_wait_s, (TIME_AXIS.fewest_blocks_for_rate + 1) * length_s)

    def admit(self, block: SampleBlock) -> Passed:
        """Return the blocks that pass now that this one has come."""
        newest = self._newest
        if block.sample_rate_hz < LOWEST_BLOCK_RATE_HZ:
            self._counts['rate_refused'] += 1
            return Passed()
        if newest is not None and _follows(newest, block):
            missing = _put_right(newest, self._waiting.in_order(), block)
            self._waiting.clear()
            if block.stamp_ns >= newest.stamp_ns:
                self._newest = block
            return Passed([*missing, block])
        run = self._waiting.add(block)
        rate = _Rate(run)
        if rate.span_s >= TIME_AXIS.contradiction_s and not rate.is_plausible:
            self._counts['rate_refused'] += len(self._waiting.take(run))
        elif rate.is_confirmed and (run.n_items >= TIME_AXIS.confirm or self._may_be_few(run)):
            return self._pass(run)
        return Passed()

    def _may_be_few(self, run: Run[SampleBlock]) -> bool:
        """Tell whether the stamps go on, or begin, so that only the rate is in question."""
        newest = self._newest
        near = newest is None or _is_near(newest, run.first)
        return (
            near
            and run.n_items >= TIME_AXIS.fewest_blocks_for_rate
            and _Rate(run).span_s >= TIME_AXIS.enough_span_s
        )

    def _pass(self, run: Run[SampleBlock]) -> Passed:
        anew = self._newest is not None
        blocks = self._waiting.take(run)
        self._newest = max(blocks, key=lambda block: block.stamp_ns)
        self._waiting.clear()
        return Passed(blocks, anew)

    def flush(self, *, alone: bool) -> Passed:
        """Return what came of a record too short to confirm anything, unless it says nonsense.

        Parameters
        ----------
        alone : bool
            No other source has a time that it would have to agree with.
        """
        run = self._waiting.longest()
        if alone and self._newest is None and run is not None and _Rate(run).may_be_all:
            return self._pass(run)
        self._waiting.clear()
        return Passed()

    def expire(self) -> None:
        """Drop what has waited in vain."""
        self._waiting.expire()

    def _drop(self, blocks: Sequence[SampleBlock]) -> None:
        newest = self._newest
        for block in blocks:
            known = newest is not None and block.sample_rate_hz == newest.sample_rate_hz
            self._counts['stamp_unconfirmed' if known else 'rate_unconfirmed'] += 1


class _Rate:
    """What the blocks of a run say of their rate."""

    def __init__(self, run: Run[SampleBlock]) -> None:
        first, last = run.first, run.held[-1]
        self._n_items = run.n_items
        self._stamped_s = (last.stamp_ns - first.stamp_ns) / NANOSECONDS_PER_SECOND
        self._counted_s = (last.first_index - first.first_index) / last.sample_rate_hz
        self._held_s = len(last.acceleration) / last.sample_rate_hz

    @property
    def span_s(self) -> float:
        """Time from the first block to the last, by what says more [s]."""
        return max(self._stamped_s, self._counted_s)

    @property
    def is_plausible(self) -> bool:
        """Whether stamps and counter say about the same."""
        least = min(self._stamped_s, self._counted_s)
        return least > 0.0 and self.span_s <= TIME_AXIS.largest_factor * least

    @property
    def is_confirmed(self) -> bool:
        """Whether they say it over long enough."""
        return (
            self._n_items >= TIME_AXIS.fewest_blocks_for_rate
            and self.span_s >= TIME_AXIS.least_span_s
            and self.is_plausible
        )

    @property
    def may_be_all(self) -> bool:
        """Whether this may be a whole record: blocks that agree, or one that is long."""
        if self._n_items > 1:
            return self.is_plausible
        return self._held_s >= TIME_AXIS.enough_span_s


def _follows(last: SampleBlock, block: SampleBlock) -> bool:
    """Tell whether a block continues another: its rate, and both counter and stamp went on."""
    if block.sample_rate_hz != last.sample_rate_hz or not _is_near(last, block):
        return False
    counted_s = (block.first_index - last.first_index) / block.sample_rate_hz
    passed_s = (block.stamp_ns - last.stamp_ns) / NANOSECONDS_PER_SECOND
    length_s = len(last.acceleration) / last.sample_rate_hz
    return abs(passed_s - counted_s) <= TIME_AXIS.largest_step_s + length_s


def _put_right(
    before: SampleBlock, waiting: Sequence[SampleBlock], after: SampleBlock
) -> list[SampleBlock]:
    """Return blocks that fill exactly the hole between two others, with their true header."""
    index = before.first_index + len(before.acceleration)
    if not waiting or sum(len(b.acceleration) for b in waiting) != after.first_index - index:
        return []
    blocks = []
    for block in waiting:
        passed_s = (index - before.first_index) / before.sample_rate_hz
        stamp_ns = before.stamp_ns + round(passed_s * NANOSECONDS_PER_SECOND)
        rate_hz = before.sample_rate_hz
        blocks.append(replace(block, stamp_ns=stamp_ns, first_index=index, sample_rate_hz=rate_hz))
        index += len(block.acceleration)
    return blocks


def _is_near(last: SampleBlock, block: SampleBlock) -> bool:
    """Tell whether the stamp of a block is not far from the end of another."""
    length_ns = len(last.acceleration) / last.sample_rate_hz * NANOSECONDS_PER_SECOND
    return (
        -TIME_AXIS.reorder_ns <= block.stamp_ns - last.stamp_ns <= TIME_AXIS.forward_ns + length_ns
    )
