"""What the pole of a mode scatters by at least, and the least deviation to publish with it.

A record under a steady force tells real and imaginary part of a pole, both to √(ζfT / 2π) / T.
An estimate states that for its own damping.  One whose damping came out low by chance states too
little: less than the law at the damping that is there.

References
----------
Whittle (1953), doi:10.1007/BF02590998 (information in the spectrum of a random process).
"""

from dataclasses import replace
import math

from modal_core.mode import Mode
from oma_identifier.likelihood.thresholds import LIKELIHOOD


def least_blur(cycles: float) -> float:
    """Return the least standard deviation that any method can reach, u₀, in half-widths.

    Parameters
    ----------
    cycles : float
        ζfT, of the true damping ratio.
    """
    return 1.0 / math.sqrt(2.0 * math.pi * cycles)


def least_scatter(damping_ratio: float, periods: float) -> float:
    """Return the least deviation to publish, of a frequency over itself and of a damping ratio.

    Parameters
    ----------
    damping_ratio : float
        As estimated.
    periods : float
        Of the mode in the record, fT.
    """
    cycles = damping_ratio * periods + LIKELIHOOD.untold_cycles
    return LIKELIHOOD.least_scatter * cycles * least_blur(cycles) / periods


def with_least_scatter(mode: Mode, duration_s: float) -> Mode:
    """Return a mode with no less than the least deviation; without σ it stays without.

    A record too short for the damping leaves it without σ.  Known inputs tell a pole more sharply
    than random ones: where they take part nothing changes.
    """
    if mode.known_motion:
        return mode
    periods = mode.frequency_hz * duration_s
    least = least_scatter(mode.damping_ratio, periods)
    told = mode.damping_ratio * periods >= LIKELIHOOD.told_cycles
    return replace(
        mode,
        # The first argument stands where it is NaN.
        frequency_std_hz=max(mode.frequency_std_hz, least * mode.frequency_hz),
        damping_ratio_std=max(mode.damping_ratio_std, least) if told else math.nan,
    )
