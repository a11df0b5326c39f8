"""How the controller turns a sensor's position and speed references into motion.

speed = k (pos_ref - pos) + speed_ref, low-passed, limited and ramped; pos is the position the
controller itself asks for and the integral of that speed.  There is no path planner in between.

References
----------
ABB application manual Externally Guided Motion, 3HAC073318-001.
"""

from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import NDArray

from abb_emulator.of_axes import of_axes
from modal_core.settings.schema import setting

Array = NDArray[np.float64]
N_AXES = 6
GAIN_LIMIT_1_S = 20.0


@dataclass(frozen=True, slots=True)
class GuidanceSettings:
    """What EGMSetupUC, EGMActJoint and EGMRunJoint set; defaults are the controller's own.

    Parameters
    ----------
    gain_1_s : float [1/s]
        k, 0..20, from the configuration.
    position_gain : float
        PosCorrGain 0..1, scales k.
    low_pass_hz : float [Hz]
        LpFilter on the speed, 0..100; 0 takes it out.
    max_speed_deviation_deg_s, max_position_deviation_deg : float [deg/s], [deg]
        Limits of the correction.
    ramp_in_s, ramp_out_s : float [s]
        Ramps of the speed at the beginning and end.
    window_low_deg, window_high_deg : (6,) tuple [deg]
        Convergence window of each axis.
    selected : (6,) tuple of bool
        Axes EGMRunJoint waits for.
    condition_time_s : float [s]
        CondTime.
    comm_timeout_s : float [s]
        CommTimeout.
    sample_cycles : int
        Controller cycles per message (SampleRate / 4).
    stop_ramp_down : bool
        EGM_STOP_RAMP_DOWN, back to where the session began, instead of EGM_STOP_HOLD.
    """

    gain_1_s: float = setting(5.0, 'k of the configuration [1/s]', 0.0, GAIN_LIMIT_1_S)
    position_gain: float = setting(1.0, 'PosCorrGain, scales k', 0.0, 1.0)
    low_pass_hz: float = setting(20.0, 'LpFilter on the speed [Hz]; 0: none', 0.0, 100.0)
    max_speed_deviation_deg_s: float = setting(
        1.0, 'largest speed of the correction [deg/s]', 0.0, 1e4
    )
    max_position_deviation_deg: float = setting(
        1000.0, 'largest correction of the position [deg]', 0.0, 1e4
    )
    ramp_in_s: float = setting(0.5, 'ramp of the speed at the beginning [s]', 0.0, 1e3)
    ramp_out_s: float = setting(0.5, 'ramp of the speed at the end [s]', 0.0, 1e3)
    window_low_deg: tuple[float, ...] = setting(
        (-0.5,) * N_AXES, 'lower edge of the convergence window of each axis [deg]', -1e4, 0.0
    )
    window_high_deg: tuple[float, ...] = setting(
        (0.5,) * N_AXES, 'upper edge of the convergence window of each axis [deg]', 0.0, 1e4
    )
    selected: tuple[bool, ...] = setting((True,) * N_AXES, 'axes EGMRunJoint waits for')
    condition_time_s: float = setting(1.0, 'CondTime [s]', 0.0, 1e9)
    comm_timeout_s: float = setting(1.0, 'CommTimeout [s]', 0.0, 1e9)
    sample_cycles: int = setting(1, 'controller cycles per message (SampleRate / 4)', 1, 1000)
    stop_ramp_down: bool = setting(
        False, 'EGM_STOP_RAMP_DOWN, back to where the session began, instead of EGM_STOP_HOLD'
    )


