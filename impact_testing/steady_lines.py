"""Lines that do not begin with the tap: hum of the mains, a fan, a pump.

What a tap excites is quiet before it; a line is not.  So a line is looked for in the rest before
the first tap, in the force and in the responses.  Its phase goes on through the record, common to
all channels, and is followed by short blocks that count by how quiet they are beside the line: the
ringing of modes, however near, has no say.  Then the line is taken out of the samples.

The frequency of grids and motors wanders: a random walk, how fast says the record.  What is taken
out is the mean of what the line may be: where the phase is not known, nothing.

References
----------
Rasmussen and Williams (2006), Gaussian Processes for Machine Learning, sections 2.2 and 5.4.1.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import chain

import numpy as np
from numpy.typing import NDArray
from scipy.fft import fft, fftfreq, irfft, next_fast_len, rfft
from scipy.linalg import solve_toeplitz
from scipy.signal import lfilter

from impact_testing.phase_course import course_of
from impact_testing.record import ImpactRecord, runs_of, together
from impact_testing.taps import begin_of, FILTER_SAMPLES, find_taps, Tap
from modal_core.numbers.chance import fisher_tail
from modal_core.numbers.tapers import hann

Complex = NDArray[np.complex128]
Real = NDArray[np.float64]
BLOCK_S = 0.25
"""In which a structure rings alike, and a line of 8 Hz has two periods.  Half, this and twice as
long leave 0.46, 0.35 and 1.1 of the noise near lightly damped modes (seeds 900730 to 900737)."""
LEAST_REST_S = 2.0 * BLOCK_S
"""Before the first tap: two blocks."""
CHANCE = 1e-3
"""Of a record in which noise is taken for a line: little is lost, for what is taken out is no more
than the rest before the tap has of it."""
BESIDE, LOBE = 16, 3
"""Spectral lines on either side that are the background of one; those next to it are its own.  8
and 32 find and leave the same."""
AROUND = 2 * (BESIDE - LOBE)
INDEPENDENT = 0.5
"""Share of neighbouring lines that are independent under the taper: 0.51, for powers of
neighbours correlate by 4/9, and of the ones after by 1/36."""
FINER = 8
"""Steps from one spectral line of the record to the next in which a frequency is looked for; with
one, two lines of 24 near lightly damped modes are refused (seeds 900730 to 900737)."""
MOST_LINES = 16
"""Bounds the work on a record, whatever is in it."""
ORDER = 2 * MOST_LINES
"""Samples that let expect the next: two for each line."""
ROUNDS = 4
"""Of weights and course: 2 and 4 leave 0.75 and 0.09 of the noise within ringing."""
WANDER = (0.0, *(2.0 * np.pi * 10.0 ** np.arange(-4.0, -1.9)).tolist())
"""Of the frequency, that are tried [rad/s per √s]; grids have some mHz.  None, these, and twice as
many leave 1.3, 0.09 and 0.10 of the noise in the worst channel (rms of six tests, 900814 to
900819, as all that follow)."""
STRAY = 0.01
"""Share of its own power that a line may leave without being taken for ringing, while its phase
is not yet known: with none, lines within ringing leave 0.17 of the noise, so 0.09."""
QUIET, GOES_ON = 4.0, 0.25
"""A block rings from so many times the noise on; 2, 4 and 8 leave the same.  After the first tap,
where a channel has less than so many times the power of the line, less than the share of it must
differ from the line, a median: a mode that the floor shakes has other amplitudes and phases there.
With 2, 4 and 8 times four, one and no mode that the floor shakes (0.08 to 0.4 % damping, six
tests) is taken for a line, and 75, 71 and 67 lines of 72 are; with shares of 0.1, 0.25, 0.5 and
any none, one, one and six, and 67, 71, 73 and 77."""


@dataclass(frozen=True, slots=True)
class Cleared:
    """A record without its lines.

    Parameters
    ----------
    record : ImpactRecord
        The same one where there is no line.
    taken_hz : tuple of float [Hz]
        What was taken out.
    left_hz : tuple of float [Hz]
        What is there before the first tap and is not known behind it: left in.
    too_soon_hz : tuple of float [Hz]
        The strongest line of the force, of a record without rest before the first tap: left in.
    """

    record: ImpactRecord
    taken_hz: tuple[float, ...] = ()
    left_hz: tuple[float, ...] = ()
    too_soon_hz: tuple[float, ...] = ()


def without_steady_lines(record: ImpactRecord) -> Cleared:
    """Take lines out of the force and the responses; their phases begin anew with each run.

    Parameters
    ----------
    record : ImpactRecord
    """
    if len(record.runs) == 1:
        return _without(record)
    each = [_without(run) for run in runs_of(record)]
    return Cleared(
        together([one.record for one in each]),
        _in_any(one.taken_hz for one in each),
        _in_any(one.left_hz for one in each),
        _in_any(one.too_soon_hz for one in each),
    )


def _in_any(lines_hz: Iterable[tuple[float, ...]]) -> tuple[float, ...]:
    return tuple(sorted(set(chain.from_iterable(lines_hz))))


def _without(record: ImpactRecord) -> Cleared:
    taps = (*find_taps(record.force_n, record.rate_hz), *_taps_under_lines(record))
    rest = min((begin_of(record, each) for each in taps), default=0)
    apart = _apart_from(record, taps)
    least = max(LEAST_REST_S * record.rate_hz, 8 * BESIDE)
    if rest < least:
        quiet = record.force_n[_longest(apart)]
        alone = quiet[:, None] - quiet.mean()
        found = _strongest(alone, record.rate_hz, ()) if len(quiet) >= least else None
        return Cleared(record, too_soon_hz=() if found is None else (found,))
    rows = np.column_stack([record.force_n, record.responses.widened()])
    left, lines = rows - rows[:rest].mean(axis=0), list[_Line]()
    refused = list[float]()
    while len(lines) + len(refused) < MOST_LINES:
        at_hz = _strongest(left[:rest], record.rate_hz, refused + [each.at_hz for each in lines])
        if at_hz is None:
            break
        line = _Line.of(left, at_hz, rest, apart, record.rate_hz)
        if line.goes_on:
            lines.append(line)
            left = left - line.samples()
        else:
            refused.append(at_hz)
    if not lines:
        return Cleared(record, left_hz=tuple(sorted(refused)))
    for number, each in enumerate(lines):
        # Strong ones hid some of the weak ones.
        with_it = left + each.samples()
        lines[number] = _Line.of(with_it, each.at_hz, rest, apart, record.rate_hz)
        left = with_it - lines[number].samples()
    left += rows[:rest].mean(axis=0)
    responses = replace(record.responses, acceleration=left[:, 1:])
    return Cleared(
        replace(record, force_n=left[:, 0], responses=responses),
        tuple(sorted(each.mean_hz for each in lines)),
        tuple(sorted(refused)),
    )


def _taps_under_lines(record: ImpactRecord) -> tuple[Tap, ...]:
    """Return the taps of a force less what the samples before each let expect: lines, no taps.

    A line of a sixth of a tap hides it, where the taps alone are looked for.
    """
    force = record.force_n - np.median(record.force_n)
    power = np.abs(rfft(force, 2 * len(force))) ** 2
    lags = irfft(power)[: ORDER + 1]
    if len(force) <= ORDER or lags[0] <= 0.0:
        return ()
    lags[0] *= 1.0 + 1e-9
    expected = lfilter([0.0, *solve_toeplitz(lags[:-1], lags[1:])], [1.0], force)
    new = force - expected
    new[:ORDER] = 0.0
    return find_taps(new, record.rate_hz)


def _longest(apart: NDArray[np.bool_]) -> slice:
    """Return the longest stretch between taps."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], apart, [False]]).astype(int)))
    first, end = edges[::2], edges[1::2]
    best = int(np.argmax(end - first)) if len(first) else 0
    return slice(int(first[best]), int(end[best])) if len(first) else slice(0, 0)


