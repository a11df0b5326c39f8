"""Responses of several kinds made one: velocities and displacements beside accelerations.

Of a mode with the pole s a velocity is the displacement times s, an acceleration times s².  Side
by side they are no shape: phases turn by 90° from one to the next and sizes differ by the angular
frequency.  Channels that were differentiated less often than others are therefore differentiated
here, before anything is compared or identified, by the derivatives of the interpolator that puts
samples in step.  A shape then has displacements, rotations or strains as entries, whatever was
measured.  Integrating the others instead would multiply their drift.
"""

from dataclasses import replace
from functools import lru_cache, partial
import math

import numpy as np
from numpy.typing import NDArray

from modal_core.errors import IdentificationError
from modal_core.measurements import NANOSECONDS_PER_SECOND
from modal_core.mode import Mode
from modal_core.numbers.indicators import normalise
from modal_core.samples import Samples
from modal_core.units import derived
from oma_identifier.motion import Cleaned, never, PeakTest
from oma_identifier.time_axis import HALF_WIDTH, KAISER_BETA

Complex = NDArray[np.complex128]


def of_one_kind(samples: Samples) -> Samples:
    """Return samples all differentiated equally often, without rows at the ends that are unknown.

    The very same ones where they are so already.

    Raises
    ------
    IdentificationError
        They are too few.
    """
    missing = _missing(samples)
    if not missing.any():
        return samples
    if len(samples.acceleration) <= 2 * HALF_WIDTH:
        raise IdentificationError(
            'too few samples', found=len(samples.acceleration), expected=f'> {2 * HALF_WIDTH}'
        )
    inside = slice(HALF_WIDTH, len(samples.acceleration) - HALF_WIDTH)
    data = np.array(samples.acceleration[inside], dtype=np.float64)
    for place in np.flatnonzero(missing):
        times = int(missing[place])
        taps = differentiator(times) * samples.sample_rate_hz**times
        own = samples.widened(columns=slice(place, place + 1))[:, 0]
        data[:, place] = np.convolve(own - own.mean(), taps, mode='valid')
    channels = tuple(
        replace(channel, unit=derived(channel.unit, int(times)))
        for channel, times in zip(samples.channels, missing, strict=True)
    )
    late_ns = round(HALF_WIDTH * NANOSECONDS_PER_SECOND / samples.sample_rate_hz)
    return Samples(data, samples.sample_rate_hz, channels, samples.start_ns + late_ns)


def cleaned_of_one_kind(cleaned: Cleaned) -> Cleaned:
    """Return a window of one kind, with all that is known of it."""
    samples = of_one_kind(cleaned.samples)
    if samples is cleaned.samples:
        return cleaned
    missing, motion, explains = _missing(cleaned.samples), cleaned.motion, cleaned.explains
    moved_ns = samples.start_ns - cleaned.samples.start_ns
    return replace(
        cleaned,
        samples=samples,
        lines=tuple(_derived_line(line, missing) for line in cleaned.lines),
        explains=never if explains is never else partial(_explains_derived, explains, missing),
        motion=motion and replace(motion, origin_ns=motion.origin_ns - moved_ns),
    )


def _derived_line(line: Mode, missing: NDArray[np.int64]) -> Mode:
    return replace(line, shape=normalise(line.shape * _factor(line.frequency_hz, missing)))


def _explains_derived(
    explains: PeakTest,
    missing: NDArray[np.int64],
    frequency_hz: float,
    width_hz: float,
    shape: Complex,
) -> bool:
    """Test a shape of one kind: it is asked of as it was measured."""
    return explains(frequency_hz, width_hz, shape / _factor(frequency_hz, missing))


def _factor(frequency_hz: float, times: NDArray[np.int64]) -> Complex:
    """Return what derivatives make of responses at one frequency."""
    return np.asarray((2j * math.pi * frequency_hz) ** times)


def _missing(samples: Samples) -> NDArray[np.int64]:
    """Return how much less often than the others each channel was differentiated."""
    times = np.array([channel.times_derived for channel in samples.channels], dtype=np.int64)
    return np.asarray(times.max(initial=0) - times)


@lru_cache(maxsize=2)
def differentiator(times: int) -> NDArray[np.float64]:
    """Return the taps of the first or second derivative, (2 half_width + 1,), steps of 1.

    The derivatives of the sinc where the samples are, in a Kaiser window: right within 2e-4 up to
    0.86 of the Nyquist frequency.  Of a constant they are 0.
    """
    place = np.arange(-HALF_WIDTH, HALF_WIDTH + 1)
    window = np.i0(KAISER_BETA * np.sqrt(1.0 - (place / HALF_WIDTH) ** 2)) / np.i0(KAISER_BETA)
    with np.errstate(divide='ignore', invalid='ignore'):
        first = np.where(place % 2, -1.0, 1.0) / place
        taps = -first if times == 1 else -2.0 * first / place
    taps = np.where(place, taps, 0.0) * window
    if times == 2:
        taps[HALF_WIDTH] = -taps.sum()
    # Convolution turns the taps round.
    return np.asarray(taps[::-1])
