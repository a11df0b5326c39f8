"""Windows in, spectra over time and speed out."""

import numpy as np
from numpy.typing import NDArray

from autonomous_modal_analysis.spectrogram.columns import (
    Columns,
    FIRST_SPEED_RAD_S,
    MOST_SPEEDS,
    MOST_TIMES,
)
from autonomous_modal_analysis.spectrogram.joint_speed import mean_speeds, motor_turns
from autonomous_modal_analysis.spectrogram.segment import Segments
from modal_core.measurements import JointSamples, NANOSECONDS_PER_SECOND
from modal_core.window import Window
from modal_reports import Spectrogram, SpeedSpectra
from oma_identifier.motion import RobotMotion

Array = NDArray[np.float64]
MOVES_RAD_S = 5e-3
"""A joint that is never faster than this rests."""


class SpectrogramWatch:
    """Gathers spectra of what was measured, window by window.

    Parameters
    ----------
    robot : RobotMotion or None
        Knows how often motors turn for a turn of a joint.
    """

    def __init__(self, robot: RobotMotion | None = None) -> None:
        self._robot = robot
        self._rate_hz = 0.0
        self._begin_ns = self._until_ns = 0
        self._segments: Segments | None = None
        self._speeds = _Speeds()
        self._windows: list[tuple[int, int]] = []

    def add(self, window: Window) -> None:
        """Take the samples of a window that no window before had."""
        samples = window.samples
        if not samples.channels:
            return
        self._windows.append((samples.start_ns, samples.end_ns))
        if self._segments is None:
            self._rate_hz = samples.sample_rate_hz
            self._begin_ns = self._until_ns = samples.start_ns
            self._segments = Segments(self._rate_hz)
            n_lines = self._segments.n_lines
            self._times = Columns(self._segments.duration_s, MOST_TIMES, n_lines)
        # Columns of one picture have one set of frequencies.
        if samples.sample_rate_hz != self._rate_hz:
            return
        length = self._segments.length
        seen_s = max(0, self._until_ns - samples.start_ns) / NANOSECONDS_PER_SECOND
        first = round(seen_s * self._rate_hz)
        for row in range(first, len(samples.acceleration) - length + 1, length):
            start_ns = samples.start_ns + _nanoseconds(row / self._rate_hz)
            psd = self._segments.psd(samples.widened(slice(row, row + length)))
            self._times.add((start_ns - self._begin_ns) / NANOSECONDS_PER_SECOND, psd)
            self._until_ns = start_ns + _nanoseconds(self._segments.duration_s)
            self._speeds.add(window.joints, start_ns, self._until_ns, psd)

    def found(self) -> Spectrogram | None:
        """Return the spectra; None of windows that are shorter than a segment."""
        if self._segments is None or not len(self._times):
            return None
        return Spectrogram(
            frequency_hz=self._segments.frequency_hz,
            time_s=self._times.middle,
            psd=self._times.mean,
            joints=self._speeds.found(self._robot, self._windows),
        )


class _Speeds:
    """Spectra by the speed of each joint."""

    def __init__(self) -> None:
        self._names: tuple[str, ...] = ()
        self._columns: list[Columns] = []
        self._middle_ns: list[int] = []
        self._rad_s: list[Array] = []

    def add(self, joints: JointSamples | None, start_ns: int, end_ns: int, psd: Array) -> None:
        speeds = mean_speeds(joints, start_ns, end_ns)
        if joints is None or speeds is None:
            return
        if not self._names:
            self._names = joints.joint_names
            self._columns = [Columns(FIRST_SPEED_RAD_S, MOST_SPEEDS, len(psd)) for _ in speeds]
        if joints.joint_names != self._names:
            return
        self._middle_ns.append((start_ns + end_ns) // 2)
        self._rad_s.append(speeds)
        for columns, speed in zip(self._columns, speeds.tolist(), strict=True):
            columns.add(speed, psd)

    def found(
        self, robot: RobotMotion | None, windows: list[tuple[int, int]]
    ) -> tuple[SpeedSpectra, ...]:
        turns = motor_turns(robot, self._names)
        for columns in self._columns:
            columns.thin()
        speeds = np.array(self._rad_s).reshape(len(self._rad_s), len(self._names))
        return tuple(
            SpeedSpectra(
                joint=name,
                speed_rad_s=columns.middle,
                psd=columns.mean,
                window_rad_s=self._of_windows(windows, speed),
                turns=turns[index],
            )
            for index, (name, columns, speed) in enumerate(
                zip(self._names, self._columns, speeds.T, strict=True)
            )
            if speed.max(initial=0.0) > MOVES_RAD_S
        )

    def _of_windows(self, windows: list[tuple[int, int]], speed: Array) -> Array:
        """Return mean, least and greatest speed in each window, (n_windows, 3)."""
        middle_ns = np.array(self._middle_ns)
        rows = np.full((len(windows), 3), np.nan)
        for row, (start_ns, end_ns) in zip(rows, windows, strict=True):
            inside = speed[(middle_ns >= start_ns) & (middle_ns < end_ns)]
            if len(inside):
                row[:] = inside.mean(), inside.min(), inside.max()
        return rows


def _nanoseconds(seconds: float) -> int:
    return round(seconds * NANOSECONDS_PER_SECOND)