def _apart_from(record: ImpactRecord, taps: Sequence[Tap]) -> NDArray[np.bool_]:
    """Return which samples of the force are no part of a tap."""
    apart = np.ones(len(record.force_n), dtype=bool)
    for each in taps:
        apart[begin_of(record, each) : each.last + FILTER_SAMPLES + 1] = False
    return apart


@dataclass(frozen=True)
class _Line:
    """A line in samples.

    Parameters
    ----------
    at_hz : float [Hz]
        Its frequency in the rest before the first tap.
    rate_hz : float [Hz]
        Of the samples.
    phase : (n_samples,) array [rad]
    phasor : (n_channels,) complex array
    known : (n_samples,) array
        Mean cosine of what the phase may be off; 1: it is known.
    goes_on : bool
        Whether it is seen after the first tap as well.
    """

    at_hz: float
    rate_hz: float
    phase: Real
    phasor: Complex
    known: Real
    goes_on: bool

    @property
    def mean_hz(self) -> float:
        """Frequency, the mean over the record [Hz]."""
        turns = (self.phase[-1] - self.phase[0]) / (2.0 * np.pi)
        return float(turns * self.rate_hz / (len(self.phase) - 1))

    def samples(self) -> Real:
        """Return the line alone, (n_samples, n_channels) array."""
        wave = self.known * np.exp(1j * self.phase)
        return np.outer(wave.real, self.phasor.real) - np.outer(wave.imag, self.phasor.imag)

    @classmethod
    def of(
        cls, rows: Real, at_hz: float, rest: int, apart: NDArray[np.bool_], rate_hz: float
    ) -> '_Line':
        """Follow a line through samples, the force first.

        Parameters
        ----------
        rows : (n_samples, n_channels) array
        at_hz : float [Hz]
            Where it is in the rest.
        rest : int
            Rows before the first tap.
        apart : (n_samples,) bool array
            Samples of the force that are no part of a tap.
        rate_hz : float [Hz]
        """
        blocks = _Blocks.of(rows, at_hz, rest, apart, rate_hz)
        weight = blocks.weight(blocks.as_in_rest())
        phase = 2.0 * np.pi * blocks.common_hz(weight, rate_hz / rest) * blocks.time_s
        uncertain = np.zeros(len(phase))
        for number in range(ROUNDS):
            wave = np.exp(1j * phase - 0.5 * uncertain)[:, None]
            size = np.sum(weight * np.abs(wave) ** 2, axis=0)
            phasor = np.sum(weight * wave.conj() * blocks.phasor, axis=0) / size
            tells = weight * np.abs(phasor) ** 2
            if number == 0:
                # A channel that tells of few blocks has no say in how these lie to the others.
                tells = tells * _widest(tells)
            strength = np.maximum(tells.sum(axis=1), 1e-9)
            heard = np.where(phasor == 0.0, 1.0, phasor)
            seen = blocks.phasor * np.exp(-1j * phase)[:, None] / heard
            turn = np.sum(tells * seen.imag, axis=1) / strength
            phase, uncertain = course_of(blocks.step_s, phase + turn, 0.5 / strength, WANDER)
            # Only a line whose phase is followed tells what rings.
            weight = blocks.weight(np.exp(1j * phase - 0.5 * uncertain)[:, None] * phasor)
        line = np.exp(1j * phase - 0.5 * uncertain)[:, None] * phasor
        time_s, middle_s = np.arange(len(rows)) / rate_hz, blocks.time_s
        # Beyond the middles of the first and the last block it goes on as it does on the whole.
        slope = (phase[-1] - phase[0]) / (middle_s[-1] - middle_s[0])
        carried = slope * time_s + np.interp(time_s, middle_s, phase - slope * middle_s)
        return cls(
            at_hz=at_hz,
            rate_hz=rate_hz,
            phase=2.0 * np.pi * at_hz * time_s + carried,
            phasor=phasor,
            known=np.exp(-0.5 * np.interp(time_s, middle_s, uncertain)),
            goes_on=blocks.goes_on(line),
        )


