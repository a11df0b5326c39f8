"""Modes that are too slow for the windows of a record, and windows that would do."""

from collections.abc import Callable, Iterable

from modal_core.mode import Mode
from oma_identifier.covariance import COVARIANCE

FEW_DECAYS = 2.0
"""Damping times frequency times duration below which damping scatters by 28 % or more at best:
1 / √(2π ζ f T), Au (2014), doi:10.1016/j.ymssp.2013.12.016."""


def needed_window_s(mode: Mode) -> float:
    """Return how long a window must be to look for a mode, and to tell its damping roughly [s]."""
    return max(COVARIANCE.periods, FEW_DECAYS / mode.damping_ratio) / mode.frequency_hz


def too_slow(
    modes: Iterable[Mode], window_s: float, share_of: Callable[[Mode], float]
) -> list[Mode]:
    """Return the modes that most windows do not show because they are too short.

    Parameters
    ----------
    modes : iterable of Mode
        Of the record, with the ids they have in the windows.
    window_s : float [s]
        Length of a window.
    share_of : callable
        A mode to the share of the windows that show it.
    """
    return [mode for mode in modes if share_of(mode) < 0.5 and needed_window_s(mode) > window_s]
