"""The health of data in words: what every flag means, what was found on a channel."""

from collections.abc import Sequence

from modal_core.quality import ChannelQuality, DataQuality
from modal_reports.words import capital, count, listed

FLAG_WORDS = {
    'flatline': 'no signal (flat line)',
    'clipping': 'signal clipped at the sensor range',
    'not_finite': 'values that are not numbers',
    'gap': 'gaps in the data',
    'degraded': 'identified from fewer channels than expected',
    'partial': 'shorter than a full window',
    'rate_change': 'sample rate changed',
    'clock_jump': 'clock jumped',
    'unit_g_suspicion': 'gravity reads 1: perhaps in g instead of m/s²',
    'gravity_suspicion': 'gravity has the wrong length: check gain and unit',
    'gain_suspicion': "too large or small for the robot's motion: check gain and unit",
    'polarity_suspicion': "the robot's motion the wrong way round: check polarity",
    'axes_suspicion': "another axis' motion of the robot: check axes and mounting",
    'rigid_motion_mismatch': "does not fit the robot's motion: check polarity, axes and place",
    'not_synchronous': 'sampled later or earlier than the other sensors',
    'rigid_motion_removed': 'rigid motion of the arm taken out',
    'known_motion': "modes marked so were estimated with the joints' known motion",
    'drive_lines': 'lines of the drives taken out',
    'gross_motion': 'the robot moved far',
    'line_or_mode': 'a harmonic may be a mode of light damping: a record four times as long tells',
}

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


def flag_words(flag: str) -> str:
    """Return a flag in words."""
    return FLAG_WORDS.get(flag, flag.replace('_', ' '))
