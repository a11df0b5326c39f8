"""Tells lines of machines and drives from modes of the structure.

A mode shaken at random forgets its phase within a decay time; a line keeps it for ever.  The
response is demodulated at the suspected frequency over segments of the window: if one constant
phasor explains the segments far better than chance (an F test), the response is coherent.  This is
the kurtosis and entropy test in its exact form: a line's envelope is constant, a mode's is
Rayleigh.  A mode that decays hardly within the record is coherent as well: whether a coherent
response is a line is a matter of odds (:mod:`oma_identifier.spectra.line_or_mode`).

References
----------
Thomson (1982), doi:10.1109/PROC.1982.12433, Section XIII (F test for a line in coloured noise);
Jacobsen, Andersen and Brincker (2007), harmonic detection by kurtosis, IOMAC.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from modal_core.numbers.chance import fisher_tail
from modal_core.samples import Samples
from oma_identifier.spectra.line_or_mode import Odds, odds_of
from oma_identifier.spectra.thresholds import SPECTRA

N_SEGMENTS, MORE_SEGMENTS = 12, 32
LEAST_PERIODS = 3.0
"""Periods in a segment from where on its taper keeps out the frequency's own negative."""
ROUNDING_OF_LINE = 1e-20
"""Share of a line's power below which what is left in a channel is rounding."""

NO_DOUBT = Odds()


@dataclass(frozen=True, slots=True)
class Line:
    """A sinusoid in the responses.

    Parameters
    ----------
    frequency_hz : float [Hz]
        Where the phasors of the segments line up best.
    shape : (n_channels,) complex array [m/s²]
        Phasor of each channel.
    chance : float
        Probability that noise looks like this.
    odds : Odds
        What it is if it is not noise.
    """

    frequency_hz: float
    shape: NDArray[np.complex128]
    chance: float
    odds: Odds = NO_DOUBT

    def stands_out(self, chance: float, least_odds: float = 0.0) -> bool:
        """Tell whether this is a line rather than noise, up to a chance, or a mode."""
        return self.chance < chance and self.odds.line > least_odds

    @property
    def is_doubtful(self) -> bool:
        """Whether it may be a mode after all."""
        return self.odds.line < SPECTRA.sure_line

    @property
    def is_mode(self) -> bool:
        """Whether this is neither noise nor a line, but a mode that decays slowly."""
        return self.odds.narrow_mode > SPECTRA.narrow_mode


def line_at(
    samples: Samples, frequency_hz: float, weight: NDArray[np.complex128] | None = None
) -> Line:
    """Test for a line near a frequency.

    Parameters
    ----------
    samples : Samples
        Of at least a few hundred periods.
    frequency_hz : float [Hz]
        Suspected; the neighbourhood of one part in the number of segments is searched.
    weight : (n_channels,) complex array or None
        Sum of channels that is tested; None: all of them.

    Returns
    -------
    Line
        Seen from one segment's frequency beside it a line looks like a weaker one: the strongest
        of such images is returned.
    """

    def size(line: Line) -> float:
        return float(np.linalg.norm(line.shape if weight is None else line.shape @ weight))

    line = _line_near(samples, frequency_hz, weight)
    step_hz = N_SEGMENTS / samples.duration_s
    while line.chance < SPECTRA.sharp_line_chance:
        steps = (-step_hz, step_hz)
        images = [_line_near(samples, line.frequency_hz + step, weight) for step in steps]
        strongest = max(images, key=size)
        if size(strongest) <= size(line):
            break
        line = strongest
    return replace(line, odds=_odds(samples, line, weight))


def _odds(samples: Samples, line: Line, weight: NDArray[np.complex128] | None) -> Odds:
    """Return what a response is, in the sum of channels that shows it best."""
    n_periods = line.frequency_hz * samples.duration_s
    n_segments = MORE_SEGMENTS if n_periods > LEAST_PERIODS * MORE_SEGMENTS else N_SEGMENTS
    phasors = _segment_phasors(samples, line.frequency_hz, n_segments)
    if weight is None:
        rest = np.mean(np.abs(phasors - phasors.mean(axis=0)) ** 2, axis=0)
        level = np.abs(line.shape) ** 2
        weight = line.shape.conj() / np.maximum(rest, ROUNDING_OF_LINE * level.max(initial=1e-300))
    return odds_of(phasors @ weight, 2.0 * np.pi * SPECTRA.least_damping * n_periods)


def _line_near(
    samples: Samples, frequency_hz: float, weight: NDArray[np.complex128] | None
) -> Line:
    phasors = every = _segment_phasors(samples, frequency_hz)
    if weight is not None:
        phasors = (every @ weight)[:, None]
    duration = samples.duration_s
    # Residual frequency error turns the phasors from segment to segment: undo the best turn.
    offsets = np.linspace(-0.5, 0.5, 101) * N_SEGMENTS / duration
    middle = (np.arange(N_SEGMENTS) + 0.5) * duration / N_SEGMENTS
    turns = np.exp(-2j * np.pi * np.outer(offsets, middle))
    explained = np.sum(np.abs(turns @ phasors) ** 2, axis=1) / N_SEGMENTS
    best = int(np.argmax(explained))
    total = float(np.sum(np.abs(phasors) ** 2))
    rest = max(total - float(explained[best]), 1e-300)
    ratio = (N_SEGMENTS - 2) * float(explained[best]) / rest
    return Line(
        frequency_hz=float(frequency_hz + offsets[best]),
        shape=np.asarray(turns[best] @ every / N_SEGMENTS, dtype=complex),
        # One complex phasor and one frequency were fitted to the segments.
        chance=float(fisher_tail(ratio, 2, 2 * (N_SEGMENTS - 2))),
    )


def _segment_phasors(
    samples: Samples, frequency_hz: float, n_segments: int = N_SEGMENTS
) -> NDArray[np.complex128]:
    """Return the phasors of the segments, (n_segments, n_channels)."""
    length = len(samples.acceleration) // n_segments
    time = np.arange(n_segments * length) / samples.sample_rate_hz
    # A taper over each segment keeps strong modes far away out of the phasor.
    taper = np.tile(np.blackman(length + 2)[1:-1], n_segments)
    carrier = taper * np.exp(-2j * np.pi * frequency_hz * time)
    carrier = carrier.reshape(n_segments, length)
    sums = np.empty((n_segments, 3, len(samples.channels)))
    for number, part in enumerate(carrier):
        rows = samples.widened(slice(number * length, (number + 1) * length))
        # All that is needed of these rows at once: to read them takes longest.
        sums[number] = np.stack([part.real, part.imag, np.ones(length)]) @ rows
    mean = sums[:, 2].sum(axis=0) / len(time)
    turned = sums[:, 0] + 1j * sums[:, 1] - carrier.sum(axis=1)[:, None] * mean
    return np.asarray(turned * (2.0 / (0.42 * length)))
