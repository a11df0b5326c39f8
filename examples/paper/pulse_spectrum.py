"""Fig. 10: more pulses give more energy; a pulse of 3 ms reaches to 333 Hz.

And the pulses a real arm can make?

Run ``python -m examples.paper.pulse_spectrum``.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from abb_emulator.drives import Servo, ServoSettings
from examples.paper.cell import HIGHEST_HZ, plan_pulses, robot, SAMPLE_RATE_HZ
from examples.paper.drawing import COLOURS, GREY, panels, save
from examples.paper.output import (
    Finding,
    NOT_REPRODUCED,
    REPRODUCED,
    say,
    show_findings,
    show_table,
)
from excitation_planner.motion.pulses import rectangular_train
from excitation_planner.motion.spectrum import predicted_spectrum, PredictedSpectrum

Array = NDArray[np.float64]
SEED = 2025
COUNTS = (1, 8, 22)
WIDTH, N_SAMPLES, RATE_HZ = 3, 1000, 1000.0
N_RUNS = 200
SECTION = '1 Pulses'


@dataclass(frozen=True)
class Density:
    """Of n pulses, averaged over many draws."""

    n_pulses: int
    signal: Array
    frequency_hz: Array
    density: Array

    def mean_between(self, low_hz: float, high_hz: float) -> float:
        """Return the mean density of a band."""
        inside = (self.frequency_hz >= low_hz) & (self.frequency_hz <= high_hz)
        return float(self.density[inside].mean())

    @property
    def energy(self) -> float:
        """Of one second: the sum of squares over the rate."""
        return float(np.sum(self.signal**2) / RATE_HZ)

    @property
    def expected(self) -> Array:
        """Of n independent rectangles in 1 s: n times twice the square of one's transform."""
        phase = np.pi * np.maximum(self.frequency_hz, 1e-6) / RATE_HZ
        return np.asarray(
            2.0 * self.n_pulses * (np.sin(WIDTH * phase) / np.sin(phase) / RATE_HZ) ** 2
        )

    @property
    def notch_hz(self) -> float:
        """The deepest point between 200 and 450 Hz."""
        inside = (self.frequency_hz >= 200.0) & (self.frequency_hz <= 450.0)
        return float(self.frequency_hz[inside][np.argmin(self.density[inside])])


def densities(n_runs: int = N_RUNS) -> list[Density]:
    """Draw the paper's trains and estimate their spectra by Welch's method."""
    found = []
    for n_pulses in COUNTS:
        trains = [
            rectangular_train(n_pulses, WIDTH, N_SAMPLES, np.random.default_rng([SEED, run]))
            for run in range(n_runs)
        ]
        spectra = [predicted_spectrum(train[:, None], 1.0 / RATE_HZ, 1.0) for train in trains]
        density = np.mean([spectrum.density[:, 0] for spectrum in spectra], axis=0)
        found.append(Density(n_pulses, trains[0], spectra[0].frequency_hz, density))
    return found


@dataclass(frozen=True)
class RealPulses:
    """What the arm's own pulses contain: as planned, and behind the drives."""

    half_range_deg: float
    planned: PredictedSpectrum
    driven: PredictedSpectrum


def real_pulses(half_range_deg: float, duration_s: float = 60.0) -> RealPulses:
    """Plan pulses at the zero pose and let the drives follow them."""
    model = robot()
    plan = plan_pulses(model, 'P2', -half_range_deg, half_range_deg, SEED, duration_s)
    motion = plan.trajectory
    servo = Servo(ServoSettings(), np.zeros(6), 1.0 / SAMPLE_RATE_HZ)
    times = np.arange(0.0, motion.duration_s, 1.0 / SAMPLE_RATE_HZ)
    command_deg = np.degrees(model.to_controller(motion.at(times).position))
    driven = np.radians(servo.advance(command_deg).acceleration_deg_s2)
    return RealPulses(
        half_range_deg,
        predicted_spectrum(model.to_controller(motion.acceleration), motion.sample_period_s),
        predicted_spectrum(driven, 1.0 / SAMPLE_RATE_HZ),
    )


