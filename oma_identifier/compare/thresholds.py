"""When modes of two records or set-ups are the same, in one place, with source or measure."""

from dataclasses import dataclass
import math


@dataclass(frozen=True, slots=True)
class ComparisonThresholds:
    """Limits of comparing, merging and joining."""

    # Two lists of modes.
    farthest_share: float = 0.3
    """Modes further apart in frequency than this share are never the same."""
    least_mac: float = 0.3
    """Of two modes that may be the same, unless their uncertainty allows for less."""

    # Modes of set-ups that are the same.
    scatters: tuple[float, ...] = 0.0003, 0.001, 0.003, 0.01, 0.03
    """Of frequencies between set-ups, as shares, each thought as likely as the others: weather and
    force; Peeters and De Roeck (2001), doi:10.1002/1096-9845(200102)30:2<149::AID-EQE1>3.0.CO;2-Z,
    measured 14 to 18 % in a year, per cents within days."""
    damping_scatter: float = 0.2
    """Of damping ratios between set-ups, as a share: friction and the level of the force."""
    withheld_scatter: float = 1.0
    """The same of a damping ratio that is stated without a deviation: a record of few cycles tells
    it to a factor of two or three."""
    shape_slack: float = 0.02
    """Loss of MAC at the references beyond chance: sensors that were touched, set-ups that differ.
    """
    narrowest: float = math.log(2.0)
    """Width of log frequency over which a few modes are thought to be spread at least."""
    clear: float = math.log(20.0)
    """Log odds against the best other arrangement; below, which of two modes it is stays open."""

    fewest_mended: int = 2
    """Modes that must fit the other set-ups by one change of one reference, and do not without:
    of 400 random structures in order none was refused."""

    # Their common values.
    least_scatter: float = 0.03
    """Scatter in typical stated deviations below which it adds nothing."""
    largest_scatter: tuple[float, ...] = 0.1, 1.0
    """Of frequencies and of damping ratios between set-ups, as shares."""
    sure_scale: float = 5.0
    """A scale that is not so many deviations from zero is not known: the points are left out."""

    # A pole known from elsewhere, looked for in a set-up.
    pole_reach: float = 6.0
    """Half-widths of the pole in the half spectra over which it is regressed."""
    fewest_lines: int = 20
    """Spectral lines in that stretch: the pole, those beside it and a parabola are regressed on
    them."""
    far_pole: float = 3.0
    """Widths of that stretch from which on other poles are smooth in it: parabolas leave 1 % of
    them."""
    present: float = 3.0
    """Deviations of what the references take part in a pole; without it they exceed it once in
    1,600 (F distribution of 2 and 2 (N_BLOCKS - 1) degrees of freedom)."""
    largest_misfit: float = 4.0
    """Mean square, in deviations, of what the references show beside the shape known there."""


COMPARISON = ComparisonThresholds()
