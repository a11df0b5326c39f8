"""What the demo is told and what it gives, without ROS."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from modal_core.numbers.indicators import mac


@dataclass(frozen=True, slots=True)
class DemoSettings:
    """How the demo is run.

    Parameters
    ----------
    folder : Path
        For the recording and the nodes' logs.
    robot : str
        Robot of config/robots.
    pose : str
        Named pose.
    window_s, hop_s : float [s]
        Of the live identifier.
    n_windows : int
        Windows to wait for.
    seed : int
        Of plan and sensor noise.
    """

    folder: Path
    robot: str = 'irb6660_205_190'
    pose: str = 'P1'
    window_s: float = 24.0
    hop_s: float = 12.0
    n_windows: int = 3
    seed: int = 1

    @property
    def excitation_s(self) -> float:
        """Length of the motion: all windows, the identifier's start and the ends' fading."""
        return self.window_s + (self.n_windows - 1) * self.hop_s + 12.0

    @property
    def recording(self) -> Path:
        """The recording it leaves."""
        return self.folder / 'demo.mcap'


@dataclass(frozen=True, slots=True)
class TrueModes:
    """Modes of the emulated arm as the emulator states them: at a pose, or of a path.

    Parameters
    ----------
    frequency_hz, damping_ratio : (n_modes,) array [Hz], [-]
        Rising frequency.
    shapes : (n_channels, n_modes) complex array
        At the channels.
    channel_names : tuple of str
        Rows of ``shapes``.
    position : (n_joints,) array [rad]
        Serial joints.
    """

    frequency_hz: NDArray[np.float64]
    damping_ratio: NDArray[np.float64]
    shapes: NDArray[np.complex128]
    channel_names: tuple[str, ...]
    position: NDArray[np.float64]


def mean_of(truths: Sequence[TrueModes]) -> TrueModes:
    """Return the mean of true modes along a path, as a recording of the whole path has them.

    Parameters
    ----------
    truths : sequence of TrueModes
        At times evenly along the path, at least one.

    Returns
    -------
    TrueModes
        Mean frequencies and damping ratios of modes followed by shape; shapes and pose from the
        middle of the path.
    """
    poses = np.array([truth.position for truth in truths])
    middle = truths[int(np.argmin(np.sum((poses - poses.mean(axis=0)) ** 2, axis=1)))]
    followed = [linear_sum_assignment(-mac(middle.shapes, truth.shapes))[1] for truth in truths]
    pairs = list(zip(truths, followed, strict=True))
    return replace(
        middle,
        frequency_hz=np.mean([truth.frequency_hz[place] for truth, place in pairs], axis=0),
        damping_ratio=np.mean([truth.damping_ratio[place] for truth, place in pairs], axis=0),
    )


@dataclass(frozen=True, slots=True)
class DemoRun:
    """What the live part of the demo gave.

    Parameters
    ----------
    truth : TrueModes
        Of the emulated arm, mean along its path.
    band_hz : (low, high) tuple [Hz]
        Excited band the plan states.
    plan_hash : str
        What was released.
    window_frequencies_hz : tuple of arrays [Hz]
        Natural frequencies of every live window.
    """

    truth: TrueModes
    band_hz: tuple[float, float]
    plan_hash: str
    window_frequencies_hz: tuple[NDArray[np.float64], ...]
