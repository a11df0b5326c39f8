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
    reach: float = 2.0
    """A pole is sought within so many times, and one over so many times, where it begins."""
    least_damping: float = 1e-4
    """Damping ratios are sought from here on, and"""
    most_damping: float = 0.5
    """up to here."""
    most_steps: int = 100
    """Of a fit: it converges within a third of them, or wanders (some fifty records)."""
    stands_out: float = 5.0
    """Standard deviations of chance by which a mode explains more than noise. In random arms, each
    with one pole too many, none of these was told and none of 240 modes lost."""
    most_tried: int = 6
    """Places where a mode is looked for that is not the model's, or in place of one told twice.
    Chosen, not measured."""
    added_damping: float = 0.02
    """Of such a mode, to begin with."""
    apart: float = 3.0
    """Standard deviations between two modes that are not one: 0.3 % of one told twice."""
    near_bins: float = 1.5
    """Bins to either side of a line of a machine that are left out."""


LIMITS = ModeLimits()
