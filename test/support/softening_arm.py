"""A robot with a known model that works in poses while one of its springs softens."""

from dataclasses import dataclass

import numpy as np

from modal_core.mode import Mode, ModeSet
from modal_core.window import Pose
from modal_history.kept import KeptWindow

START_NS, MINUTE_NS = 1_780_000_000 * 10**9, 60 * 10**9


@dataclass(frozen=True)
class SofteningArm:
    """What is played.

    Parameters
    ----------
    model, layout
        The robot as it is, and its sensors.
    changed : dict of str to float
        Factors of parameters after the change.
    seed : int
        Of poses and estimates.
    n_before, n_after : int
        Windows, one a minute.
    highest_hz : float [Hz]
        Modes above are not identified.
    """

    model: object
    layout: object
    changed: dict
    seed: int
    n_before: int = 400
    n_after: int = 120
    highest_hz: float = 40.0

    def windows(self):
        """Return the windows by time."""
        rng = np.random.default_rng(self.seed)
        values = self.model.parameters()
        after = self.model.with_parameters({n: f * values[n] for n, f in self.changed.items()})
        poses = self._poses(rng)
        both = [
            [each.modes(q, self.layout.channels) for q in poses] for each in (self.model, after)
        ]
        return [
            self._window(n, both[n >= self.n_before], poses, rng)
            for n in range(self.n_before + self.n_after)
        ]

    def _poses(self, rng):
        return self.model.pose('ready') + rng.uniform(-0.6, 0.6, size=(12, self.model.n_joints))

    def _window(self, number, modes, poses, rng):
        at = int(rng.integers(len(poses)))
        found = modes[at]
        below = np.flatnonzero(found.frequency_hz < self.highest_hz)
        return KeptWindow(
            index=number,
            start_ns=START_NS + number * MINUTE_NS,
            end_ns=START_NS + (number + 1) * MINUTE_NS,
            modes=ModeSet(
                tuple(self._mode(found, place, rng) for place in below),
                tuple(channel.name for channel in self.layout.channels),
            ),
            pose=Pose(tuple(self.model.joint_names), poses[at], np.zeros(self.model.n_joints)),
            temperature_c=22.0 + 0.1 * rng.normal(),
        )

    def _mode(self, found, place, rng):
        shape = found.channel_shapes[:, place] + 0j
        shape = shape / shape[np.abs(shape).argmax()]
        noise = 0.01 * (rng.normal(size=len(shape)) + 1j * rng.normal(size=len(shape)))
        frequency_hz = float(found.frequency_hz[place])
        return Mode(
            frequency_hz=frequency_hz * (1.0 + 1.5e-3 * rng.normal()),
            damping_ratio=0.02,
            shape=shape + noise,
            frequency_std_hz=1.5e-3 * frequency_hz,
            damping_ratio_std=2e-3,
            mpc=0.99,
            mpd=0.05,
            shape_std=np.full(len(shape), 0.01 + 0.01j),
            mac_loss=1e-3,
            mac_loss_std=1e-3,
            id=int(place) + 1,
        )
