"""Identified modes beside the true ones of a model or an emulated arm."""

from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from modal_core.mode import Mode, ModeSet
from modal_core.numbers.assignment import cheapest_pairs
from modal_core.numbers.indicators import mac

LARGEST_FREQUENCY_ERROR = 0.10
SMALLEST_MAC = 0.5


@dataclass(frozen=True, slots=True)
class TrueMode:
    """One true mode and the identified one that belongs to it.

    Parameters
    ----------
    frequency_hz : float [Hz]
        True natural frequency.
    damping_ratio : float
        True damping ratio; NaN when unknown.
    mode : Mode or None
        Its identified counterpart; None when it was missed.
    mac : float
        Between true and identified shape; NaN when missed or no true shape is known.
    from_window : bool
        The whole recording does not show it; its counterpart is from a single window.
    """

    frequency_hz: float
    damping_ratio: float = math.nan
    mode: Mode | None = None
    mac: float = math.nan
    from_window: bool = False

    @property
    def frequency_error(self) -> float:
        """Identified over true frequency minus one; NaN when missed."""
        return self.mode.frequency_hz / self.frequency_hz - 1.0 if self.mode else math.nan

    @property
    def frequency_error_sigma(self) -> float:
        """Frequency error in the mode's own standard deviations; NaN when not known."""
        if self.mode is None:
            return math.nan
        return _in_sigma(self.mode.frequency_hz - self.frequency_hz, self.mode.frequency_std_hz)

    @property
    def damping_error_sigma(self) -> float:
        """Damping error in the mode's own standard deviations; NaN when not known."""
        if self.mode is None:
            return math.nan
        return _in_sigma(self.mode.damping_ratio - self.damping_ratio, self.mode.damping_ratio_std)


def match_truth(
    identified: ModeSet,
    frequency_hz: ArrayLike,
    damping_ratio: ArrayLike,
    shapes: NDArray[np.complex128] | None = None,
) -> tuple[TrueMode, ...]:
    """Pair true with identified modes, one to one.

    Parameters
    ----------
    identified : ModeSet
        Modes found; harmonics take no part.
    frequency_hz : (n_modes,) array [Hz]
        True natural frequencies.
    damping_ratio : (n_modes,) array
        True damping ratios.
    shapes : (n_channels, n_modes) complex array or None
        True shapes at the identified channels.

    Returns
    -------
    tuple of TrueMode
        One per true mode, in the order given.  A pair differs by at most 10 % in frequency and
        has MAC of at least 0.5; among these the assignment has the least total of relative
        frequency error and 1 - MAC.
    """
    true_frequency = np.atleast_1d(np.asarray(frequency_hz, dtype=float))
    true_damping = np.atleast_1d(np.asarray(damping_ratio, dtype=float))
    modes = [mode for mode in identified if not mode.harmonic]
    found = np.array([mode.frequency_hz for mode in modes], dtype=float)
    error = np.abs(found[None, :] / true_frequency[:, None] - 1.0)
    agreement = np.full(error.shape, np.nan)
    if shapes is not None and modes:
        agreement = mac(shapes, np.column_stack([mode.shape for mode in modes]))
    allowed = (error <= LARGEST_FREQUENCY_ERROR) & ~(agreement < SMALLEST_MAC)
    cost = np.where(allowed, error + np.nan_to_num(1.0 - agreement), 1e3)
    partner = {
        int(row): int(column)
        for row, column in zip(*cheapest_pairs(cost), strict=True)
        if allowed[row, column]
    }
    return tuple(
        TrueMode(
            frequency_hz=float(true_frequency[index]),
            damping_ratio=float(true_damping[index]),
            mode=modes[partner[index]] if index in partner else None,
            mac=float(agreement[index, partner[index]]) if index in partner else math.nan,
        )
        for index in range(len(true_frequency))
    )


def _in_sigma(error: float, std: float) -> float:
    return error / std if std > 0.0 else math.nan
