"""What modes are told and paired by, in one place, with source or measure."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class ModeLimits:
    """Limits of fitting modes to a recording and of pairing them with the model's."""

    lowest_hz: float = 3.0
    """Modes are compared from here on [Hz], and"""
    highest_hz: float = 58.0
    """up to here at most: half of what joint states of 125 Hz carry, nearly."""
    most_poses: int = 4
    """Poses whose modes are compared, held-out ones first. Chosen, not measured."""
    frequency_weight: float = 2.0
    """Of 100 % of frequency beside a MAC of 0, in pairing modes. Chosen, not measured."""
    least_mac: float = 0.4
    """Of a pair. Chosen, not measured."""
    most_off: float = 0.35
    """Of the frequencies of a pair, as a share: a joint half as stiff moves a mode by 0.29
    at most."""
    beyond: float = 1.3
    """Modes up to so many times the highest frequency take part in the fit; higher ones respond
    below as a stiffness does."""
    stands_out: float = 5.0
    """Standard deviations of chance by which a mode explains more than noise. In random arms, each
    with one pole too many, none of these was told and none of 125 modes lost."""
    least_told: float = 0.03
    """Standard deviation of a frequency, as a share, beyond which a mode is not told.
    Chosen, not measured."""
    near_bins: float = 1.5
    """Bins to either side of a line of a machine that are left out."""


LIMITS = ModeLimits()
