"""The health of data in words: of a window, and what was found on a channel."""

from collections import Counter
from collections.abc import Callable, Sequence

from modal_core.quality import ChannelQuality, DataQuality
from modal_core.words.flag_words import flag_words
from modal_reports.words import capital, count, listed

BRIDGED = ('gap', 'interrupted')
"""Flags of channels that are used as if nothing had been there."""
ALONE = 'incoherent'
"""Flag of channels whose motion no other shows."""
MOST_TIMES = 3
OUT_OFTEN, MOST = 0.1, 0.5
"""Share of windows a channel is left out of, and of those that have a flag, from where on it is
told of a recording; chosen: in one window of many, noise may look like a fault."""


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


def poor_channels(windows: Sequence[DataQuality]) -> tuple[str, ...]:
    """Return which channels were left out and which look wrong, and why; a line for each.

    Parameters
    ----------
    windows : sequence of DataQuality
        Of a recording; what was found in few of them alone is not told.
    """
    left_out: dict[str, list[str]] = {}
    suspect: dict[str, list[str]] = {}
    for name, found in _by_channel(windows).items():
        n_out = sum(channel.excluded for channel in found)
        if n_out > OUT_OFTEN * len(found):
            flags = Counter(flag for each in found if each.excluded for flag in each.flags)
            share = '' if n_out == len(found) else f' in {n_out} of {len(found)} windows'
            why = _words(flags, n_out) or flag_words(flags.most_common(1)[0][0])
            left_out.setdefault(f'{why}{share}', []).append(name)
            continue
        flags = Counter(flag for each in found for flag in each.flags if flag not in BRIDGED)
        if why := _words(flags, len(found)):
            suspect.setdefault(why, []).append(name)
    return tuple(
        f'{what}: {"; ".join(f"{listed(names)} ({why})" for why, names in of.items())}'
        for what, of in (('left out', left_out), ('to be looked at', suspect))
        if of
    )


def interrupted_channels(windows: Sequence[DataQuality], start_ns: int) -> tuple[str, ...]:
    """Return which channels were not heard for a while, and when; a line for each.

    Parameters
    ----------
    windows : sequence of DataQuality
        Of a recording.
    start_ns : int [ns]
        When it begins.
    """
    lines = []
    for name, found in _by_channel(windows).items():
        spans = _joined([span for each in found for span in each.interrupted_ns])
        if not spans:
            continue
        times = [f'{1e-9 * (a - start_ns):.1f} to {1e-9 * (b - start_ns):.1f}' for a, b in spans]
        when = _the_first(times, lambda more: f'{more} times more')
        seconds = 1e-9 * sum(b - a for a, b in spans)
        out = sum(each.excluded for each in found if each.interrupted_ns)
        kept = f'left out of {count(out, "window")}' if out else 'filled in from the others'
        lines.append(
            f'{name}: nothing of what the other sensors show at {when} s ({seconds:.3g} s in all,'
            f' {kept}); check its cable and plug'
        )
    return tuple(lines)


def far_channels(windows: Sequence[DataQuality]) -> tuple[str, ...]:
    """Return which channels have values far outside of all others, and which; a line for each.

    Parameters
    ----------
    windows : sequence of DataQuality
        Of a recording.
    """
    lines = []
    for name, found in _by_channel(windows).items():
        counts: Counter[float] = Counter()
        for _, value, n_samples in {far for each in found for far in each.far_values}:
            counts[value] += n_samples
        if not counts:
            continue
        said = [f'{n} x {value:.5g}' for value, n in counts.most_common()]
        which = _the_first(said, lambda more: count(more, 'other value'))
        lines.append(f'{name}: {which} {found[0].unit}, far outside of all else, taken as lost')
    return tuple(lines)


def lone_channels(windows: Sequence[DataQuality]) -> tuple[str, ...]:
    """Return what to do about channels that are left out for their own motion; a line for all.

    Parameters
    ----------
    windows : sequence of DataQuality
        Of a recording.
    """
    names = [
        name
        for name, found in _by_channel(windows).items()
        if sum(each.excluded and ALONE in each.flags for each in found) > MOST * len(windows)
    ]
    if not names:
        return ()
    return (
        f'{listed(names)}: the clock is wrong, the mount loose, or a part swings by itself, as a'
        ' load on a rope; check both, and identify what is left out alone to see how it moves',
    )


def _the_first(said: Sequence[str], rest: Callable[[int], str]) -> str:
    """Return the first of what there is to say, and of how many the rest is."""
    more = len(said) - MOST_TIMES
    return listed([*said[:MOST_TIMES], *([rest(more)] if more > 0 else [])])


def _joined(spans: Sequence[tuple[int, int]]) -> list[tuple[int, int]]:
    """Return spans without overlap, in order."""
    joined: list[tuple[int, int]] = []
    for begin, end in sorted(spans):
        if joined and begin <= joined[-1][1]:
            joined[-1] = joined[-1][0], max(end, joined[-1][1])
        else:
            joined.append((begin, end))
    return joined


def _by_channel(windows: Sequence[DataQuality]) -> dict[str, list[ChannelQuality]]:
    found: dict[str, list[ChannelQuality]] = {}
    for window in windows:
        for channel in window.channels:
            found.setdefault(channel.name, []).append(channel)
    return found


def _words(flags: Counter[str], n_windows: int) -> str:
    """Return in words the flags of most windows."""
    often = [flag for flag, number in flags.items() if number > MOST * n_windows]
    # What is left of a channel without values is flat.
    told = [flag for flag in often if flag != 'flatline' or 'not_finite' not in often]
    return ', '.join(map(flag_words, told))
