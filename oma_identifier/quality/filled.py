"""What too many samples that were filled in leave unsure."""

from collections.abc import Sequence
from dataclasses import replace
import math

from modal_core.mode import ModeSet
from modal_core.quality import ChannelQuality, DataQuality

DAMPING_UNSURE = 'damping_unsure'
MOST_FILLED = 0.2
"""Share of samples filled in up to which damping keeps to its deviation: up to 0.2 none of 601
estimates was beyond three deviations, at 0.35 4 of 149, at 0.5 20 of 151 (10 random structures,
all sensors losing alike).  Frequencies keep to theirs throughout."""
UNSURE_WINDOWS = 0.25
"""Share of such windows that makes a record unsure."""


def is_damping_unsure(channels: Sequence[ChannelQuality], n_rows: int) -> bool:
    """Tell whether a channel of a window of ``n_rows`` samples has too many filled in."""
    return any(
        channel.n_interpolated > MOST_FILLED * n_rows
        for channel in channels
        if not channel.excluded
    )


class SureDamping:
    """Takes the deviation from damping that too many filled samples bias."""

    def __init__(self) -> None:
        self._n_windows = 0
        self._n_unsure = 0

    def of_window(self, modes: ModeSet, quality: DataQuality) -> ModeSet:
        """Return the modes of the next window."""
        unsure = DAMPING_UNSURE in quality.flags
        self._n_windows += 1
        self._n_unsure += unsure
        return _without_deviation(modes) if unsure else modes

    def of_record(self, modes: ModeSet) -> ModeSet:
        """Return the modes of all windows so far as one record."""
        many = self._n_unsure > UNSURE_WINDOWS * self._n_windows
        return _without_deviation(modes) if many else modes


def _without_deviation(modes: ModeSet) -> ModeSet:
    unsure = tuple(replace(mode, damping_ratio_std=math.nan) for mode in modes)
    return replace(modes, modes=unsure)