class GuidanceLaw:
    """Guidance of one session, one ``step`` per controller cycle.

    Parameters
    ----------
    settings : GuidanceSettings
        Of the session.
    start_deg : (6,) array [deg]
        Where the axes are.
    cycle_s : float [s]
        Controller cycle.
    """

    def __init__(self, settings: GuidanceSettings, start_deg: Array, cycle_s: float) -> None:
        self.settings = settings = of_axes(settings, len(start_deg))
        self.start_deg = np.array(start_deg, float)
        self.position_deg = self.start_deg.copy()
        self.speed_deg_s = np.zeros_like(self.start_deg)
        self.converged = False
        self._cycle_s = cycle_s
        self._reference_deg = self.start_deg.copy()
        self._reference_speed_deg_s = np.zeros_like(self.start_deg)
        self._filtered = np.zeros_like(self.start_deg)
        self._ran_s = 0.0
        self._inside_s = 0.0
        self._ending_s: float | None = None
        self._end_deg: Array | None = None
        cutoff = settings.low_pass_hz
        self._keep = math.exp(-2.0 * math.pi * cutoff * cycle_s) if cutoff > 0.0 else 0.0

    @property
    def finished(self) -> bool:
        """The session has come to its end and the axes stand."""
        return self._ending_s is not None and self._ending_s >= self.settings.ramp_out_s

    @property
    def ending(self) -> bool:
        """The speed is being ramped out."""
        return self._ending_s is not None

    def refer(self, position_deg: Array | None, speed_deg_s: Array | None) -> None:
        """Take new references; what a message leaves out: position stays, speed is 0."""
        if position_deg is not None:
            self._reference_deg = np.array(position_deg, float)
        self._reference_speed_deg_s = (
            np.zeros_like(self.start_deg) if speed_deg_s is None else np.array(speed_deg_s, float)
        )

    def end(self) -> None:
        """Begin to ramp the speed out."""
        if self._ending_s is None:
            self._ending_s = 0.0

    def step(self) -> Array:
        """Move on by one cycle and return the position asked for, (6,) [deg]."""
        if self._ending_s is not None and self.settings.stop_ramp_down:
            return self._go_back()
        limits, cycle_s = self.settings, self._cycle_s
        error = self._reference_deg - self.position_deg
        gain = min(limits.gain_1_s, GAIN_LIMIT_1_S) * limits.position_gain
        wanted = gain * error + self._reference_speed_deg_s
        self._filtered = self._keep * self._filtered + (1.0 - self._keep) * wanted
        fastest = limits.max_speed_deviation_deg_s
        speed = np.clip(self._filtered, -fastest, fastest) * self._ramp()
        farthest = limits.max_position_deviation_deg
        position: Array = np.clip(
            self.position_deg + speed * cycle_s,
            self.start_deg - farthest,
            self.start_deg + farthest,
        )
        self.speed_deg_s = (position - self.position_deg) / cycle_s
        self.position_deg = position
        self._watch_convergence(error)
        self._ran_s += cycle_s
        return position

    def _go_back(self) -> Array:
        """Return to the start within the ramp-out time, at rest at both ends."""
        before, ending_s = self.position_deg, (self._ending_s or 0.0) + self._cycle_s
        if self._end_deg is None:
            self._end_deg = before
        left = 1.0 - min(ending_s / self.settings.ramp_out_s, 1.0)
        self.position_deg = self.start_deg + left**2 * (3.0 - 2.0 * left) * (
            self._end_deg - self.start_deg
        )
        self.speed_deg_s = (self.position_deg - before) / self._cycle_s
        self._ending_s = ending_s
        return self.position_deg

    def _ramp(self) -> float:
        ramp = min(1.0, (self._ran_s + self._cycle_s) / self.settings.ramp_in_s)
        if self._ending_s is not None:
            ramp *= max(0.0, 1.0 - self._ending_s / self.settings.ramp_out_s)
            self._ending_s += self._cycle_s
        return ramp

    def _watch_convergence(self, error: Array) -> None:
        limits = self.settings
        inside = (error >= limits.window_low_deg) & (error <= limits.window_high_deg)
        self.converged = bool(np.all(inside | ~np.array(limits.selected)))
        self._inside_s = self._inside_s + self._cycle_s if self.converged else 0.0
        if self._inside_s >= limits.condition_time_s:
            self.end()
