"""A random structure, the sensors on it, and what each of them would have sent without a fault.

The responses are known at every instant: modes under white forces, integrated exactly at sixteen
times the sample rate, freed of what lies above the sensors' band, and read off by a spline.  So a
fault of a clock is a matter of when a sensor looks, and no approximation of it.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import make_interp_spline
from scipy.signal import firwin, oaconvolve

from benchmarks.identifier.plant import modal_acceleration, Plant
from modal_core.measurements import Measurement, SampleBlock, StampedSamples

START_NS = 1_700_000_000_000_000_000
FINE = 16
"""Steps of the simulation in a step of the sensors."""
TAPS = 24
"""Steps of the sensors to either side of the filter before the converter."""
BAND = 0.45
"""Band of the sensors as a share of their rate."""


@dataclass(frozen=True)
class Track:
    """What one sensor or recorder sends, sample by sample in order of arrival.

    Parameters
    ----------
    source : str
        Topic.
    counts : bool
        Sent in blocks with a counter and a declared rate; else one message per sample.
    rate_hz : float [Hz]
        Declared rate.
    time_s : (n_samples,) array [s]
        When the samples were really taken.
    stamp_ns : (n_samples,) int64 array [ns]
        What their stamps say.
    counter : (n_samples,) int array
        What the counter of a block would say.
    values : (n_samples, n_channels) array [m/s²]
        As sent.
    columns : (n_channels,) int array
        Rows of the mode shapes.
    """

    source: str
    counts: bool
    rate_hz: float
    time_s: NDArray[np.float64]
    stamp_ns: NDArray[np.int64]
    counter: NDArray[np.int64]
    values: NDArray[np.float64]
    columns: NDArray[np.int64]

    @property
    def channel_names(self) -> tuple[str, ...]:
        """Names the pipeline gives or is given."""
        plain = self.source.strip('/')
        if self.counts:
            return tuple(f'{plain}_{column}' for column in range(len(self.columns)))
        return tuple(f'{plain}.{axis}' for axis in 'xyz')

    def taken(self, rows: NDArray[np.int64] | NDArray[np.bool_]) -> 'Track':
        """Return the track with these samples only, in this order of arrival."""
        return replace(
            self,
            time_s=self.time_s[rows],
            stamp_ns=self.stamp_ns[rows],
            counter=self.counter[rows],
            values=self.values[rows],
        )


@dataclass(frozen=True)
class Scene:
    """A structure, its response at every instant, and the tracks of its sensors.

    Parameters
    ----------
    plant : Plant
        Truth.
    rate_hz, duration_s : float [Hz], [s]
        Of all sensors.
    noise : float
        Share of each channel's standard deviation.
    tracks : tuple of Track
        One per source.
    response : callable
        (times [s], columns) to (n_times, n_columns) accelerations without noise.
    extra : tuple of Measurement
        Sent beside the tracks, after the share ``at`` of them.
    """

    plant: Plant
    rate_hz: float
    duration_s: float
    noise: float
    tracks: tuple[Track, ...]
    response: 'Response'
    extra: tuple[tuple[float, Measurement], ...] = field(default=())

    def with_track(self, place: int, track: Track) -> 'Scene':
        """Return the scene with one track exchanged."""
        tracks = [*self.tracks]
        tracks[place] = track
        return replace(self, tracks=tuple(tracks))

    def shape_rows(self, names: tuple[str, ...]) -> list[int]:
        """Return the rows of the true shapes for channels."""
        known = {
            name: int(column)
            for track in self.tracks
            for name, column in zip(track.channel_names, track.columns, strict=False)
        }
        return [known[name] for name in names if name in known]


class Response:
    """Accelerations of a plant at any time.

    Parameters
    ----------
    plant : Plant
        The structure.
    rng : Generator
        Draws the forces.
    rate_hz, duration_s : float [Hz], [s]
        Of the sensors.
    """

    def __init__(
        self, plant: Plant, rng: np.random.Generator, rate_hz: float, duration_s: float
    ) -> None:
        fine_hz = FINE * rate_hz
        settle = int(8.0 / np.min(plant.damping_ratio * plant.frequency_hz * 2 * np.pi) * fine_hz)
        n_fine = int((duration_s + 4.0) * fine_hz) + settle
        force = rng.standard_normal((n_fine, plant.participation.shape[1]))
        low_pass = firwin(2 * TAPS * FINE + 1, 2.0 * BAND / FINE)
        modal = [
            oaconvolve(modal_acceleration(plant, index, drive, fine_hz)[settle:], low_pass, 'same')
            for index, drive in enumerate((force @ plant.participation.T).T)
        ]
        time = np.arange(len(modal[0])) / fine_hz - 2.0
        self._modal = make_interp_spline(time, np.array(modal).T, k=5)
        self._shapes = plant.shapes

    def __call__(
        self, time_s: NDArray[np.float64], columns: NDArray[np.int64]
    ) -> NDArray[np.float64]:
        """Return (n_times, n_columns) accelerations [m/s²]."""
        return np.asarray(self._modal(time_s) @ self._shapes[columns].T)


def random_scene(rng: np.random.Generator) -> Scene:
    """Draw a structure of 2 to 6 modes and 2 to 5 sensors, or a recorder, or both."""
    rate_hz = float(rng.choice([100.0, 128.0, 200.0, 256.0, 400.0, 512.0]))
    duration_s = float(rng.uniform(40.0, 60.0))
    n_modes = int(rng.integers(2, 7))
    plant = _random_plant(rng, n_modes, rate_hz)
    response = Response(plant, rng, rate_hz, duration_s)
    noise = float(10 ** rng.uniform(-2.5, -1.0))
    tracks = tuple(_tracks(rng, rate_hz, duration_s, len(plant.shapes)))
    scene = Scene(plant, rate_hz, duration_s, noise, tracks, response)
    filled = [measured(scene, track, rng) for track in tracks]
    return replace(scene, tracks=tuple(filled))


def measured(scene: Scene, track: Track, rng: np.random.Generator) -> Track:
    """Return a track with what its sensor reads at the times it looks."""
    clean = scene.response(track.time_s, track.columns)
    noise = scene.noise * clean.std(axis=0) * rng.standard_normal(clean.shape)
    return replace(track, values=clean + noise)


def _random_plant(rng: np.random.Generator, n_modes: int, rate_hz: float) -> Plant:
    lowest, highest = 0.04 * rate_hz, 0.36 * rate_hz
    place = (np.arange(n_modes) + rng.uniform(0.2, 0.8, n_modes)) / n_modes
    frequency = lowest * (highest / lowest) ** place
    shapes = rng.standard_normal((15, n_modes))
    participation = rng.standard_normal((n_modes, n_modes)) + 2.0 * np.eye(n_modes)
    participation /= np.linalg.norm(participation, axis=1, keepdims=True)
    participation *= (frequency[:, None] / frequency[0]) ** -0.4
    return Plant(frequency, 0.006 * 6.0 ** rng.uniform(size=n_modes), shapes, participation)


def _tracks(
    rng: np.random.Generator, rate_hz: float, duration_s: float, n_columns: int
) -> Iterator[Track]:
    kind = rng.choice(['sensors', 'recorder', 'both'])
    n_samples = int(duration_s * rate_hz)
    sensors = {'sensors': int(rng.integers(2, 6)), 'recorder': 0, 'both': 1}[str(kind)]
    columns = rng.permutation(n_columns)
    for index in range(sensors):
        delay = rng.uniform(0.0, 1.0) / rate_hz
        yield _track(f'/imu/s{index}', False, rate_hz, n_samples, delay, columns[:3])
        columns = columns[3:]
    if kind != 'sensors':
        width = int(rng.integers(4, 13))
        yield _track('/block', True, rate_hz, n_samples, 0.0, columns[:width])


def _track(
    source: str,
    counts: bool,
    rate_hz: float,
    n_samples: int,
    delay_s: float,
    columns: NDArray[np.int64],
) -> Track:
    time = np.arange(n_samples) / rate_hz + delay_s
    return Track(
        source=source,
        counts=counts,
        rate_hz=rate_hz,
        time_s=time,
        stamp_ns=stamps_of(time),
        counter=np.arange(n_samples),
        values=np.empty((n_samples, len(columns))),
        columns=columns,
    )


def stamps_of(time_s: NDArray[np.float64]) -> NDArray[np.int64]:
    """Return stamps [ns] of times [s] since the start."""
    return START_NS + np.rint(time_s * 1e9).astype(np.int64)


def measurements(scene: Scene) -> Iterator[Measurement]:
    """Yield what arrives, a tenth of a second of every track after the other."""
    batches = max(1, round(scene.duration_s * 10.0))
    extra = sorted(scene.extra, key=lambda item: item[0])
    for batch in range(batches):
        while extra and extra[0][0] <= batch / batches:
            yield extra.pop(0)[1]
        for track in scene.tracks:
            rows = np.arange(len(track.stamp_ns))
            edges = np.searchsorted(rows, len(rows) * np.array([batch, batch + 1]) / batches)
            yield from _sent(track.taken(rows[edges[0] : edges[1]]))


def _sent(track: Track) -> Iterator[Measurement]:
    if not len(track.stamp_ns):
        return
    if not track.counts:
        yield StampedSamples(track.source, 'link', track.stamp_ns, track.values)
        return
    for rows in np.split(
        np.arange(len(track.counter)), np.flatnonzero(np.diff(track.counter) != 1) + 1
    ):
        yield SampleBlock(
            source=track.source,
            stamp_ns=int(track.stamp_ns[rows[0]]),
            first_index=int(track.counter[rows[0]]),
            sample_rate_hz=track.rate_hz,
            channel_names=track.channel_names,
            acceleration=track.values[rows].astype(np.float32),
        )
