"""Faults of clocks, samples and messages, each drawn anew: its size, its place, its time."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from benchmarks.faults.scene import measured, Scene, stamps_of, START_NS, Track
from benchmarks.faults.sensor_faults import SENSOR_FAULTS
from modal_core.measurements import JointSamples, SampleBlock, StampedSamples

Fault = Callable[[np.random.Generator, Scene], Scene]
HOUR_NS = 3_600_000_000_000
BLOCK = 8
"""Samples of a recorder that are lost together."""


def _one(rng: np.random.Generator, scene: Scene, change: Callable[[Track], Track]) -> Scene:
    """Change one track, or now and then all of them."""
    places = range(len(scene.tracks))
    if rng.random() < 0.8:
        places = [int(rng.integers(len(scene.tracks)))]
    for place in places:
        scene = scene.with_track(place, change(scene.tracks[place]))
    return scene


def _stretch(rng: np.random.Generator, track: Track, share: float) -> slice:
    n_rows = len(track.values)
    length = max(1, int(share * n_rows))
    first = int(rng.integers(0, max(1, n_rows - length)))
    return slice(first, first + length)


def _columns(rng: np.random.Generator, track: Track) -> list[int]:
    n_columns = track.values.shape[1]
    if rng.random() < 0.7:
        return [int(rng.integers(n_columns))]
    return list(range(n_columns))


def _with_values(
    rng: np.random.Generator,
    scene: Scene,
    change: Callable[[Track, NDArray[np.float64]], None],
) -> Scene:
    def changed(track: Track) -> Track:
        values = track.values.copy()
        change(track, values)
        return replace(track, values=values)

    return _one(rng, scene, changed)


# -- clocks ---------------------------------------------------------------------------------


def stamp_far_off(rng: np.random.Generator, scene: Scene) -> Scene:
    """A few stamps lie seconds to a year away."""

    def change(track: Track) -> Track:
        stamps = track.stamp_ns.copy()
        first = int(rng.choice([0, rng.integers(len(stamps)), len(stamps) - 1]))
        away = int(rng.choice([-1, 1]) * 10 ** rng.uniform(9.5, 16.5))
        stamps[first : first + int(rng.integers(1, 6))] += away
        return replace(track, stamp_ns=stamps)

    return _one(rng, scene, change)


def coarse_stamps(rng: np.random.Generator, scene: Scene) -> Scene:
    """Stamps are cut to a tick of a third of a period to five periods."""

    def change(track: Track) -> Track:
        tick = int(1e9 / track.rate_hz * 10 ** rng.uniform(-0.5, 0.7))
        offset = track.stamp_ns - START_NS
        return replace(track, stamp_ns=START_NS + offset // tick * tick)

    return _one(rng, scene, change)


def stamps_of_a_fifo(rng: np.random.Generator, scene: Scene) -> Scene:
    """Several samples bear the stamp of the moment they were read out."""

    def change(track: Track) -> Track:
        depth = int(rng.integers(2, 20))
        rows = np.arange(len(track.stamp_ns))
        last = np.minimum(rows // depth * depth + depth - 1, len(rows) - 1)
        late = rng.exponential(1e6, len(rows) // depth + 1).astype(np.int64)
        return replace(track, stamp_ns=track.stamp_ns[last] + late[rows // depth])

    return _one(rng, scene, change)


def jitter(rng: np.random.Generator, scene: Scene) -> Scene:
    """Stamps scatter about the true times."""

    def change(track: Track) -> Track:
        scatter = 10 ** rng.uniform(-2.0, -0.3) / track.rate_hz * 1e9
        return replace(
            track,
            stamp_ns=track.stamp_ns
            + (scatter * rng.standard_normal(len(track.stamp_ns))).astype(np.int64),
        )

    return _one(rng, scene, change)


def wrong_rate(rng: np.random.Generator, scene: Scene) -> Scene:
    """A recorder declares another rate than its stamps show."""

    def change(track: Track) -> Track:
        off = rng.choice([-1, 1]) * 10 ** rng.uniform(-3.0, -0.3)
        return replace(track, rate_hz=track.rate_hz * (1.0 + off))

    return _one(rng, scene, change)


def _resampled(
    rng: np.random.Generator, scene: Scene, when: Callable[[Track], NDArray[np.float64]]
) -> Scene:
    """One sensor looks at other times than its stamps say."""
    place = int(rng.integers(len(scene.tracks)))
    track = scene.tracks[place]
    moved = replace(track, time_s=np.clip(when(track), -1.9, scene.duration_s + 1.9))
    return scene.with_track(place, measured(scene, moved, rng))


def hidden_drift(rng: np.random.Generator, scene: Scene) -> Scene:
    """One sensor's clock is off by 50 to 2,000 ppm, and its stamps do not show it."""
    off = rng.choice([-1, 1]) * 10 ** rng.uniform(-4.3, -2.7)
    return _resampled(rng, scene, lambda track: track.time_s * (1.0 + off))


