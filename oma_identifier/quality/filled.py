"""What too many samples that were filled in leave unsure."""

from collections.abc import Sequence
from dataclasses import replace
import math

from modal_core.mode import ModeSet
from modal_core.quality import ChannelQuality, DataQuality
from oma_identifier.quality.thresholds import QUALITY

DAMPING_UNSURE = 'damping_unsure'


def is_damping_unsure(channels: Sequence[ChannelQuality], n_rows: int) -> bool:
    """Tell whether a channel of a window of ``n_rows`` samples has too many filled in."""
    return any(
        channel.n_interpolated > QUALITY.most_filled * n_rows
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
        many = self._n_unsure > QUALITY.unsure_windows * self._n_windows
        return _without_deviation(modes) if many else modes


def _without_deviation(modes: ModeSet) -> ModeSet:
    unsure = tuple(replace(mode, damping_ratio_std=math.nan) for mode in modes)
    return replace(modes, modes=unsure)
