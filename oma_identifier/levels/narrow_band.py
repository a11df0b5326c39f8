"""What a record shows of a mode in a band about it: envelopes of displacement and velocity.

One filter tells the mode from those nearby.
"""

from collections.abc import Sequence
from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import NDArray

from modal_core.mode import Mode
from modal_core.samples import Samples
from oma_identifier.levels.thresholds import LEVELS

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True, slots=True)
class Narrow:
    """Displacement [m] and velocity [m/s] about a frequency as complex envelopes."""

    displacement: Complex
    velocity: Complex
    rate_hz: float
    carrier_hz: float


@dataclass(frozen=True, slots=True)
class ModeRecord:
    """A mode in a record.

    Parameters
    ----------
    parts : sequence of Samples
        The record, in stretches between gaps.
    mode : Mode
        As identified in it.
    modes : sequence of Mode
        All of the record; what those nearby do is taken out by their shapes.
    channel : int
        Whose motion is meant, of the mode's shape; it measures along a straight line, and those
        of its unit are taken.
    """

    parts: Sequence[Samples]
    mode: Mode
    modes: Sequence[Mode]
    channel: int


@dataclass(frozen=True, slots=True)
class _Lines:
    """Spectral lines of a part about a mode, as its channel moves with the mode alone.

    Parameters
    ----------
    hz : (n_lines,) array [Hz]
    displacement : (n_lines,) complex array [m]
    n_rows : int
        Of the part.
    rate_hz : float [Hz]
        Of its samples.
    """

    hz: Real
    displacement: Complex
    n_rows: int
    rate_hz: float


@dataclass(frozen=True, slots=True)
class ModeInRecord:
    """A mode, and what a record shows about it.

    Parameters
    ----------
    mode : Mode
        As identified in the record.
    lines : tuple of _Lines
        Of the stretches that are long enough, within ``wide_hz``.
    reach_hz, wide_hz : float [Hz]
        On either side of the mode, of its moments and of its flanks.
    ends_s : float [s]
        Left out at either end.
    moves_over_others : (float, float)
        Mean squares of displacement and of velocity, in all channels, over those of all other
        modes of the record; infinite where there are none.
    """

    mode: Mode
    lines: tuple[_Lines, ...]
    reach_hz: float
    wide_hz: float
    ends_s: float
    moves_over_others: tuple[float, float]

    def within(self, reach_hz: float) -> list[Narrow]:
        """Return what each part shows in a band."""
        return [self._in_band(part, reach_hz) for part in self.lines]

    def _in_band(self, lines: _Lines, reach_hz: float) -> Narrow:
        inside = np.abs(lines.hz - self.mode.frequency_hz) <= reach_hz
        hz, displacement = lines.hz[inside], lines.displacement[inside]
        # Lines about the middle one as those of a signal of its own: what is slow is few samples.
        n, middle = len(hz), len(hz) // 2
        rate_hz = lines.rate_hz * n / lines.n_rows
        cut = math.ceil(self.ends_s * rate_hz)

        def envelope(of: Complex) -> Complex:
            return np.asarray(np.fft.ifft(np.roll(of, -middle)) * n / lines.n_rows)[cut : n - cut]

        return Narrow(
            envelope(displacement),
            envelope(2j * np.pi * hz * displacement),
            rate_hz,
            float(hz[middle]),
        )


def mode_in_record(record: ModeRecord, half_width_hz: float) -> ModeInRecord | str:
    """Return how a record shows a mode, or why it does not: it is too short.

    Parameters
    ----------
    record : ModeRecord
    half_width_hz : float [Hz]
        That bands are multiples of, one for all levels: what a band lets through of other modes
        is then no change with the level.
    """
    parts, mode, modes = record.parts, record.mode, record.modes
    ends_s = LEVELS.ends / (2.0 * math.pi * half_width_hz)
    enough = [each for each in parts if each.duration_s > LEVELS.fewest_ends * ends_s]
    if not enough:
        longest_s, needed_s = max(each.duration_s for each in parts), LEVELS.fewest_ends * ends_s
        return f'{longest_s:.3g} s in a row are short, {math.ceil(1.05 * needed_s):g} s would do'
    channels, channel = parts[0].channels, record.channel
    reach_hz = min(LEVELS.half_widths * half_width_hz, 0.9 * mode.frequency_hz)
    wide_hz = _wide_reach(mode, modes, half_width_hz, parts[0].sample_rate_hz)
    alike = [n for n, each in enumerate(channels) if each.unit == channels[channel].unit]
    row = np.zeros(len(channels))
    row[alike] = abs(mode.shape[channel]) * _filter_row(mode, modes, alike, reach_hz)
    derived = channels[channel].times_derived
    return ModeInRecord(
        mode,
        tuple(_lines(each, row, derived, mode.frequency_hz, wide_hz) for each in enough),
        reach_hz,
        wide_hz,
        ends_s,
        _moves_over_others(enough, mode, modes, alike),
    )