def hidden_step(rng: np.random.Generator, scene: Scene) -> Scene:
    """One sensor's clock steps, and its stamps do not show it."""
    step = rng.choice([-1, 1]) * 10 ** rng.uniform(-0.3, 1.0) / scene.rate_hz
    since = rng.uniform(0.2, 0.8) * scene.duration_s
    return _resampled(rng, scene, lambda track: track.time_s + step * (track.time_s > since))


def hidden_delay(rng: np.random.Generator, scene: Scene) -> Scene:
    """One sensor is late or early all the time."""
    delay = rng.choice([-1, 1]) * 10 ** rng.uniform(-0.7, 1.0) / scene.rate_hz
    return _resampled(rng, scene, lambda track: track.time_s + delay)


def stale(rng: np.random.Generator, scene: Scene) -> Scene:
    """One sensor sends what it saw seconds ago."""
    place = int(rng.integers(len(scene.tracks)))
    track = scene.tracks[place]
    rows = int(rng.uniform(1.0, 15.0) * track.rate_hz)
    return scene.with_track(place, replace(track, values=np.roll(track.values, rows, axis=0)))


def clock_jump(rng: np.random.Generator, scene: Scene) -> Scene:
    """The clock of all steps, ahead or back, for good."""
    away = int(rng.choice([-1, 1]) * 10 ** rng.uniform(8.0, 13.0))
    since = rng.uniform(0.2, 0.8) * scene.duration_s
    for place, track in enumerate(scene.tracks):
        stamps = track.stamp_ns + away * (track.time_s > since)
        scene = scene.with_track(place, replace(track, stamp_ns=stamps))
    return scene


# -- arrival --------------------------------------------------------------------------------


def _kept(
    rng: np.random.Generator, scene: Scene, mask: Callable[[Track], NDArray[np.bool_]]
) -> Scene:
    return _one(rng, scene, lambda track: track.taken(mask(track)))


def random_loss(rng: np.random.Generator, scene: Scene) -> Scene:
    """Samples are lost one by one."""
    share = 10 ** rng.uniform(-3.0, -0.3)

    def mask(track: Track) -> NDArray[np.bool_]:
        # A recorder loses whole blocks.
        rows = np.arange(len(track.values)) // (BLOCK if track.counts else 1)
        return (rng.random(len(track.values)) > share)[rows]

    return _kept(rng, scene, mask)


def bursts_lost(rng: np.random.Generator, scene: Scene) -> Scene:
    """Samples are lost in bursts."""
    share, length = 10 ** rng.uniform(-3.0, -0.7), int(rng.integers(2, 60))

    def mask(track: Track) -> NDArray[np.bool_]:
        begins = np.flatnonzero(rng.random(len(track.values)) < share / length)
        keep = np.ones(len(track.values), dtype=bool)
        for first in begins:
            keep[first : first + length] = False
        return keep

    return _kept(rng, scene, mask)


def dropout(rng: np.random.Generator, scene: Scene) -> Scene:
    """A sensor is silent for a while, to the end, or begins late."""

    def mask(track: Track) -> NDArray[np.bool_]:
        keep = np.ones(len(track.values), dtype=bool)
        begin, end = np.sort(rng.uniform(0.0, 1.0, 2))
        begin, end = [(begin, end), (begin, 1.0), (0.0, begin)][rng.integers(3)]
        keep[int(begin * len(keep)) : int(end * len(keep))] = False
        return keep

    return _kept(rng, scene, mask)


def every_nth(rng: np.random.Generator, scene: Scene) -> Scene:
    """Only every second to fourth sample arrives."""
    step = int(rng.integers(2, 5))
    return _one(rng, scene, lambda track: _thinned(track, step, 0))


def rate_change(rng: np.random.Generator, scene: Scene) -> Scene:
    """From one moment on only every second sample arrives, of all sensors."""
    since = rng.uniform(0.2, 0.8)
    for place, track in enumerate(scene.tracks):
        scene = scene.with_track(place, _thinned(track, 2, int(since * len(track.values))))
    return scene


def _thinned(track: Track, step: int, since: int) -> Track:
    """Keep every ``step``-th sample from a row on; a recorder counts those it sends."""
    rows = np.arange(len(track.values))
    kept = track.taken((rows < since) | (rows % step == 0))
    return replace(kept, counter=np.arange(len(kept.values)))


