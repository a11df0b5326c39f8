"""Sensors and converters that are not what they were: mounted anew, exchanged, wrapped, rectified.

What changes midway is held against the shapes of the sensors as they were first.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from benchmarks.faults.scene import Scene, Track

LEAST_TURN_RAD = 0.5


def _since(rng: np.random.Generator, track: Track) -> NDArray[np.bool_]:
    """Return the rows after a moment amid the record, (n_samples,) array."""
    first = int(rng.uniform(0.15, 0.85) * len(track.values))
    return np.arange(len(track.values)) >= first


def _place(rng: np.random.Generator, scene: Scene) -> int:
    return int(rng.integers(len(scene.tracks)))


def _turned(
    scene: Scene, place: int, since: NDArray[np.bool_], turn: NDArray[np.float64]
) -> Scene:
    track = scene.tracks[place]
    values = track.values.copy()
    values[since] = values[since] @ turn.T
    return scene.with_track(place, replace(track, values=values))


def polarity_flips(rng: np.random.Generator, scene: Scene) -> Scene:
    """A channel, or a whole sensor, is plugged in the other way round from a moment on."""
    place = _place(rng, scene)
    width = scene.tracks[place].values.shape[1]
    turn = np.eye(width)
    if scene.tracks[place].counts or rng.random() < 0.5:
        turn[int(rng.integers(width))] *= -1.0
    else:
        turn *= -1.0
    return _turned(scene, place, _since(rng, scene.tracks[place]), turn)


def gain_changes(rng: np.random.Generator, scene: Scene) -> Scene:
    """A channel, or a whole sensor, has another gain or unit from a moment on."""
    place = _place(rng, scene)
    width = scene.tracks[place].values.shape[1]
    gain = float(10 ** (rng.choice([-1, 1]) * rng.uniform(0.15, 1.0)))
    gain = float(rng.choice([gain, 9.80665, 1.0 / 9.80665]))
    turn = np.eye(width)
    if scene.tracks[place].counts or rng.random() < 0.5:
        turn[int(rng.integers(width))] *= gain
    else:
        turn *= gain
    return _turned(scene, place, _since(rng, scene.tracks[place]), turn)


def mount_rotates(rng: np.random.Generator, scene: Scene) -> Scene:
    """A sensor of three axes is turned about any axis; a recorder's neighbours are exchanged."""
    place = _place(rng, scene)
    track = scene.tracks[place]
    width = track.values.shape[1]
    turn = np.eye(width)
    if track.counts:
        pair = rng.choice(width, 2, replace=False)
        turn[pair] = turn[pair[::-1]]
    else:
        x, y, z = (axis := rng.standard_normal(3)) / np.linalg.norm(axis)
        cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
        angle = rng.uniform(LEAST_TURN_RAD, np.pi)
        turn += np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross
    return _turned(scene, place, _since(rng, track), turn)


def plugs_swapped(rng: np.random.Generator, scene: Scene) -> Scene:
    """Two sensors, or two channels of a recorder, change their plugs at a moment."""
    sensors = [place for place, track in enumerate(scene.tracks) if not track.counts]
    if len(sensors) < 2:
        return mount_rotates(rng, scene)
    places = rng.choice(sensors, 2, replace=False).tolist()
    since = _since(rng, scene.tracks[places[0]])
    values = [scene.tracks[place].values for place in places]
    for place, own, other in zip(places, values, values[::-1], strict=True):
        swapped = np.where(since[:, None], other, own)
        scene = scene.with_track(place, replace(scene.tracks[place], values=swapped))
    return scene


def _columns(rng: np.random.Generator, track: Track) -> list[int]:
    width = track.values.shape[1]
    return [int(rng.integers(width))] if rng.random() < 0.5 else list(range(width))


def wrapped_converter(rng: np.random.Generator, scene: Scene) -> Scene:
    """A converter whose range is left begins at its other end."""
    place, level = _place(rng, scene), rng.uniform(1.0, 3.0)
    track = scene.tracks[place]
    values = track.values.copy()
    for column in _columns(rng, track):
        limit = level * values[:, column].std()
        values[:, column] = (values[:, column] + limit) % (2.0 * limit) - limit
    return scene.with_track(place, replace(track, values=values))


def rectified(rng: np.random.Generator, scene: Scene) -> Scene:
    """A converter without sign: what is below zero comes as its size, or not at all."""
    place, change = _place(rng, scene), rng.choice([np.abs, lambda x: np.maximum(x, 0.0)])
    track = scene.tracks[place]
    values = track.values.copy()
    columns = _columns(rng, track)
    values[:, columns] = change(values[:, columns])
    return scene.with_track(place, replace(track, values=values))


def rows_reversed(rng: np.random.Generator, scene: Scene) -> Scene:
    """The rows within every block, or every read-out of a buffer, come in reversed order."""
    place, depth = _place(rng, scene), int(rng.integers(4, 129))
    track = scene.tracks[place]
    rows = np.arange(len(track.values))
    last = np.minimum(rows // depth * depth + depth - 1, len(rows) - 1)
    values = track.values[rows // depth * depth + last - rows]
    return scene.with_track(place, replace(track, values=values))


SENSOR_FAULTS = (
    polarity_flips,
    gain_changes,
    mount_rotates,
    plugs_swapped,
    wrapped_converter,
    rectified,
    rows_reversed,
)