def tabulate(found: list[Density], real: list[RealPulses]) -> None:
    one = found[0].mean_between(10.0, 200.0)
    show_table(
        f'Fig. 10: n rectangular pulses of 3 ms in 1 s, mean of {N_RUNS} draws, seed {SEED}',
        ('n', 'energy [s]', '10-200 Hz [1/Hz]', 'against n = 1', 'half at [Hz]', 'notch [Hz]'),
        [
            (
                each.n_pulses,
                f'{each.energy:.4f}',
                f'{each.mean_between(10.0, 200.0):.2e}',
                f'{each.mean_between(10.0, 200.0) / one:.2f}',
                f'{_half_hz(each):.0f}',
                f'{each.notch_hz:.0f}',
            )
            for each in found
        ],
        keep='pulses',
    )
    rows = []
    for each in real:
        for name, spectrum in (('planned', each.planned), ('behind the drives', each.driven)):
            mean = np.mean(spectrum.at(np.array([10.0, 20.0, 40.0, 60.0])), axis=1)
            rows.append(
                (
                    f'±{each.half_range_deg:g}° {name}',
                    '{:.1f} to {:.1f}'.format(*spectrum.excited_band_hz()),
                    *(f'{10 * np.log10(value / mean[0]):.0f}' for value in mean),
                )
            )
    show_table(
        'Pulses the arm can make (all axes, 280 deg/s², zero pose): density against 10 Hz [dB]',
        ('range', 'within 10 dB [Hz]', '10 Hz', '20 Hz', '40 Hz', '60 Hz'),
        rows,
        keep='arm_pulses',
    )


def findings(found: list[Density], real: list[RealPulses]) -> list[Finding]:
    """Return what became of Fig. 10."""
    gains = [each.mean_between(10.0, 200.0) / found[0].mean_between(10.0, 200.0) for each in found]
    as_many = all(0.9 * n < gain < 1.1 * n for n, gain in zip(COUNTS, gains, strict=True))
    reach_hz = max(each.driven.excited_band_hz()[1] for each in real)
    return [
        Finding(
            'Fig. 10: more pulses, more power',
            f'{COUNTS[-1]} pulses have {gains[-1]:.1f} times the density of one',
            REPRODUCED if as_many else NOT_REPRODUCED,
        ),
        Finding(
            'Sect. 4.2: random pulses give a smooth spectrum over the band of interest',
            f'pulses of 3 ms do; those of the arm are within 10 dB to {reach_hz:.0f} Hz only',
            REPRODUCED if reach_hz > HIGHEST_HZ else NOT_REPRODUCED,
        ),
    ]


def draw(found: list[Density], real: list[RealPulses]) -> None:
    figure, axes = panels(1, 3, (11.0, 3.4))
    signal, trains, arm = axes[0]
    for row, (each, colour) in enumerate(zip(found, COLOURS, strict=False)):
        time_s = np.arange(N_SAMPLES) / RATE_HZ
        signal.plot(time_s, each.signal + 1.3 * row, color=colour, lw=0.8)
        trains.semilogy(
            each.frequency_hz, each.density, color=colour, label=f'n = {each.n_pulses}'
        )
        trains.semilogy(each.frequency_hz, each.expected, color=GREY, lw=0.9, ls=':')
    signal.set(xlabel='time [s]', yticks=[1.3 * row for row in range(3)])
    signal.set_yticklabels([f'n = {each.n_pulses}' for each in found])
    signal.grid(visible=False)
    signal.set_title('pulses of 3 ms in 1 s')
    trains.axvline(1e3 / WIDTH, color=GREY, lw=0.8)
    trains.set(xlabel='frequency [Hz]', ylabel='density [1/Hz]', ylim=(1e-8, 1e-2))
    trains.set_title('their spectra; dotted: theory; line: 1/τ')
    trains.legend(loc='lower left')
    for each, colour in zip(real, COLOURS, strict=False):
        for spectrum, style in ((each.planned, ':'), (each.driven, '-')):
            arm.semilogy(
                spectrum.frequency_hz,
                spectrum.density.mean(axis=1),
                style,
                color=colour,
                label=f'±{each.half_range_deg:g}°' if style == '-' else None,
            )
    arm.set(xlabel='frequency [Hz]', ylabel='density [(rad/s²)²/Hz]', xlim=(0, 100))
    arm.set_ylim(1e-6, 1e2)
    arm.set_title("the arm's: planned (dotted), driven (solid)")
    arm.legend()
    save(
        figure,
        'pulses_drawn',
        'Pulses of 3 ms, their spectra, and those of pulses the arm can make',
    )


def _half_hz(each: Density) -> float:
    """Return where the density has fallen to half of that at 10 Hz."""
    start = int(np.argmax(each.frequency_hz >= 10.0))
    below = each.density[start:] < 0.5 * each.density[start]
    return float(each.frequency_hz[start + int(np.argmax(below))])


def main() -> None:
    found = densities()
    real = [real_pulses(half_range) for half_range in (1.0, 5.0)]
    tabulate(found, real)
    say(
        'A 3 ms pulse falls to half its density at 150 Hz. A move of an arm that accelerates at '
        'some hundred deg/s² lasts 0.1 s and more, and its drives follow to 25 Hz.'
    )
    show_findings(SECTION, findings(found, real), keep=True)
    draw(found, real)


if __name__ == '__main__':
    main()
