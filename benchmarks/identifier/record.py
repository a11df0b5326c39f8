"""The record that all methods are given, and what they are to find in it."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

N_CHANNELS, RATE_HZ, DURATION_S = 42, 512.0, 120.0
BLOCK_ROWS, ORDER = 20, 60
ORDERS = range(2, ORDER + 1, 2)
N_BLOCKS = 50
FIRST_SEED = 71000


@dataclass(frozen=True)
class Found:
    """What one case found.

    Parameters
    ----------
    poles : tuple of (n_poles,) arrays
        Model order, and continuous-time pole [rad/s].
    modes : tuple of (n_modes,) arrays
        Frequency [Hz] and damping ratio.
    deviations : (n_poles, 2) array
        Standard deviations of frequency [Hz] and damping ratio of the poles.
    """

    poles: tuple[NDArray, NDArray] | None = None
    modes: tuple[NDArray, NDArray] | None = None
    deviations: NDArray | None = None

    def save(self, path: Path) -> None:
        """Write what there is to an .npz file."""
        parts = {}
        if self.poles is not None:
            parts['order'], parts['pole'] = self.poles
        if self.modes is not None:
            parts['frequency'], parts['damping'] = self.modes
        if self.deviations is not None:
            parts['deviation'] = self.deviations
        np.savez(path, **parts)


def write_record(path: Path, seed: int) -> None:
    """Simulate a record once, so that no case pays for it."""
    from benchmarks.identifier.plant import chain_plant, simulate

    generator = np.random.default_rng(seed)
    rows = simulate(chain_plant(N_CHANNELS), generator, DURATION_S, RATE_HZ).acceleration
    np.save(path, rows - rows.mean(axis=0))


def reference_channels(count: int) -> NDArray[np.int64]:
    """Return the references, the same for all: every seventh channel, or all."""
    return np.arange(N_CHANNELS) if count == N_CHANNELS else np.arange(count) * 7


def names(count: int):
    """Return the channels."""
    from modal_core.channel import Channel

    return tuple(Channel(f's{row // 3:02d}.{"xyz"[row % 3]}') for row in range(count))
