"""The health of data in words: of a window, and what was found on a channel."""

from collections.abc import Sequence

from modal_core.flag_words import flag_words
from modal_core.quality import ChannelQuality, DataQuality
from modal_reports.words import capital, count, listed

BRIDGED = ('gap',)
"""Flags of channels that are used as if nothing had been there."""


def quality_words(quality: DataQuality) -> list[str]:
    """Return the health of the data in sentences, the most important first."""
    sentences = []
    if not quality.identifiable:
        reason = quality.reason or 'no reason was recorded'
        sentences.append(f'The data could not be identified: {reason}.')
    sentences += [f'{capital(flag_words(flag))}.' for flag in quality.flags]
    excluded = [channel.name for channel in quality.channels if channel.excluded]
    if excluded:
        verb = 'was' if len(excluded) == 1 else 'were'
        sentences.append(f'{listed(excluded)} {verb} left out of the identification.')
    lost = sum(channel.n_lost for channel in quality.channels)
    filled = sum(channel.n_interpolated for channel in quality.channels)
    if lost:
        sentences.append(f'{count(lost, "sample")} never arrived, {filled} of them filled in.')
    elif filled:
        sentences.append(f'{count(filled, "sample")} filled in across short gaps.')
    repeated = sum(channel.n_duplicates for channel in quality.channels)
    moved = sum(channel.n_reordered for channel in quality.channels)
    if repeated:
        sentences.append(f'{count(repeated, "repeated sample")} dropped.')
    if moved:
        sentences.append(f'{count(moved, "sample")} arrived out of order and put back.')
    if not sentences and not any(channel.flags for channel in quality.channels):
        sentences.append('No fault was found in the data.')
    return sentences


def channel_words(channel: ChannelQuality) -> str:
    """Return what was found on one channel."""
    found = [flag_words(flag) for flag in channel.flags]
    if channel.excluded:
        found.insert(0, 'left out')
    return ', '.join(found) or 'healthy'


def poor_channels(channels: Sequence[ChannelQuality]) -> tuple[str, ...]:
    """Return which channels were left out and which look wrong, and why; a line for each."""
    left_out, suspect = _by_words(channels, True), _by_words(channels, False)
    return tuple(
        f'{what}: {"; ".join(f"{listed(names)} ({why})" for why, names in found.items())}'
        for what, found in (('left out', left_out), ('to be looked at', suspect))
        if found
    )


def _by_words(channels: Sequence[ChannelQuality], excluded: bool) -> dict[str, list[str]]:
    found: dict[str, list[str]] = {}
    for channel in channels:
        # What is left of a channel without values is flat.
        told = ('flatline',) if 'not_finite' in channel.flags else ()
        told = told if excluded else (*told, *BRIDGED)
        flags = [flag for flag in channel.flags if flag not in told]
        if channel.excluded == excluded and flags:
            found.setdefault(', '.join(map(flag_words, flags)), []).append(channel.name)
    return found
