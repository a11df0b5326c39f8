"""Rebuilds a tracker's memory from plain data that may come from anywhere."""

from collections.abc import Mapping
from dataclasses import dataclass
import math

import numpy as np

from modal_core.errors import SettingsError
from oma_identifier.tracking.track import Place, Track


@dataclass(frozen=True, slots=True)
class TrackerState:
    """Memory of a tracker.

    Parameters
    ----------
    tracks : list of Track
        By id.
    next_id : int
        The next new mode gets this.
    """

    tracks: list[Track]
    next_id: int


def restore(data: object) -> TrackerState:
    """Return the memory a checkpoint holds.

    Raises
    ------
    SettingsError
        It is not one.
    """
    try:
        if not isinstance(data, Mapping):
            raise TypeError('not a mapping')
        tracks = [_track(entry) for entry in data['tracks']]
        next_id = int(data['next_id'])
    except (KeyError, TypeError, ValueError, OverflowError) as error:
        raise SettingsError(
            f'not a checkpoint: {error}', where='tracker state', advice='start without it'
        ) from error
    if any(not 0 < track.id < next_id for track in tracks):
        raise SettingsError('ids do not fit', where='tracker state', advice='start without it')
    return TrackerState(tracks, next_id)


def _track(entry: Mapping[str, object]) -> Track:
    fields: dict[str, object] = dict(entry)
    shape = np.array(fields['shape_real'], dtype=float) + 1j * np.array(
        fields['shape_imag'], dtype=float
    )
    names = tuple(str(name) for name in _list(fields['channel_names']))
    track = Track(
        id=int(_number(fields['id'])),
        frequency_hz=_number(fields['frequency_hz']),
        damping_ratio=_number(fields['damping_ratio']),
        level=_number(fields['level']),
        variance=_number(fields['variance']),
        wander=_number(fields['wander']),
        shape=shape,
        channel_names=names,
        n_seen=int(_number(fields['n_seen'])),
        missed=int(_number(fields['missed'])),
        places=[_place(_list(place)) for place in _list(fields['places'])],
        # Of a version without maps there is none.
        predicted={
            int(_number(number)): int(_number(count))
            for number, count in map(_list, _list(fields.get('predicted', [])))
        },
        companions={
            int(_number(number)): int(_number(count))
            for number, count in map(_list, _list(fields['companions']))
        },
    )
    if len(shape) != len(names) or not np.isfinite(shape).all():
        raise ValueError('shape and channel names differ')
    if not track.frequency_hz > 0.0 or not track.wander > 0.0 or not track.variance >= 0.0:
        raise ValueError('frequency not positive')
    if not math.isfinite(track.level):
        raise ValueError('level not finite')
    return track


def _place(entry: list[object]) -> Place:
    joints, offset, variance, *told = entry
    known = told[0] if told else None
    return Place(
        np.array(joints, dtype=float),
        _number(offset),
        _number(variance),
        math.nan if known is None else _number(known),
    )


def _number(value: object) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise TypeError(f'{value!r} is not a number')
    return float(value)


def _list(value: object) -> list[object]:
    if not isinstance(value, list | tuple):
        raise TypeError(f'{value!r} is not a list')
    return list(value)
