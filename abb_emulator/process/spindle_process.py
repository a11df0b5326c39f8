"""Forces of a running spindle at the tool, one sample after the other."""

from collections.abc import Sequence
from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import NDArray

from abb_emulator.process.cut_kernel import FURTHEST, step_force
from abb_emulator.process.process_settings import ProcessSettings
from modal_core.channel import Channel
from modal_core.errors import SettingsError

Array = NDArray[np.float64]
MOMENTS = 16
"""Of a sample at which the force is asked for: a tooth enters and leaves within it."""
SLOWEST_RPM = 30.0
TOOTH_ORDERS = 3
"""Of tooth passing that are named as lines; higher ones are small and there all the same."""


@dataclass(frozen=True, slots=True)
class ProcessLine:
    """A line of the process in the spectrum.

    Parameters
    ----------
    name : str
        What makes it.
    order : float
        Of the spindle's speed.
    """

    name: str
    order: float


class SpindleProcess:
    """Unbalance, bearings and cut, along feed, normal and spindle axis.

    Parameters
    ----------
    settings : ProcessSettings
        With a spindle that turns.
    step_s : float [s]
        Time between samples.

    Raises
    ------
    SettingsError
        Axes or the cut are not possible.
    """

    def __init__(self, settings: ProcessSettings, step_s: float) -> None:
        self._settings, self._step_s = settings, step_s
        self._orders = [order for order in settings.bearing_orders if order]
        self.axes = _axes(settings)
        self._engagement = np.array(settings.engagement_rad)
        teeth = 2.0 * math.pi / settings.n_teeth * np.arange(settings.n_teeth)
        self._radii = 1e-6 * settings.runout_um * np.cos(teeth)
        self._cutting = 1e6 * np.array([settings.tangential_n_mm2, settings.radial_n_mm2])
        self._edge = 1e3 * np.array([settings.tangential_edge_n_mm, settings.radial_edge_n_mm])
        furthest_s = FURTHEST * 60.0 / (settings.n_teeth * SLOWEST_RPM)
        self._history = np.zeros((math.ceil(furthest_s / step_s) + 3, 2))
        self._newest, self._n_steps, self._ready = 0, 0, 0
        self._rng = np.random.default_rng(settings.seed)
        self.prepare(0)

    def speed_rpm(self, time_s: Array | float) -> Array:
        """Return the spindle speed at a time [rpm]; a falling one ends at a slowest."""
        own = self._settings
        found = own.speed_rpm + own.speed_rate_rpm_s * np.asarray(time_s, float)
        return np.asarray(np.maximum(found, SLOWEST_RPM))

    @property
    def channels(self) -> tuple[Channel, ...]:
        """The tool's displacement along feed, normal and spindle axis."""
        place = tuple(map(float, self._settings.position_m))
        return tuple(
            Channel(f'tool.{name}', self._settings.frame, tuple(map(float, axis)), place)  # type: ignore[arg-type]
            for name, axis in zip(('feed', 'normal', 'axis'), self.axes, strict=True)
        )

    @property
    def lines(self) -> tuple[ProcessLine, ...]:
        """Lines it makes, by name and order: the labels of a recording."""
        own, found = self._settings, []
        if own.unbalance_g_mm:
            found.append(ProcessLine('unbalance', 1.0))
        if own.bearing_n:
            found += [ProcessLine(f'bearing {order:g}', order) for order in self._orders]
        if own.depth_mm:
            orders = range(1, TOOTH_ORDERS * own.n_teeth + 1)
            passing = [order for order in orders if order % own.n_teeth == 0]
            found += [ProcessLine(f'tooth passing {k}', float(k)) for k in passing]
            if own.runout_um and own.n_teeth > 1:
                found += [ProcessLine(f'runout {k}', float(k)) for k in orders if k not in passing]
        return tuple(found)

    def prepare(self, n_samples: int) -> None:
        """Work out what does not depend on the tool's motion for the next samples, at once.

        Parameters
        ----------
        n_samples : int
            At least as many as are then stepped through.
        """
        own, step_s = self._settings, self._step_s
        moments = 0.5 + (np.arange(MOMENTS) + 0.5) / MOMENTS
        begin_s = step_s * (self._n_steps + np.arange(n_samples))
        self._times = begin_s[:, None] + step_s * moments
        self._angles = self._angle(self._times)
        self._free = np.zeros((n_samples, 3))
        self._free[:, :2] = self._rotating()
        if own.background_n:
            self._free += own.background_n * self._rng.standard_normal((n_samples, 3))
        if own.depth_mm:
            back = 2.0 * math.pi / own.n_teeth * np.arange(1, FURTHEST + 1)
            self._ago = self._time_of(self._angles[:, :, None] - back)
        self._ready = 0

    def step(self, begin: Array, end: Array) -> Array:
        """Return the force at the end of the next sample, (3,) [N].

        It is the mean over half a sample before and half a sample after.

        Parameters
        ----------
        begin, end : (3,) array [m]
            Displacement of the tool at both ends of the sample, along its axes.
        """
        if self._ready == len(self._free):
            self.prepare(1)
        force = self._free[self._ready]
        if self._settings.depth_mm:
            force[:2] += self._cut(begin[:2], end[:2])
        self._ready += 1
        self._n_steps += 1
        return np.asarray(force)

    def _rotating(self) -> Array:
        own, angles = self._settings, self._angles
        rate = 2.0 * math.pi / 60.0 * self.speed_rpm(self._times)
        size = 1e-6 * own.unbalance_g_mm * rate**2
        found = np.stack([size * np.sin(angles), size * np.cos(angles)])
        for order in self._orders:
            turned = order * angles
            found += own.bearing_n * np.stack([np.sin(turned), np.cos(turned)])
        return np.asarray(found.mean(axis=2).T)

    def _cut(self, begin: Array, end: Array) -> Array:
        own, at = self._settings, self._ready
        if not own.regeneration:
            begin, end = np.zeros(2), np.zeros(2)
        self._newest = (self._newest + 1) % len(self._history)
        self._history[self._newest] = begin
        return step_force(
            self._times[at], self._angles[at], self._ago[at], begin, end, self._history,
            self._newest, self._step_s * self._n_steps, self._step_s, self._radii,
            self._engagement, 1e-3 * own.feed_mm, self._cutting, self._edge, 1e-3 * own.depth_mm,
        )  # fmt: skip

    def _angle(self, time_s: Array) -> Array:
        """Return the spindle's angle [rad]."""
        first, rise = self._rate
        flat = self._flat_s
        early = np.minimum(time_s, flat)
        found = first * early + 0.5 * rise * early**2
        late = 2.0 * math.pi / 60.0 * SLOWEST_RPM * np.maximum(time_s - flat, 0.0)
        return np.asarray(found + late)

    def _time_of(self, angle: Array) -> Array:
        """Return when the spindle stood at an angle [s]: before the beginning, at even speed."""
        first, rise = self._rate
        steady = angle / first
        if rise == 0.0:
            return np.asarray(steady)
        flat = self._flat_s
        known = np.minimum(angle, float(self._angle(np.array(flat))) if flat < np.inf else angle)
        root = np.sqrt(np.maximum(first**2 + 2.0 * rise * known, 0.0))
        found = 2.0 * known / (first + root) + (angle - known) / (
            2.0 * math.pi / 60.0 * SLOWEST_RPM
        )
        return np.asarray(np.where(angle < 0.0, steady, found))

    @property
    def _rate(self) -> tuple[float, float]:
        turn = 2.0 * math.pi / 60.0
        return turn * self._settings.speed_rpm, turn * self._settings.speed_rate_rpm_s

    @property
    def _flat_s(self) -> float:
        """When a falling speed has come to its slowest [s]."""
        own = self._settings
        if own.speed_rate_rpm_s >= 0.0:
            return math.inf
        return max((SLOWEST_RPM - own.speed_rpm) / own.speed_rate_rpm_s, 0.0)


def _axes(settings: ProcessSettings) -> Array:
    """Return feed, normal and spindle axis as rows."""
    up, along = (_vector(settings, name) for name in ('spindle_axis', 'feed_axis'))
    _vector(settings, 'position_m', may_be_zero=True)
    along = along - (along @ up) * up
    if np.linalg.norm(along) < 1e-6:
        raise SettingsError('feed along the spindle', where='process.feed_axis')
    along = along / np.linalg.norm(along)
    return np.array([along, np.cross(up, along), up])


def _vector(settings: ProcessSettings, name: str, may_be_zero: bool = False) -> Array:
    found: Sequence[float] = getattr(settings, name)
    vector = np.array(found, float)
    length = float(np.linalg.norm(vector))
    if vector.shape != (3,) or not np.isfinite(length) or not (length or may_be_zero):
        raise SettingsError('no vector', where=f'process.{name}', found=found, expected='x, y, z')
    return vector if may_be_zero else vector / length
