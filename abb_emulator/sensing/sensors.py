"""What the data acquisition makes of ideal readings: noise, bias, quantisation, faults."""

from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import NDArray

from modal_core.settings.schema import setting

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class SensorSettings:
    """Quality of the sensors.

    Parameters
    ----------
    noise_density : float [m/s²/√Hz]
        One-sided, white.
    bias : float [m/s²]
        Standard deviation of the constant offset of each channel.
    resolution : float [m/s²]
        Step of the converter; 0 is none.
    range_limit : float [m/s²]
        Readings beyond are cut off.
    gyro_scale : float [rad/s per m/s²]
        Gyroscopes have all of these times this.
    clock_error_ppm : float [ppm]
        By how much the sampling clock runs fast; stamps are the sampling clock's own.
    """

    noise_density: float = setting(3e-4, 'one-sided, white [m/s²/√Hz]', 0.0, 1e3)
    bias: float = setting(0.02, 'deviation of the constant offset [m/s²]', 0.0, 1e3)
    resolution: float = setting(1e-4, 'step of the converter [m/s²]; 0: none', 0.0, 1e3)
    range_limit: float = setting(160.0, 'readings beyond are cut off [m/s²]', 0.0, 1e9)
    gyro_scale: float = setting(
        0.1, 'gyroscopes have all of these times this [rad/s per m/s²]', 0.0, 1e3
    )
    clock_error_ppm: float = setting(
        0.0, 'by how much the sampling clock runs fast [ppm]', -1e5, 1e5
    )


class SensorArray:
    """All channels of one recorder.

    Parameters
    ----------
    settings : SensorSettings
        Quality.
    n_channels : int
        Columns.
    sample_rate_hz : float [Hz]
        Sets the noise of one sample.
    random : numpy.random.Generator
        Noise and bias.
    gyro : (n_channels,) bool array or None
        Which columns are angular velocities.
    """

    def __init__(
        self,
        settings: SensorSettings,
        n_channels: int,
        sample_rate_hz: float,
        random: np.random.Generator,
        gyro: NDArray[np.bool_] | None = None,
    ) -> None:
        self.settings = settings
        self._random = random
        is_gyro = np.zeros(n_channels, dtype=bool) if gyro is None else gyro
        self._scale = np.where(is_gyro, settings.gyro_scale, 1.0)
        self._noise = self._scale * settings.noise_density * math.sqrt(sample_rate_hz / 2.0)
        self._bias = self._scale * settings.bias * random.standard_normal(n_channels)
        self._last = np.zeros(n_channels)
        self.faults: dict[str, tuple[float, tuple[int, ...]]] = {}
        self.block_dropout = 0.0

    def sample(self, readings: Array) -> NDArray[np.float32]:
        """Return what is recorded of ideal readings, (n_samples, n_channels) [m/s²]."""
        limits = self.settings
        data = readings + self._bias
        if self.settings.noise_density > 0.0:
            data += self._noise * self._random.standard_normal(data.shape)
        if limits.resolution > 0.0:
            step = limits.resolution * self._scale
            data = np.round(data / step) * step
        largest = limits.range_limit * self._scale
        data = np.clip(data, -largest, largest)
        for name, (value, columns) in tuple(self.faults.items()):
            self._spoil(data, name, value, list(columns))
        self._last = data[-1].copy()
        return data.astype(np.float32)

    def forget_fault(self, name: str) -> None:
        """End one fault."""
        self.faults.pop(name, None)

    def loses_block(self) -> bool:
        """Tell whether this block is lost on its way."""
        return self.block_dropout > 0.0 and self._random.random() < self.block_dropout

    def _spoil(self, data: Array, name: str, value: float, columns: list[int]) -> None:
        if name == 'sensor_nan':
            hit = self._random.random(len(data)) < (value or 1.0)
            data[np.flatnonzero(hit)[:, None], columns] = math.nan
        elif name == 'sensor_dropout':
            data[:, columns] = 0.0
        elif name == 'sensor_flatline':
            data[:, columns] = self._last[columns]
        elif name == 'sensor_clipping':
            centre = self._bias[columns] + np.median(data[:, columns], axis=0)
            data[:, columns] = np.clip(data[:, columns], centre - value, centre + value)
        elif name == 'sensor_spike':
            hit = self._random.random(len(data)) < 0.01
            data[np.flatnonzero(hit)[:, None], columns] += value
