"""What the health of a window says, as stable codes and one line each."""

import math

from modal_core.measurements import NANOSECONDS_PER_SECOND
from modal_core.quality import ChannelQuality, DataQuality
from modal_core.words.named import named
from oma_identifier.motion import LATE
from oma_identifier.quality import channels_by_flag
from oma_identifier.synchrony import CHANGES

ORDINARY = ('partial', 'rigid_motion_removed', 'drive_lines')
"""Flags of a window that say how it was worked on, and no fault."""
MOST_NAMED = 6


def quality_findings(quality: DataQuality) -> list[tuple[str, str]]:
    """Return (code, text) of all that was found: flags of the window and of its channels.

    Parameters
    ----------
    quality : DataQuality
        Of the newest window.
    """
    found = [(flag.upper(), 'the newest window') for flag in quality.flags if flag not in ORDINARY]
    for channel in quality.channels:
        if channel.excluded:
            found.append(('CHANNEL_EXCLUDED', f'{channel.name}: {", ".join(channel.flags)}'))
        if LATE in channel.flags:
            found.append((LATE.upper(), f'{channel.name}: {_delay(channel)}'))
        for kind in CHANGES.intersection(channel.flags):
            since = f'{channel.since_ns / NANOSECONDS_PER_SECOND:.1f} s'
            found.append((kind.upper(), f'{channel.name}: another sensor since {since}'))
    by_flag = channels_by_flag(quality.channels)
    told = {LATE, *CHANGES}
    return found + [
        (flag.upper(), named(names, MOST_NAMED))
        for flag, names in by_flag.items()
        if flag not in told
    ]


def _delay(channel: ChannelQuality) -> str:
    if math.isnan(channel.lag_s):
        return 'no delay puts it in step with the others'
    return f'{1e3 * channel.lag_s:.2f} ± {1e3 * channel.lag_std_s:.2f} ms'