def repeats(rng: np.random.Generator, scene: Scene) -> Scene:
    """Some samples arrive twice."""
    share = 10 ** rng.uniform(-3.0, -0.3)

    def change(track: Track) -> Track:
        count = 1 + (rng.random(len(track.values)) < share)
        return track.taken(np.repeat(np.arange(len(track.values)), count))

    return _one(rng, scene, change)


def out_of_order(rng: np.random.Generator, scene: Scene) -> Scene:
    """Samples overtake each other by up to half a second."""
    reach = 10 ** rng.uniform(-2.5, -0.3)

    def change(track: Track) -> Track:
        late = rng.uniform(0.0, reach * track.rate_hz, len(track.values))
        return track.taken(np.argsort(np.arange(len(late)) + late, kind='stable'))

    return _one(rng, scene, change)


# -- samples --------------------------------------------------------------------------------


def sample_and_hold(rng: np.random.Generator, scene: Scene) -> Scene:
    """Each value is sent two to five times."""
    times = int(rng.integers(2, 6))

    def change(track: Track, values: NDArray[np.float64]) -> None:
        held = np.arange(len(values)) // times * times
        columns = _columns(rng, track)
        values[:, columns] = values[np.ix_(held, columns)]

    return _with_values(rng, scene, change)


def flat_line(rng: np.random.Generator, scene: Scene) -> Scene:
    """A value stands still for half a second up to half the record."""
    share = 10 ** rng.uniform(-2.0, -0.3)

    def change(track: Track, values: NDArray[np.float64]) -> None:
        for column in _columns(rng, track):
            rows = _stretch(rng, track, share)
            values[rows, column] = values[rows.start, column]

    return _with_values(rng, scene, change)


def no_number(rng: np.random.Generator, scene: Scene) -> Scene:
    """NaN, infinite or absurd values now and then."""
    what = float(rng.choice([np.nan, np.inf, -np.inf, 1e300, 1e30, -1e12]))
    share = 10 ** rng.uniform(-4.0, -1.0)

    def change(track: Track, values: NDArray[np.float64]) -> None:
        for column in _columns(rng, track):
            values[rng.random(len(values)) < share, column] = what

    with np.errstate(over='ignore'):
        return _with_values(rng, scene, change)


def clipping(rng: np.random.Generator, scene: Scene) -> Scene:
    """A channel runs into its limit."""
    level = rng.uniform(0.3, 2.5)

    def change(track: Track, values: NDArray[np.float64]) -> None:
        for column in _columns(rng, track):
            limit = level * values[:, column].std()
            values[:, column] = np.clip(values[:, column], -limit, limit)

    return _with_values(rng, scene, change)


def knocks(rng: np.random.Generator, scene: Scene) -> Scene:
    """Single samples are far too large."""
    share, size = 10 ** rng.uniform(-4.0, -2.0), 10 ** rng.uniform(0.8, 3.0)

    def change(track: Track, values: NDArray[np.float64]) -> None:
        for column in _columns(rng, track):
            hit = rng.random(len(values)) < share
            values[hit, column] += size * values[:, column].std() * rng.choice([-1, 1])

    return _with_values(rng, scene, change)


def offset_jump(rng: np.random.Generator, scene: Scene) -> Scene:
    """The offset of a channel jumps or creeps."""
    size, creeps = 10 ** rng.uniform(0.0, 2.0), rng.random() < 0.5

    def change(track: Track, values: NDArray[np.float64]) -> None:
        ramp = np.linspace(0.0, 1.0, len(values))
        course = ramp if creeps else (ramp > rng.uniform(0.1, 0.9)).astype(float)
        for column in _columns(rng, track):
            values[:, column] += size * values[:, column].std() * course

    return _with_values(rng, scene, change)


def coarse_converter(rng: np.random.Generator, scene: Scene) -> Scene:
    """A converter of few steps."""
    step = 10 ** rng.uniform(-2.0, 0.3)

    def change(track: Track, values: NDArray[np.float64]) -> None:
        for column in _columns(rng, track):
            size = step * values[:, column].std()
            values[:, column] = size * np.rint(values[:, column] / size)

    return _with_values(rng, scene, change)


def only_noise(rng: np.random.Generator, scene: Scene) -> Scene:
    """A channel hears nothing but its own noise."""

    def change(track: Track, values: NDArray[np.float64]) -> None:
        for column in _columns(rng, track):
            size = values[:, column].std() * 10 ** rng.uniform(-3.0, 0.5)
            values[:, column] = size * rng.standard_normal(len(values))

    return _with_values(rng, scene, change)


