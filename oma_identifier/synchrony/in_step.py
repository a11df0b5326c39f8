"""Sensors put in step: samples of late ones moved, those that cannot be told left out.

A delay turns normal modes into complex ones and hides correlation from the subspace methods, so
it is put right in the samples, before anything is identified from them.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
import math

import numpy as np
from numpy.typing import NDArray

from modal_core.channel import Channel
from modal_core.measurements import NANOSECONDS_PER_SECOND
from modal_core.mode import Mode
from modal_core.numbers.indicators import mpc, mpd, normalise
from modal_core.samples import Samples
from oma_identifier.motion import Cleaned, Lag, LATE, never, PeakTest
from oma_identifier.synchrony.coherence import check_coherence, Coherence
from oma_identifier.synchrony.delay_odds import SensorDelay
from oma_identifier.synchrony.half_windows import HalfWindows
from oma_identifier.synchrony.sensor_delay import sensor_delays
from oma_identifier.synchrony.sensor_peaks import Columns, Peak, sensor_peaks
from oma_identifier.synchrony.thresholds import SYNCHRONY
from oma_identifier.time_axis import HALF_WIDTH, interpolate

TURNED = 'phases_turned'
UNKNOWN = Lag(math.nan, math.nan)

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]


class Synchroniser:
    """Puts the sensors of window after window in step, all windows by the same delays.

    Attributes
    ----------
    corrects_earlier : bool
        The newest window shows that sensors are late of which earlier ones did not tell.
    """

    def __init__(self) -> None:
        self.corrects_earlier = False
        self._peaks: list[Peak] = []
        self._held: dict[str, SensorDelay] = {}
        self._coherence = Coherence()
        self._half_windows = HalfWindows()

    def align(self, cleaned: Cleaned) -> Cleaned:
        """Return a window in step; the very same one where its sensors are.

        A channel that was moved says by how much (``delay_s``); sensors that no delay puts in step
        are left out, and so is one that shows another motion than all others.  What joint states
        prove of a sensor is used where the responses, which tell more exactly, do not prove
        anything.
        """
        channels = cleaned.samples.channels
        self._look(cleaned.samples)
        late = {s: d for s, d in self._held.items() if d.is_odd}
        delay_s = np.array([self._delay_s(c, cleaned.lags) for c in channels])
        kept = np.array([self._is_kept(channel) for channel in channels])
        turned = {c.name: TURNED for c in channels if self._is_turned(c.sensor)}
        apart = {**turned, **self._coherence.flags}
        if not delay_s.any() and kept.all():
            flags = {**apart, **cleaned.channel_flags}
            return replace(cleaned, channel_flags=flags) if apart else cleaned
        own = {c.name: late[c.sensor] for c in channels if c.sensor in late}
        lags = {n: Lag(d.seconds, d.std_s) if d.is_known else UNKNOWN for n, d in own.items()}
        return in_step(
            replace(
                cleaned,
                channel_flags={**apart, **dict.fromkeys(own, LATE), **cleaned.channel_flags},
                lags={**lags, **cleaned.lags},
                left_out=tuple(c.name for c, k in zip(channels, kept, strict=True) if not k),
            ),
            np.where(kept, delay_s, 0.0),
            kept,
        )

    def take_peaks(self) -> list[Peak]:
        """Hand over the peaks of the newest window: they are large, and nobody else needs them.

        None where it was not looked at.
        """
        peaks, self._peaks = self._peaks, []
        return peaks

    def _is_turned(self, sensor: str) -> bool:
        held = self._held.get(sensor)
        return held is not None and held.is_turned

    def _is_kept(self, channel: Channel) -> bool:
        sensor = channel.sensor
        held = self._held.get(sensor)
        late = held is not None and held.is_odd and not _aligns(held)
        return not late and sensor not in self._coherence.left_out

    def _delay_s(self, channel: Channel, lags: Mapping[str, Lag]) -> float:
        held = self._held.get(channel.sensor)
        if held is not None and held.is_odd:
            return held.seconds
        return lags[channel.name].behind_s if channel.name in lags else 0.0

    def _look(self, samples: Samples) -> None:
        self.corrects_earlier, self._peaks = False, []
        if not self._half_windows.has_seen(samples):
            self._held, self._coherence = {}, Coherence()
        if not self._half_windows.is_due(samples):
            return
        if samples.duration_s < SYNCHRONY.shortest_s:
            return
        columns = columns_of(samples.channels)
        peaks = self._peaks = sensor_peaks(samples) if len(columns) > 1 else []
        fresh = sensor_delays(peaks, columns)
        late = {name for name, delay in fresh.items() if delay.is_odd}
        on_time = {name: own for name, own in columns.items() if name not in late}
        self._coherence = check_coherence(samples, peaks, on_time)
        if not _say_the_same(fresh, self._held):
            self.corrects_earlier = any(
                delay.is_odd and sensor in self._held and self._held[sensor].is_undecided
                for sensor, delay in fresh.items()
            )
            # Of a sensor that this window does not tell of, what is held still holds.
            self._held = {
                sensor: self._held.get(sensor, delay) if delay.is_undecided else delay
                for sensor, delay in fresh.items()
            }


def columns_of(channels: Sequence[Channel]) -> Columns:
    """Return the channels of each sensor."""
    sensors = [channel.sensor for channel in channels]
    return {
        name: np.flatnonzero([other == name for other in sensors])
        for name in dict.fromkeys(sensors)
    }


def _say_the_same(fresh: Mapping[str, SensorDelay], held: Mapping[str, SensorDelay]) -> bool:
    """Tell whether a window proves nothing but what is held."""
    if not held:
        return False
    steps, spread = [], 0.0
    for sensor, now in fresh.items():
        before = held[sensor]
        if now.is_odd and not now.is_known:
            if not before.is_odd:
                return False
        elif now.is_odd or now.log_odds <= 0.0:
            # A window that does not tell says nothing against what is held.
            if before.is_odd and not before.is_known:
                return False
            steps.append(now.seconds - before.seconds)
            spread = max(spread, *(d.std_s for d in (now, before) if d.is_odd), 0.0)
    # Which sensor the others are late against does not matter.
    return not steps or max(steps) - min(steps) <= math.sqrt(2.0) * SYNCHRONY.surprise * spread


def _aligns(delay: SensorDelay) -> bool:
    """Tell whether a delay is known well enough for shapes."""
    phase = 2.0 * math.pi * delay.highest_hz * 3.0 * delay.std_s
    return delay.is_known and phase < SYNCHRONY.largest_phase_rad


def in_step(cleaned: Cleaned, delay_s: Real, kept: NDArray[np.bool_]) -> Cleaned:
    """Return a window with its channels moved, [s], and only those of them that are kept."""
    samples, first = _moved(cleaned.samples, delay_s, kept)
    moved_ns = first * NANOSECONDS_PER_SECOND / samples.sample_rate_hz
    motion, explains = cleaned.motion, cleaned.explains
    return replace(
        cleaned,
        samples=samples,
        lines=tuple(_line_in_step(line, delay_s, kept) for line in cleaned.lines),
        explains=never if explains is never else partial(_explains_late, explains, delay_s, kept),
        motion=motion and replace(motion, origin_ns=motion.origin_ns - moved_ns),
    )


def _explains_late(
    explains: PeakTest,
    delay_s: Real,
    kept: NDArray[np.bool_],
    frequency_hz: float,
    width_hz: float,
    shape: Complex,
) -> bool:
    """Test a shape in step: what is asked of, it is asked of as it was stamped."""
    as_stamped = np.zeros(len(kept), dtype=complex)
    as_stamped[kept] = shape * np.exp(-2j * math.pi * frequency_hz * delay_s[kept])
    return explains(frequency_hz, width_hz, as_stamped)


def _line_in_step(line: Mode, delay_s: Real, kept: NDArray[np.bool_]) -> Mode:
    turn = np.exp(2j * math.pi * line.frequency_hz * delay_s)
    shape = normalise((line.shape * turn)[kept])
    column = shape[:, None]
    return replace(line, shape=shape, mpc=float(mpc(column)[0]), mpd=float(mpd(column)[0]))


def _moved(samples: Samples, delay_s: Real, kept: NDArray[np.bool_]) -> tuple[Samples, int]:
    """Return the kept channels as if all had been sampled together, and which row comes first."""
    shift, data = delay_s * samples.sample_rate_hz, samples.acceleration
    first, last = 0, len(data)
    if shift.any():
        first = math.ceil(max(0.0, -shift.min())) + HALF_WIDTH
        last -= math.ceil(max(0.0, shift.max())) + HALF_WIDTH
    places = np.flatnonzero(kept)
    rows = data[first:last, places]
    for place, column in enumerate(places):
        if shift[column]:
            at = np.arange(first, last) + shift[column]
            own = samples.widened(columns=slice(column, column + 1))
            rows[:, place] = interpolate(own, at)[:, 0]
    channels = tuple(
        replace(channel, delay_s=channel.delay_s + float(delay_s[column]))
        for column, channel in enumerate(samples.channels)
        if kept[column]
    )
    start_ns = samples.start_ns + round(first * NANOSECONDS_PER_SECOND / samples.sample_rate_hz)
    return Samples(rows, samples.sample_rate_hz, channels, start_ns), first