@dataclass(frozen=True)
class _Blocks:
    """What samples have of a frequency, block by block; each overlaps with the next by half.

    Parameters
    ----------
    time_s : (n_blocks,) array [s]
        Of their middles.
    phasor : (n_blocks, n_channels) complex array
        Turned back by the frequency.
    quiet : int
        Blocks before the first tap.
    noise : (n_channels,) array
        Mean square of what is no line, in the rest before the first tap.
    used : (n_blocks,) bool array
        Blocks of the force that are no part of a tap.
    """

    time_s: Real
    phasor: Complex
    quiet: int
    noise: Real
    used: NDArray[np.bool_]

    @property
    def step_s(self) -> float:
        """From one block to the next [s]."""
        return float(self.time_s[1] - self.time_s[0])

    @classmethod
    def of(
        cls, rows: Real, at_hz: float, rest: int, apart: NDArray[np.bool_], rate_hz: float
    ) -> '_Blocks':
        """Cut samples into blocks."""
        length = 2 * round(0.5 * BLOCK_S * rate_hz)
        first = np.arange(0, len(rows) - length + 1, length // 2)
        taper = hann(length)[:, None] * (2.0 / length / hann(length).mean())
        turn = np.exp(-2j * np.pi * at_hz / rate_hz * np.arange(len(rows)))[:, None]
        phasor = [
            np.sum(taper * turn[n : n + length] * rows[n : n + length], axis=0)
            for n in first.tolist()
        ]
        used = np.array([apart[n : n + length].all() for n in first.tolist()])
        middle = np.asarray((first + 0.5 * length) / rate_hz, dtype=np.float64)
        quiet = int(np.sum(first + length <= rest))
        line = np.array([round(at_hz * rest / rate_hz)])
        noise = _beside(_spectrum(rows[:rest]), line)[0] * np.sum(taper**2)
        return cls(middle, np.array(phasor), quiet, noise, used)

    def as_in_rest(self) -> Complex:
        """Return a line of its size before the first tap, its phase that of each block."""
        square = np.mean(np.abs(self.phasor[: self.quiet]) ** 2, axis=0) - self.noise
        turn = self.phasor / np.maximum(np.abs(self.phasor), 1e-300)
        return np.asarray(np.sqrt(np.maximum(square, 0.0)) * turn)

    def weight(self, line: Complex) -> Real:
        """Return one over the power of what a line leaves, (n_blocks, n_channels) array.

        Of noise there is as much as in the rest before the first tap, and structure rings in all
        responses at once.  It rings alike in one block after the other, so that what it does to
        the mean of many is as large as what it does to one.
        """
        power = np.abs(self.phasor - line) ** 2
        level = np.maximum(self.noise, 1e-12 * power.mean(axis=0) + 1e-300)
        over = np.maximum(power / level, 1.0)
        heard = over[:, 1:].mean(axis=1)
        # A line that is not yet followed well leaves a part of itself.
        stray = STRAY * np.mean(np.abs(line[:, 1:]) ** 2 / level[1:], axis=1)
        rings = len(over) * np.maximum(heard - QUIET - stray, 0.0)
        course = np.column_stack([over[:, 0], *[heard + rings] * (over.shape[1] - 1)])
        weight = 1.0 / (course * level)
        weight[~self.used, 0] = 0.0
        return np.asarray(weight)

    def goes_on(self, line: Complex) -> bool:
        """Tell whether a line is seen in the quiet blocks after the first tap."""
        power, left = np.abs(self.phasor) ** 2, np.abs(self.phasor - line) ** 2
        noise, size = left[: self.quiet].mean(axis=0), np.abs(line) ** 2
        told = (size > QUIET * noise) & (power < QUIET * size)
        told[: self.quiet] = False
        told[~self.used, 0] = False
        share = ((left - noise) / np.maximum(size, 1e-300))[told]
        return len(share) > self.quiet and float(np.median(share)) < GOES_ON

    def common_hz(self, weight: Real, reach_hz: float) -> float:
        """Return the offset in frequency that the blocks have in common [Hz]."""
        n_offsets = next_fast_len(FINER * len(self.time_s))
        turned = fft(weight * self.phasor, n_offsets, axis=0)
        power = np.sum(np.abs(turned) ** 2 / weight.sum(axis=0), axis=1)
        offset_hz = fftfreq(n_offsets, self.step_s)
        power[np.abs(offset_hz) > reach_hz] = 0.0
        return float(offset_hz[int(np.argmax(power))])


def _widest(tells: Real) -> NDArray[np.bool_]:
    """Return which channels tell the phase in nearly as many blocks as any."""
    blocks = np.sum(tells > 1.0, axis=0)
    return np.asarray(blocks >= 0.9 * blocks.max())


def _spectrum(rest: Real) -> Real:
    """Return the power of each line of a stretch, of white noise its mean square."""
    taper = hann(len(rest))
    return np.asarray(np.abs(rfft(taper[:, None] * rest, axis=0)) ** 2 / np.sum(taper**2))


def _beside(power: Real, lines: NDArray[np.int64]) -> Real:
    """Return the mean power beside lines, by the median, (n_lines, n_channels) array.

    Towards the ends of a spectrum there are more of them on the other side.
    """
    first = np.clip(lines - BESIDE, LOBE, len(power) - 1 - 2 * BESIDE)
    near = first[:, None] + np.arange(2 * BESIDE + 1)
    near = near[np.abs(near - lines[:, None]) > LOBE].reshape(len(lines), AROUND)
    return np.asarray(np.median(power[near], axis=1) / np.log(2.0))


def _strongest(rest: Real, rate_hz: float, told_hz: Sequence[float]) -> float | None:
    """Return the line of a stretch that stands out most, None where none does [Hz]."""
    power = _spectrum(rest)
    lowest = max(2 * LOBE, round(2.0 / BLOCK_S * len(rest) / rate_hz))
    lines = np.arange(lowest, len(power) - LOBE)
    floor = 1e-24 * power.max(axis=0) + 1e-300
    ratio = power[lines] / np.maximum(_beside(power, lines), floor)
    for each in told_hz:
        ratio[np.abs(lines * rate_hz / len(rest) - each) < LOBE * rate_hz / len(rest)] = 0.0
    line, channel = np.unravel_index(int(np.argmax(ratio)), ratio.shape)
    chance = fisher_tail(float(ratio[line, channel]), 2.0, 2.0 * INDEPENDENT * AROUND)
    if float(chance) * ratio.size > CHANCE:
        return None
    return float(lines[line] * rate_hz / len(rest))