def _moves_over_others(
    parts: Sequence[Samples], mode: Mode, modes: Sequence[Mode], channels: Sequence[int]
) -> tuple[float, float]:
    """Return how much a mode moves over all others: displacement, velocity; mean squares."""
    others = [other for other in modes if other is not mode]
    if not others:
        return math.inf, math.inf
    derived = parts[0].channels[channels[0]].times_derived
    square = np.zeros(1 + len(others))
    for part in parts:
        n_rows = len(part.acceleration)
        hz: Real = np.asarray(np.fft.rfftfreq(n_rows, 1.0 / part.sample_rate_hz), float)
        power = np.zeros(len(hz))
        for channel in channels:
            power += np.abs(np.fft.rfft(part.widened(columns=[channel])[:, 0])) ** 2
        for n, each in enumerate((mode, *others)):
            f = each.frequency_hz
            reach_hz = max(LEVELS.peak_half_widths * each.damping_ratio * f, 1.0 / part.duration_s)
            inside = np.abs(hz - f) <= reach_hz
            square[n] += power[inside].sum() / (2.0 * np.pi * f) ** (2 * derived)
    times = square * np.array([each.frequency_hz for each in (mode, *others)]) ** 2
    return float(square[0] / square[1:].sum()), float(times[0] / times[1:].sum())


def _lines(samples: Samples, row: Real, derived: int, f_hz: float, reach_hz: float) -> _Lines:
    """Return what channels show together about a frequency, derived so often less."""
    modal = samples.widened() @ row
    lines = np.fft.rfft(modal - modal.mean())
    hz: Real = np.asarray(np.fft.rfftfreq(len(modal), 1.0 / samples.sample_rate_hz), float)
    inside = np.flatnonzero(np.abs(hz - f_hz) <= reach_hz)
    displacement = 2.0 * lines[inside] / (2j * np.pi * hz[inside]) ** derived
    return _Lines(hz[inside], displacement, len(modal), samples.sample_rate_hz)


def _wide_reach(
    mode: Mode, modes: Sequence[Mode], half_width_hz: float, sample_rate_hz: float
) -> float:
    """Return what the flanks of a peak are looked at to, on either side [Hz].

    As far as other modes and the ends of the spectrum leave room, and at least what the moments
    are taken of.
    """
    f = mode.frequency_hz
    room = [LEVELS.flank_share * f, 0.45 * sample_rate_hz - f]
    room += [
        abs(other.frequency_hz - f) - LEVELS.half_widths * other.damping_ratio * other.frequency_hz
        for other in modes
        if other is not mode
    ]
    least = min(LEVELS.half_widths * half_width_hz, 0.9 * f)
    return max(least, min(LEVELS.flank_half_widths * half_width_hz, *room))


def _filter_row(
    mode: Mode, modes: Sequence[Mode], channels: Sequence[int], reach_hz: float
) -> Real:
    """Return what channels are multiplied with to see one mode of those nearby, largest 1."""
    near = sorted(
        (
            other
            for other in modes
            if abs(other.frequency_hz - mode.frequency_hz)
            < reach_hz + LEVELS.half_widths * other.damping_ratio * other.frequency_hz
        ),
        key=lambda other: abs(other.frequency_hz - mode.frequency_hz),
    )
    shapes = np.column_stack(
        [other.shape.real[channels] for other in near[: max(1, len(channels) // 2)]]
    )
    return np.asarray(np.linalg.pinv(shapes, rcond=LEVELS.least_direction)[0])
