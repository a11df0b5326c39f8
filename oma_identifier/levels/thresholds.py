"""Limits of what recordings at several levels tell, in one place, with source or measure."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class LevelThresholds:
    """Limits of laws over the level."""

    # The motion of a mode.
    half_widths: float = 8.0
    """On either side of a mode that are looked at: a linear mode has 92 % of its power there."""
    peak_half_widths: float = 2.0
    """The same for how much modes move, one beside another: 70 % of the power; chosen."""
    flank_half_widths: float = 16.0
    """The same for the width of the peak, of which flanks tell the force that drives the mode.
    Twice the band takes 1.25 instead of 1.57 of the law's least deviation (Fisher information of
    width, height, centre and noise), three times 1.17."""
    flank_share: float = 1.0 / 3.0
    """Of the frequency, that flanks reach to at most: of 191 simulated linear modes of ζ 0.5 to
    6 % the half-width by the amplitude was 1 % large up to there, and 2 % up to a half."""
    widths_apart: float = 2.0
    """By which half-widths in the narrow and the wide band may differ, over the least deviation:
    twice what they differ by in theory, 0.6."""
    ends: float = 3.0
    """Decay times at either end of a record that are left out: a band that is cut out of the
    spectrum takes the record for periodic."""
    fewest_ends: float = 12.0
    """Such ends that a record has at least: of 30 simulated oscillators at four levels, cubic in
    both, the values found were off by 1.1, 0.9, 1.2 and 0.95 of their deviations rms (cubic
    stiffness, cubic damping, frequency, damping ratio), with 20 ends by 0.8, 0.9, 0.85 and 1.2;
    one of the 30 was told to be friction, with 20 none."""
    largest_noise: float = 0.5
    """Share of the power in the band that is no peak, from where on a mode's motion is not told
    from noise; chosen."""
    least_direction: float = 0.05
    """Singular value of the shapes nearby, over the largest, that still counts; chosen."""
    amplitude_scatter: float = 0.08
    """Relative standard deviation of an amplitude, times the root of ζ f T: of 200 simulated
    records of 60 to 1,200 s, ζ 0.5 to 6 %, it was 0.03 to 0.07."""
    width_scatter: tuple[float, float] = (1.5, 1.35)
    """Standard deviation of a half-width over the law's 1 / √(2π ζ f T), in the narrow and in the
    wide band: of 191 simulated records of 60 to 1,200 s, ζ 0.5 to 6 %, 1.4 and 1.3."""
    amplitude_width_scatter: tuple[float, float] = (2.0, 1.7)
    """The same of a half-width by the amplitude alone: of the same records 1.9 and 1.6."""

    # Laws.
    fewest_levels: int = 3
    """That tell a law from a line through two points."""
    least_factor: float = 2.0
    """Of the largest amplitude over the smallest; chosen: a change with the square is then at
    least three quarters of what the largest level shows."""
    most_bent: float = 2.0
    """Half-widths by which cubic stiffness moves a peak at the largest level, up to which its
    width is damping: beyond, cubic damping that was none came out 3.5 standard deviations large.
    The amplitude tells damping until the peak leaves its band: of 26 modes that moved by 2 to 8
    half-widths cubic damping was off by 0.84 deviations rms, of four others one by 3.7."""
    stiffness_change: float = 0.5
    damping_change: float = 2.0
    """Standard deviation of what a term adds at the largest level, over what is there, before
    anything is measured; chosen.  Twice as much takes half off how likely a change is."""
    least_beyond: float = 1e-3
    """Of the motion's power beyond a gap, below which it is not looked for; chosen."""
    odds: float = 20.0
    """Beyond which the less likely of two laws is excluded."""
    colour: float = 4.0
    """Standard deviation beforehand of the exponent of the force's power over frequency about a
    mode: a base that shakes has -4 in accelerations over ground."""
    straight: float = 1.0
    """Half-widths that a level may move the peak by, and flanks still tell the force's colour:
    of 12 simulated oscillators each the exponent was off by 0.1 there, by 0.9 at twice that."""
    bent: float = 0.25
    """Share of a change of the stiffness that the identified frequency may be off by: of 20 modes
    of chains that changed by more than four deviations it had 0.95 of it, and scattered by 0.2
    (seeds 981000 to 981035; of four more the band had motion of other modes)."""
    most_off: float = 0.5
    """Half-widths that moments may be off the identified frequency by: other modes that are eight
    away then have a sixteenth of the power; chosen."""
    confirmed_std: float = 2.5
    """Of its own deviations by which the amplitude alone has what the width has, and by how many
    of both they may differ: a change that is none is confirmed in 0.6 of 100 cases.
    Of 56 modes of 20 random chains with linear damping, and cubic springs or play at one place or
    two, 14 had been told another law than constant by their width, none is; of 30 oscillators,
    cubic in both, the 18 that had been told it with a deviation are."""
    least_spread: float = 0.1
    """Of the amplitude, over 2 of Rayleigh's law, that its moments are taken for; chosen."""
    least_chance: float = 1e-3
    """Of the χ² of a law; below, it does not describe the levels."""


LEVELS = LevelThresholds()
