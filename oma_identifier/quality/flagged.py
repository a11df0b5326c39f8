"""Channels by what was found of them, in words."""

from collections.abc import Sequence

from modal_core.quality import ChannelQuality


def channels_by_flag(channels: Sequence[ChannelQuality]) -> dict[str, list[str]]:
    """Return the names of the channels that have each flag."""
    found: dict[str, list[str]] = {}
    for channel in channels:
        for flag in channel.flags:
            found.setdefault(flag, []).append(channel.name)
    return found
