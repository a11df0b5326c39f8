"""How late each sensor is against the others, from the responses alone.

Where one mode outweighs all else, two synchronous sensors move in or against phase; a delay turns
that phase.  Sensors are put in step one after the other, each against all that are so already.
"""

from collections.abc import Sequence
import math

import numpy as np
from numpy.typing import NDArray

from oma_identifier.synchrony.delay_odds import delays_of, SensorDelay
from oma_identifier.synchrony.peak_view import view_at
from oma_identifier.synchrony.sensor_peaks import Columns, Peak

MOST_BEGINNINGS = 4
"""Sensors that are tried to begin with, where some are late: it may be the first that is."""


def sensor_delays(peaks: list[Peak], columns: Columns) -> dict[str, SensorDelay]:
    """Return how late each sensor is against the others.

    Parameters
    ----------
    peaks : list of Peak
        Of the samples of all sensors, each by its own stamps.
    columns : mapping of str to int array
        Channels of each sensor: what shares a clock.

    Returns
    -------
    dict of str to SensorDelay
        By sensor, against the one that leaves the fewest in doubt: of most others, where they are
        in step.  Empty when there is but one.
    """
    if len(columns) < 2:
        return {}
    # A machine's line moves all modes at once: sensors are out of step there, and none is late.
    peaks = [peak for peak in peaks if not peak.is_line]
    if not peaks:
        return {name: SensorDelay() for name in columns}
    best: dict[str, SensorDelay] = {}
    least = math.inf
    for first in range(min(MOST_BEGINNINGS, len(columns))):
        found = _Alignment(peaks, columns).found(first)
        doubts = sum(delay.log_odds > 0.0 for delay in found.values())
        if doubts < least:
            best, least = found, doubts
        if not any(delay.is_odd for delay in best.values()):
            break
    return best


class _Alignment:
    """Sensors put in step one after the other, beginning with one that sees much.

    Parameters
    ----------
    peaks : list of Peak
        Where they are compared.
    columns : dict of str to int array
        Channels of each sensor.
    """

    def __init__(self, peaks: list[Peak], columns: Columns) -> None:
        self._columns = columns
        power = np.array([np.mean(np.abs(peak.spectra) ** 2, axis=(0, 1)) for peak in peaks])
        mean = power.mean(axis=1)
        # Power of each sensor over the mean of all, by peak.
        self._power = {
            name: power[:, own].mean(axis=1) / mean + 1e-12 for name, own in columns.items()
        }
        self._peaks = peaks
        self._delay_s: dict[str, float] = {}

    def found(self, first: int) -> dict[str, SensorDelay]:
        """Return the delays, beginning with the sensor that sees most (0), or the next (1)."""
        names = sorted(self._columns, key=lambda name: -float(np.log(self._power[name]).sum()))
        in_step = [names.pop(first)]
        found = {in_step[0]: SensorDelay(std_s=0.0, log_odds=-math.inf)}
        while names:
            tried = self._compare(names, in_step)
            found |= tried
            sure = [n for n, d in tried.items() if d.log_odds < 0.0 or (d.is_odd and d.is_known)]
            if not sure:
                break
            # What is in doubt is asked again beside more sensors.
            for name in sure:
                self._delay_s[name] = tried[name].seconds
            names = [name for name in names if name not in sure]
            in_step += sure
        return {name: found[name] for name in self._columns}

    def _in_step(self, peak: Peak) -> NDArray[np.complex128]:
        """Return the spectra of a peak, of sensors whose delay is known as if they had none."""
        spectra = peak.spectra
        for name, seconds in self._delay_s.items():
            if seconds:
                turn = np.exp(2j * np.pi * (peak.frequency_hz + peak.line_hz) * seconds)
                spectra[:, :, self._columns[name]] *= turn[:, None]
        return spectra

    def _compare(self, names: Sequence[str], others: Sequence[str]) -> dict[str, SensorDelay]:
        own = [self._columns[name] for name in names]
        beside = np.concatenate([self._columns[other] for other in others])
        power = np.mean([self._power[other] for other in others], axis=0)
        shown = np.transpose([self._power[name] for name in names])
        views = [
            view_at(peak, self._in_step(peak), own, beside, *powers)
            for peak, *powers in zip(self._peaks, shown, power, strict=True)
        ]
        return dict(zip(names, delays_of(views), strict=True))
