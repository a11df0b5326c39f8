"""Sensors whose stamps are late: mode shapes as if all had been sampled together.

A sensor that is late by τ reads the mode at t - τ: its frequency and damping are the same, its
entry of the shape is multiplied by e^(-λτ).  Undoing that costs nothing; the samples stay as they
are.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
import math

import numpy as np

from modal_core.indicators import mpc, mpd, normalise
from modal_core.mode import Mode, ModeSet


@dataclass(frozen=True, slots=True)
class Lag:
    """How late one channel is.

    Parameters
    ----------
    seconds, std_s : float [s]
        Against the joint states, with its standard deviation.
    behind_s : float [s]
        Against the other sensors; 0 where no difference is proved.
    """

    seconds: float
    std_s: float
    behind_s: float = 0.0


def in_step(modes: ModeSet, lags: Mapping[str, Lag]) -> ModeSet:
    """Return the modes with the phases they have without the sensors' delays.

    Parameters
    ----------
    modes : ModeSet
        As identified.
    lags : mapping of str to Lag
        By channel; what is not named is not late.
    """
    behind = np.array([lags[n].behind_s if n in lags else 0.0 for n in modes.channel_names])
    if not behind.any():
        return modes
    return replace(modes, modes=tuple(_in_step(mode, behind) for mode in modes))


def _in_step(mode: Mode, behind_s: np.ndarray) -> Mode:
    omega = 2.0 * math.pi * mode.frequency_hz
    pole = omega * complex(-mode.damping_ratio, math.sqrt(1.0 - mode.damping_ratio**2))
    shape = normalise(mode.shape * np.exp(pole * behind_s))
    column = shape[:, None]
    return replace(mode, shape=shape, mpc=float(mpc(column)[0]), mpd=float(mpd(column)[0]))
