"""Whether the modes of a running robot are those of the robot at rest.

Frequencies identified while the robot moves differ from those at rest where drives, friction and
control take part.  Each pair of modes is compared with its own uncertainty, so that a change is
told from scatter.
"""

from dataclasses import dataclass
import math

import numpy as np

from modal_core.errors import LayoutError
from modal_core.mode import Mode, ModeSet
from modal_core.numbers.assignment import cheapest_pairs
from modal_core.numbers.indicators import mac_where_seen
from oma_identifier.compare.expected_mac import expected_mac, ExpectedMac, UNKNOWN
from oma_identifier.compare.thresholds import COMPARISON


@dataclass(frozen=True, slots=True)
class ModeChange:
    """One mode in two states.

    Parameters
    ----------
    first, second : Mode
        The pair.
    frequency_change : float
        Of the second against the first, as a share of the first.
    damping_change : float
        Difference of the damping ratios.
    frequency_surprise, damping_surprise : float
        Changes in standard deviations of the difference; NaN when a deviation is unknown.
    mac : float
        Of the two shapes; NaN by one common channel.
    expected_mac : ExpectedMac
        Of two estimates of one mode with uncertainties as these.
    """

    first: Mode
    second: Mode
    frequency_change: float
    damping_change: float
    frequency_surprise: float
    damping_surprise: float
    mac: float
    expected_mac: ExpectedMac

    @property
    def is_shape_changed(self) -> bool:
        """Whether the shapes differ by more than three standard deviations; False if unknown."""
        return self.mac < self.expected_mac.least

    @property
    def is_significant(self) -> bool:
        """Whether frequency or damping changed by more than three standard deviations."""
        # One by one: of a NaN, where a deviation is unknown, max() would make the answer.
        return abs(self.frequency_surprise) > 3.0 or abs(self.damping_surprise) > 3.0


@dataclass(frozen=True, slots=True)
class ModeComparison:
    """Modes of two states, for example running and stationary.

    Parameters
    ----------
    changes : tuple of ModeChange
        Modes both states have, by frequency.
    only_first, only_second : tuple of Mode
        Modes of one state alone.
    """

    changes: tuple[ModeChange, ...]
    only_first: tuple[Mode, ...]
    only_second: tuple[Mode, ...]


def compare_modes(first: ModeSet, second: ModeSet) -> ModeComparison:
    """Pair the modes of two states by frequency and shape, and state how they differ.

    Parameters
    ----------
    first, second : ModeSet
        Of the same channels, or of channel sets that share names.

    Raises
    ------
    LayoutError
        They share none: nothing tells which mode is which.
    """
    names = tuple(name for name in first.channel_names if name in second.channel_names)
    if not names and len(first) and len(second):
        raise LayoutError(
            'the two share no channel, so that nothing tells which mode is which',
            found='; '.join(', '.join(each.channel_names) for each in (first, second)),
            advice='give channels at the same place the same name',
        )
    one = first.shapes[[first.channel_names.index(name) for name in names]]
    two = second.shapes[[second.channel_names.index(name) for name in names]]
    alike = mac_where_seen(one, two)
    shift = np.abs(second.frequency_hz[None] / first.frequency_hz[:, None] - 1.0)
    cost = shift / COMPARISON.farthest_share + (1.0 - alike)
    same = names == tuple(first.channel_names) == tuple(second.channel_names)
    told = len(names) > 1  # by one channel all shapes are alike
    expected = [
        [expected_mac(mode, other) if same else UNKNOWN for other in second] for mode in first
    ]
    least = np.array([[each.least for each in row] for row in expected]).reshape(alike.shape)
    allowed = (shift < COMPARISON.farthest_share) & (alike > np.fmin(least, COMPARISON.least_mac))
    rows, columns = cheapest_pairs(np.where(allowed, cost, 1e3))
    pairs = [
        (row, column) for row, column in zip(rows, columns, strict=True) if allowed[row, column]
    ]
    changes = tuple(
        _change(
            first.modes[row],
            second.modes[column],
            float(alike[row, column]) if told else math.nan,
            expected[row][column],
        )
        for row, column in pairs
    )
    return ModeComparison(
        changes,
        tuple(mode for row, mode in enumerate(first) if row not in {pair[0] for pair in pairs}),
        tuple(mode for row, mode in enumerate(second) if row not in {pair[1] for pair in pairs}),
    )


def _change(first: Mode, second: Mode, alike: float, expected: ExpectedMac) -> ModeChange:
    step_hz = second.frequency_hz - first.frequency_hz
    step = second.damping_ratio - first.damping_ratio
    return ModeChange(
        first=first,
        second=second,
        frequency_change=step_hz / first.frequency_hz,
        damping_change=step,
        frequency_surprise=step_hz / math.hypot(first.frequency_std_hz, second.frequency_std_hz),
        damping_surprise=step / math.hypot(first.damping_ratio_std, second.damping_ratio_std),
        mac=alike,
        expected_mac=expected,
    )
