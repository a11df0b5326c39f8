"""How far up sensors of a lower rate than the others hear, and what they say of no mode above."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from modal_core.mode import Mode, ModeSet
from modal_core.quality import ChannelQuality
from oma_identifier.time_axis import TIME_AXIS

HEARD = 0.45
"""Share of a source's own rate up to which it is put on a faster grid as it is: 0.3 % are lost
there, 2 % at 0.46, 16 % at 0.48."""


def heard_to_hz(names: Sequence[str], channels: Sequence[ChannelQuality]) -> NDArray[np.float64]:
    """Return up to which frequency each channel tells of modes, (n_channels,) array [Hz].

    inf where it has the rate of the fastest.

    Parameters
    ----------
    names : sequence of str
        Of the channels.
    channels : sequence of ChannelQuality
        Of these and others.
    """
    rates = {each.name: each.measured_rate_hz for each in channels}
    fastest = max(rates.values(), default=0.0)
    own = np.array([rates.get(name) or fastest for name in names], dtype=np.float64)
    return np.where(own < (1.0 - TIME_AXIS.rate_tolerance) * fastest, HEARD * own, np.inf)


def without_unheard(modes: ModeSet, channels: Sequence[ChannelQuality]) -> ModeSet:
    """Return modes in whose shapes channels that cannot hear them take no part: 0 exactly."""
    reach = heard_to_hz(modes.channel_names, channels)
    if not np.isfinite(reach).any():
        return modes
    return replace(modes, modes=tuple(_of_heard(mode, reach) for mode in modes))


def _of_heard(mode: Mode, reach: NDArray[np.float64]) -> Mode:
    heard = mode.frequency_hz <= reach
    if heard.all() or not heard.any():
        return mode
    std = None if mode.shape_std is None else np.where(heard, mode.shape_std, 0.0)
    return replace(mode, shape=np.where(heard, mode.shape, 0.0), shape_std=std)
