"""Recordings of several loading conditions as one, for methods that compare conditions."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from modal_core.errors import RecordingError, SettingsError

if TYPE_CHECKING:
    from autonomous_modal_analysis.api.recording import Recording

METHOD = 'psdtm'
MOST = 5
"""Recordings: the method divides the whole in sixteen parts, of which two at least must lie in
each recording."""
SHORTEST = 0.5
"""Share of the mean length that a recording must have, for the same reason."""


def check_one(n_recordings: int, method: str) -> None:
    """Refuse several recordings where the method takes one.

    Raises
    ------
    SettingsError
        Naming what takes several.
    """
    if n_recordings > 1 and method != METHOD:
        raise SettingsError(
            'several recordings are loading conditions',
            where='method',
            found=method,
            expected=METHOD,
            advice='use ama merge to join set-ups, ama compare to compare recordings',
        )


def joined(recordings: Sequence['Recording']) -> 'Recording':
    """Return recordings of the same sensors one after the other, each about its mean.

    Parameters
    ----------
    recordings : sequence of Recording
        One per loading condition: another joint that shakes, another tool path; each one stretch
        of samples in the same pose.  Joint states take no part.

    Raises
    ------
    ModalAnalysisError
        Too many, one much shorter than the others, other channels or another rate than the
        first, or a recording with gaps.
    """
    from autonomous_modal_analysis.api.recording import Recording
    from modal_recordings import array_recording

    if len(recordings) == 1:
        return recordings[0]
    if len(recordings) > MOST:
        raise SettingsError(
            'too many loading conditions', found=len(recordings), expected=f'2 to {MOST}'
        )
    first = recordings[0].samples
    for each in recordings[1:]:
        _check_alike(recordings[0], each)
    rows = [each.samples.acceleration - each.samples.acceleration.mean(0) for each in recordings]
    mean = sum(map(len, rows)) / len(rows)
    for each, values in zip(recordings, rows, strict=True):
        if len(values) < SHORTEST * mean:
            raise RecordingError(
                'much shorter than the other loading conditions',
                where=each.name,
                found=f'{len(values) / first.sample_rate_hz:.3g} s',
                expected=f'{SHORTEST * mean / first.sample_rate_hz:.3g} s or more',
            )
    whole = np.concatenate(rows)
    used = np.isfinite(whole).all(axis=0)
    names = [
        name if is_used else '-' for name, is_used in zip(first.channel_names, used, strict=True)
    ]
    if not used.any():
        raise RecordingError('no channel is whole in all recordings', where=_names(recordings))
    whole[:, ~used] = 0.0
    table = array_recording(whole, first.sample_rate_hz, names, name=_names(recordings))
    return Recording(table, _names(recordings))


def _check_alike(first: 'Recording', other: 'Recording') -> None:
    one, two = first.samples, other.samples
    if one.channel_names != two.channel_names:
        raise RecordingError(
            f'other channels than {first.name}',
            where=other.name,
            found=', '.join(two.channel_names),
            expected=', '.join(one.channel_names),
        )
    if abs(one.sample_rate_hz / two.sample_rate_hz - 1.0) > 1e-3:
        raise RecordingError(
            f'another rate than {first.name}',
            where=other.name,
            found=f'{two.sample_rate_hz:g} Hz',
            expected=f'{one.sample_rate_hz:g} Hz',
        )


def _names(recordings: Sequence['Recording']) -> str:
    return ' + '.join(each.name for each in recordings)
