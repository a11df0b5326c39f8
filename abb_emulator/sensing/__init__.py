"""Sensors on the emulated arm, with the errors of real ones.

In comes true motion at their places; out go samples with noise, delay, scale and clock errors.
"""

from abb_emulator.sensing.delay_line import DelayLine
from abb_emulator.sensing.sensor_errors import SensorErrors
from abb_emulator.sensing.sensors import SensorArray, SensorSettings

__all__ = ['DelayLine', 'SensorArray', 'SensorErrors', 'SensorSettings']
