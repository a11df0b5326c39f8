"""Results of windows as an identifier makes them, without one."""

import numpy as np

from modal_core.mode import Mode, ModeSet
from modal_core.quality import ChannelQuality, DataQuality
from modal_core.window import Pose
from modal_history.kept import Circumstances, KeptWindow
from modal_history.store import HistoryWriter

START_NS = 1_780_000_000 * 10**9
MINUTE_NS = 60 * 10**9
ROBOT = Circumstances('arm', 'gripper', 'suite 1', '{"window_s": 60}')
FREQUENCIES_HZ = (8.3, 11.9, 19.4, 33.0)


def structure(n_channels=12, frequencies_hz=FREQUENCIES_HZ, seed=5):
    """Return shapes of a structure, largest entry 1."""
    shapes = np.random.default_rng(seed).normal(size=(n_channels, len(frequencies_hz)))
    return shapes / np.abs(shapes).max(0) + 0j


def window(number, rng, frequencies_hz=FREQUENCIES_HZ, n_channels=12, shapes=None, **changes):
    """Return a window of modes with scatter as their deviations say."""
    shapes = structure(n_channels, frequencies_hz) if shapes is None else shapes
    modes = []
    for place, frequency_hz in enumerate(frequencies_hz):
        noise = rng.normal(size=(2, n_channels)) * 0.004
        shape = shapes[:, place] + noise[0] + 1j * noise[1]
        modes.append(
            Mode(
                frequency_hz=frequency_hz * (1.0 + 1e-3 * rng.normal()),
                damping_ratio=0.01,
                shape=shape / shape[np.abs(shape).argmax()],
                frequency_std_hz=1e-3 * frequency_hz,
                damping_ratio_std=1e-3,
                mpc=0.99,
                mpd=0.05,
                id=place + 1,
                shape_std=np.full(n_channels, 0.004 + 0.004j),
                mac_loss=1e-4,
                mac_loss_std=1e-4,
            )
        )
    values = {
        'index': number,
        'start_ns': START_NS + number * MINUTE_NS,
        'end_ns': START_NS + (number + 1) * MINUTE_NS,
        'modes': ModeSet(tuple(modes), tuple(f's{i}.x' for i in range(n_channels))),
        'quality': DataQuality(
            flags=('partial',), channels=(ChannelQuality('s1.x', flags=('clipping',)),)
        ),
        'pose': Pose(('joint_1', 'joint_2'), np.array([0.1, -0.2]), np.zeros(2)),
        'temperature_c': 21.5,
        'load_kg': 4.0,
    }
    return KeptWindow(**{**values, **changes})


def softened(path, n_windows=400, softer_from=200, factor=0.985):
    """Keep a robot that loses stiffness of its first mode half-way (seed 6)."""
    rng, shapes, windows = np.random.default_rng(6), structure(), []
    for number in range(n_windows):
        moved = list(FREQUENCIES_HZ)
        moved[0] *= factor if number >= softer_from else 1.0
        windows.append(window(number, rng, tuple(moved), shapes=shapes))
    with HistoryWriter(path) as writer:
        writer.add(ROBOT, windows)
    return path
