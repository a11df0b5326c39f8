"""Spectra of taps on one point, with what their finite length leaves out.

A segment holds a tap's response until the segment ends, and what former taps left.  At the lines
of its Fourier transform both are terms of the structure's own poles: a mode with pole p answers a
force F with a (F(ω) + u) / (jω - p), where

    u = -exp(pT) ∫ f exp(-pt) dt + (1 - exp(pT)) Σ of former taps f exp(-pt) dt,  t from the begin,

is known once the pole is.  So no window is needed, and none biases the damping.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.fft import irfft, rfft, rfftfreq

from impact_testing.record import ImpactRecord, Run
from impact_testing.taps import begin_of, FILTER_SAMPLES, ForceLevel, JudgedTap, Tap
from modal_core.units import TIMES_DERIVED

Complex = NDArray[np.complex128]
Real = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Pulse:
    """Force of one tap.

    Parameters
    ----------
    first : int
        Row.
    force_n : (n,) array [N]
        From there on.
    """

    first: int
    force_n: Real

    def transform(self, pole: Complex, rate_hz: float) -> Complex:
        """Return ∫ f exp(-pt) dt of some poles, t from its first row; (n_poles,) array [N s]."""
        time_s = np.arange(len(self.force_n)) / rate_hz
        return np.asarray(np.exp(-pole[:, None] * time_s) @ self.force_n / rate_hz)

    def earlier(self, seconds: float, rate_hz: float) -> 'Pulse':
        """Return the force that comes earlier by so much, interpolated as it is band-limited.

        Its window has quiet samples on either side for that.
        """
        n = len(self.force_n)
        turn = np.exp(2j * np.pi * rfftfreq(n, 1.0 / rate_hz) * seconds)
        return Pulse(self.first, np.asarray(irfft(rfft(self.force_n) * turn, n)))


@dataclass(frozen=True, slots=True)
class PointSpectra:
    """Spectra of the good taps of one record.

    Parameters
    ----------
    record : ImpactRecord
        They are of.
    taps : tuple of JudgedTap
        All taps of the record; the good ones take part.
    pulses : tuple of Pulse
        Their force.
    length_s : float [s]
        Of the segments.
    decay_1_s : float [1/s]
        Of an exponential window on force and responses; 0: none.
    corner_1_s : float [rad/s]
        Of a high-pass of the responses that was undone; 0: none.
    frequency_hz : (n_lines,) array [Hz]
        Lines, without the one at zero.
    force : (n_taps, n_lines) complex array [N s]
        Spectra of the force.
    motion : (n_taps, n_lines, n_channels) complex array [m/s]
        Spectra of the responses, differentiated or integrated to accelerations.
    force_noise_n : float [N]
        Standard deviation of what the force channel reads without a tap.
    """

    record: ImpactRecord
    taps: tuple[JudgedTap, ...]
    pulses: tuple[Pulse, ...]
    length_s: float
    decay_1_s: float
    corner_1_s: float
    frequency_hz: Real
    force: Complex
    motion: Complex
    force_noise_n: float

    @classmethod
    def of(
        cls,
        record: ImpactRecord,
        taps: Sequence[JudgedTap],
        length_s: float,
        decay_1_s: float = 0.0,
        corner_1_s: float = 0.0,
    ) -> 'PointSpectra':
        """Transform the segments of the good taps."""
        level = _levels(record)
        pulses = _pulses_as_read(record, taps, level)
        rate_hz, window = record.rate_hz, _window(decay_1_s, length_s, record.rate_hz)
        n_rows = len(window)
        frequency = rfftfreq(n_rows, 1.0 / rate_hz)[1:]
        good = [pulse for pulse, each in zip(pulses, taps, strict=True) if each.good]
        motions = []
        for pulse in good:
            begin = pulse.first
            rows = record.responses.widened(slice(begin, begin + n_rows))
            if corner_1_s:
                run = record.run_of(begin)
                rows = rows - record.responses.widened(slice(run.first, run.end)).mean(axis=0)
                rows = rows + corner_1_s * _integral(rows, rate_hz)
            else:
                rows = rows - _rest(record, begin, rows)
            motions.append(rfft(rows * window[:, None], axis=0)[1:] / rate_hz)
        times = [2 - TIMES_DERIVED[channel.unit] for channel in record.responses.channels]
        to_acceleration = (2j * np.pi * frequency[:, None]) ** np.array(times)
        return cls(
            record=record,
            taps=tuple(taps),
            pulses=pulses,
            length_s=n_rows / rate_hz,
            decay_1_s=decay_1_s,
            corner_1_s=corner_1_s,
            frequency_hz=frequency,
            force=_force_spectra(good, window, rate_hz),
            motion=np.asarray(motions) * to_acceleration,
            force_noise_n=float(np.sqrt(np.mean([each.noise_n**2 for each in level.values()]))),
        )

    def with_corner(self, corner_1_s: float) -> 'PointSpectra':
        """Return the spectra of responses without a high-pass they passed."""
        return PointSpectra.of(self.record, self.taps, self.length_s, self.decay_1_s, corner_1_s)

    def as_read(self) -> 'PointSpectra':
        """Return the spectra with the forces as their sensor read them."""
        return self.with_force(_pulses_as_read(self.record, self.taps, _levels(self.record)))

    def with_force(self, pulses: Sequence[Pulse]) -> 'PointSpectra':
        """Return the same responses to other forces of the taps."""
        good = [pulse for pulse, each in zip(pulses, self.taps, strict=True) if each.good]
        window = _window(self.decay_1_s, self.length_s, self.record.rate_hz)
        force = _force_spectra(good, window, self.record.rate_hz)
        return replace(self, pulses=tuple(pulses), force=force)

    @property
    def n_taps(self) -> int:
        """How many taps take part."""
        return len(self.force)

    @property
    def names(self) -> tuple[str, ...]:
        """Channels."""
        return self.record.responses.channel_names

    @property
    def correlation(self) -> float:
        """By how much an exponential window widens variances: its lines are not independent."""
        if not self.decay_1_s:
            return 1.0
        spent = self.decay_1_s * self.length_s
        fourth = (1.0 - np.exp(-4.0 * spent)) / (4.0 * spent)
        return float(fourth / ((1.0 - np.exp(-2.0 * spent)) / (2.0 * spent)) ** 2)

    def ends(self, pole: Complex) -> Complex:
        """Return u of every tap and windowed pole, (n_taps, n_poles) array [N s]."""
        rate_hz = self.record.rate_hz
        # e^{-pt} of a windowed force is that of the force with the true pole.
        true = pole + self.decay_1_s
        left = np.exp(pole * self.length_s)
        former, begin, found = np.zeros(len(pole), complex), 0, []
        for pulse, each in zip(self.pulses, self.taps, strict=True):
            # What former taps left goes on as the poles do, to the end of its recording.
            if begin < self.record.run_of(pulse.first).first:
                former, begin = np.zeros(len(pole), complex), pulse.first
            former = former * np.exp(true * ((pulse.first - begin) / rate_hz))
            begin = pulse.first
            own = pulse.transform(true, rate_hz)
            if each.good:
                found.append((1.0 - left) * former - left * own)
            former = former + own
        return np.asarray(found)

    def free_motion(
        self, pole: Complex, amplitude: Complex, lines: slice = slice(None)
    ) -> Complex:
        """Return what the ends of the segments add, (n_taps, n_lines, n_channels) array [m/s].

        Parameters
        ----------
        pole : (n_poles,) complex array [rad/s]
        amplitude : (n_poles, n_channels) complex array
            In accelerances.
        lines : slice
            Of the spectra.
        """
        windowed = pole - self.decay_1_s
        s = 2j * np.pi * self.frequency_hz[lines, None]
        # The force is real, so that the ends of a conjugate are the conjugates of the ends.
        ends = self.ends(windowed)
        upper = np.einsum('kp,lp,pc->klc', ends, 1.0 / (s - windowed), amplitude, optimize=True)
        bell = 1.0 / (s - windowed.conj())
        conjugates = ends.conj(), bell, amplitude.conj()
        return np.asarray(upper + np.einsum('kp,lp,pc->klc', *conjugates, optimize=True))


def _levels(record: ImpactRecord) -> dict[Run, ForceLevel]:
    """Return what the force channel reads without taps, run by run."""
    return {run: ForceLevel.of(record.force_n[run.first : run.end]) for run in record.runs}


def _pulses_as_read(
    record: ImpactRecord, taps: Sequence[JudgedTap], level: Mapping[Run, ForceLevel]
) -> tuple[Pulse, ...]:
    rest_n = [level[record.run_of(each.tap.first)].rest_n for each in taps]
    return tuple(pulse_of(record, each.tap, rest) for each, rest in zip(taps, rest_n, strict=True))


def pulse_of(record: ImpactRecord, tap: Tap, rest_n: float) -> Pulse:
    """Return the force of a tap without what it reads at rest: the window of the force."""
    end = record.run_of(tap.first).end
    first, last = begin_of(record, tap), min(end, tap.last + FILTER_SAMPLES + 1)
    return Pulse(first, record.sign * (record.force_n[first:last] - rest_n))


def _window(decay_1_s: float, length_s: float, rate_hz: float) -> Real:
    """Return the exponential window of a segment."""
    return np.asarray(np.exp(-decay_1_s * np.arange(round(length_s * rate_hz)) / rate_hz))


def _force_spectra(pulses: Iterable[Pulse], window: Real, rate_hz: float) -> Complex:
    """Return the spectra of forces, each from the begin of its segment."""
    return np.asarray(
        [rfft(p.force_n * window[: len(p.force_n)], len(window))[1:] / rate_hz for p in pulses]
    )


def _integral(rows: Real, rate_hz: float) -> Real:
    """Return the integral of rows over time, by trapezia, 0 at the first."""
    return np.asarray((np.cumsum(rows, axis=0) - 0.5 * (rows + rows[:1])) / rate_hz)


def _rest(record: ImpactRecord, begin: int, rows: Real) -> Real:
    """Return what the channels read before the tap: gravity and offsets."""
    earliest = max(record.run_of(begin).first, begin - round(0.25 * record.rate_hz))
    before = record.responses.widened(slice(earliest, begin))
    return np.asarray((before if len(before) > 8 else rows).mean(axis=0))
