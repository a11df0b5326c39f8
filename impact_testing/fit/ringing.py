"""Where a mode that rings on from tap to tap is: by what differs between the taps, too.

What former taps left reaches every tap with a phase of its own, that of the pole times the time
between them.  The mean over the taps, the FRF, tells little of it: it has many summits beside each
other, and a climb from a neighbouring one ends there.  So poles that ring on are looked for once
on a grid as fine as the taps together can tell, tap by tap.

Of twenty random structures of 0.05 to 0.3 %, taps 2 to 6 s apart, 90 modes, 21 had been missed and
seven were none; now six are missed and none is false.  Of thirty others, that nothing was made on,
31 of 131 were missed and now 12 of 137; eight were none and now ten, which have no deviations.
How sure they are: ``TOLD_DECAY``.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from impact_testing.fit.free_fit import free_fit
from impact_testing.fit.modal_model import synthesised
from impact_testing.responses import PointData

Complex = NDArray[np.complex128]
Real = NDArray[np.float64]
RINGS_ON = 4.0
"""Decay over a segment beyond which a mode has ended when the next tap comes: e⁻⁴ is 2 %."""
DECAYS = tuple(0.05 * 1.6 ** np.arange(10))
"""Over a segment, of trial poles up to that; between two of these a bell overlaps with the nearer
by more than nine tenths, as between two of the frequencies."""
LINES_OFF = 2.0
"""A pole to begin with is wrong by no more."""
LINES_SEEN = 10
"""On either side of it: of a bell so sharp all that matters."""
ROUNDS = 3
"""Of going through the poles; neighbours move each other."""


def without_ringing(data: PointData, pole: Complex, amplitude: Complex) -> PointData:
    """Take what former taps left out of the noise, as far as poles explain it.

    Where these are wrong the noise is not less, and stays as it is: weights of a wrong pole would
    say that it is right.
    """
    fresh = data.reweighted(pole, amplitude)
    return fresh if fresh.log_noise < data.log_noise else data


def tuned(data: Sequence[PointData], pole: Complex) -> tuple[list[PointData], Complex]:
    """Return the poles where all taps together say that they are, and the noise without them.

    Parameters
    ----------
    data : sequence of PointData
    pole : (n_poles,) complex array [rad/s]
        All there are; those that have decayed before the next tap stay.
    """
    now, pole = list(data), pole.copy()
    for _ in range(ROUNDS):
        before = pole.copy()
        for number in np.flatnonzero(rings_on(now, pole)).tolist():
            free = free_fit(now, pole)
            others = np.delete(np.arange(len(pole)), number)
            left = [
                _Left.of(each, pole[others], point.amplitude[others], complex(pole[number]))
                for each, point in zip(now, free, strict=True)
            ]
            trial = np.append(_trials(now, complex(pole[number])), pole[number])
            gain = sum((each.gain(trial) for each in left), np.zeros(len(trial)))
            pole[number] = trial[int(np.argmax(gain))]
        free = free_fit(now, pole)
        now = [
            without_ringing(each, pole, point.amplitude)
            for each, point in zip(now, free, strict=True)
        ]
        if np.array_equal(before, pole):
            break
    return now, pole


def rings_on(data: Sequence[PointData], pole: Complex) -> NDArray[np.bool_]:
    """Tell which poles have not decayed when the next tap comes."""
    return np.asarray(-pole.real * data[0].frf.spectra.length_s < RINGS_ON)


def _trials(data: Sequence[PointData], near: complex) -> Complex:
    """Return poles about one."""
    length_s = data[0].frf.spectra.length_s
    reach = 2.0 * np.pi * LINES_OFF / length_s
    found = [np.empty(0, dtype=complex)]
    for decay in np.array(DECAYS) / length_s:
        steps = np.arange(-np.ceil(reach / (0.7 * decay)), np.ceil(reach / (0.7 * decay)) + 1)
        found.append(-decay + 1j * (near.imag + 0.7 * decay * steps))
    trial = np.concatenate(found)
    return np.asarray(trial[trial.imag > 2.0 * np.pi / length_s])


@dataclass(frozen=True)
class _Left:
    """What other modes leave of the taps on one point, near a pole.

    Parameters
    ----------
    data : PointData
    lines : slice
        Of the band.
    weight : (n_lines,) array
        Of squares.
    left : (n_taps, n_lines, n_channels) complex array
        Over the level of the noise of each channel.
    """

    data: PointData
    lines: slice
    weight: Real
    left: Complex

    @classmethod
    def of(cls, data: PointData, pole: Complex, amplitude: Complex, near: complex) -> '_Left':
        at = int(np.searchsorted(data.frequency_hz, near.imag / (2.0 * np.pi)))
        lines = slice(max(0, at - LINES_SEEN), at + LINES_SEEN + 1)
        spectra = data.frf.spectra
        left = spectra.motion[:, data.lines] - spectra.free_motion(pole, amplitude, data.lines)
        direct = synthesised(data, pole, amplitude)
        left = left - spectra.force[:, data.lines, None] * direct
        power = data.course * data.frf.force_power[data.lines]
        scaled = left[:, lines] / np.sqrt(data.level)
        return cls(data, lines, 1.0 / power[lines], scaled)

    def gain(self, trial: Complex) -> Real:
        """Return the sum of squares that each trial pole explains, all channels free."""
        spectra = self.data.frf.spectra
        windowed = trial - spectra.decay_1_s
        s = 2j * np.pi * self.data.frequency_hz[self.lines, None]
        force = spectra.force[:, self.data.lines][:, self.lines]
        bell = force[:, :, None] + spectra.ends(windowed)[:, None, :]
        bell = bell / (s - windowed)
        seen = np.einsum('klt,l,klc->tc', bell.conj(), self.weight, self.left, optimize=True)
        size = np.einsum('klt,l->t', np.abs(bell) ** 2, self.weight, optimize=True)
        return np.asarray(np.sum(np.abs(seen) ** 2, axis=1) / size)