def hum(rng: np.random.Generator, scene: Scene) -> Scene:
    """A line and its harmonics in one sensor or in all."""
    first = rng.uniform(0.03, 0.3) * scene.rate_hz

    def change(track: Track, values: NDArray[np.float64]) -> None:
        for number in range(1, 1 + int(rng.integers(1, 4))):
            level = 10 ** rng.uniform(-1.5, 0.5) * values.std(axis=0)
            phase = 2 * np.pi * number * first * track.time_s
            values += (
                np.sqrt(2.0) * level * np.sin(phase)[:, None] * rng.choice([-1, 1], len(level))
            )

    return _with_values(rng, scene, change)


def only_lines(rng: np.random.Generator, scene: Scene) -> Scene:
    """Nothing but sines on little noise, in all sensors."""
    hz = rng.uniform(0.03, 0.4, int(rng.integers(1, 6))) * scene.rate_hz
    noise = 10 ** rng.uniform(-5.0, -1.5)
    for place, track in enumerate(scene.tracks):
        shape = rng.standard_normal((len(hz), track.values.shape[1]))
        values = np.sin(2 * np.pi * np.outer(track.time_s, hz)) @ shape
        values += noise * rng.standard_normal(values.shape)
        scene = scene.with_track(place, replace(track, values=values))
    none = replace(
        scene.plant, frequency_hz=scene.plant.frequency_hz[:0], shapes=scene.plant.shapes[:, :0]
    )
    return replace(scene, plant=none)


# -- messages nobody asked for --------------------------------------------------------------


def foreign_block(rng: np.random.Generator, scene: Scene) -> Scene:
    """A block with an absurd rate, counter or stamp, on an own or a known topic."""
    rate = float(rng.choice([1e7, 1e5, 1e-3, 1e-9, 3.0, 44100.0]))
    counter = int(rng.choice([0, 1, 2**40, 2**63 - 5]))
    known = [track for track in scene.tracks if track.counts]
    track = known[0] if known and rng.random() < 0.5 else None
    names = track.channel_names if track else tuple(f'x{i}' for i in range(rng.integers(1, 9)))
    stamp = START_NS + int(rng.uniform(-2.0, scene.duration_s) * 1e9)
    values = rng.standard_normal((int(rng.integers(1, 1000)), len(names))).astype(np.float32)
    source = track.source if track else '/foreign'
    block = SampleBlock(source, stamp, counter, rate, names, values)
    return replace(scene, extra=(*scene.extra, (float(rng.random()), block)))


def foreign_sample(rng: np.random.Generator, scene: Scene) -> Scene:
    """A few samples of another sensor, at any time."""
    count = int(rng.integers(1, 30))
    stamps = stamps_of(rng.uniform(-100.0, 200.0) + np.cumsum(rng.exponential(1e-3, count)))
    source = scene.tracks[0].source if rng.random() < 0.3 else '/imu/foreign'
    samples = StampedSamples(source, 'link', stamps, rng.standard_normal((count, 3)))
    if source == scene.tracks[0].source and scene.tracks[0].counts:
        return scene
    return replace(scene, extra=(*scene.extra, (float(rng.random()), samples)))


def foreign_joints(rng: np.random.Generator, scene: Scene) -> Scene:
    """Joint states from another time."""
    count = int(rng.integers(1, 50))
    away = int(rng.choice([-1, 1]) * rng.integers(0, 2 * HOUR_NS))
    stamps = START_NS + away + np.arange(count) * 4_000_000
    names = tuple(f'joint_{index}' for index in range(6))
    still = rng.standard_normal((1, 6)) * np.ones((count, 1))
    joints = JointSamples(stamps, names, still, np.zeros((count, 6)))
    return replace(scene, extra=(*scene.extra, (float(rng.random()), joints)))


FAULTS: tuple[Fault, ...] = (
    stamp_far_off,
    coarse_stamps,
    stamps_of_a_fifo,
    jitter,
    wrong_rate,
    hidden_drift,
    hidden_step,
    hidden_delay,
    stale,
    clock_jump,
    random_loss,
    bursts_lost,
    dropout,
    every_nth,
    rate_change,
    repeats,
    out_of_order,
    sample_and_hold,
    flat_line,
    no_number,
    clipping,
    knocks,
    offset_jump,
    coarse_converter,
    only_noise,
    hum,
    only_lines,
    foreign_block,
    foreign_sample,
    foreign_joints,
    *SENSOR_FAULTS,
)
