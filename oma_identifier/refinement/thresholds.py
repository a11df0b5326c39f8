"""What the refinement decides by, all in one place, each with its meaning, source or measure."""

from dataclasses import dataclass
import math


@dataclass(frozen=True, slots=True)
class RefinementThresholds:
    """Limits of the refinement, in the order in which a mode meets them.

    A misfit is the mean square of the whitened residual of a band, 1 where the model holds;
    distances and deviations without unit are in half-power half-widths of the mode.
    """

    # A window begins where the window before it ended.
    remembered_std: float = 4.0
    """Standard deviations of what was found now that what is remembered may be away."""
    remembered_mac: float = 0.9
    """Least MAC of what was found now and what is remembered."""

    # A band lacks modes, or has one too many.
    incomplete_misfit: float = 1.2
    """Misfit from where on a band may lack a mode."""
    most_missing: int = 2
    """Missing modes that are added to the bands of a record, one by one."""
    inside: float = 1.0
    """Least distance of an added mode from the ends of its band."""
    least_rise: float = 50.0
    """Rise of the log-likelihood that an added mode must give; noise alone has reached 37 in the
    best place of a band."""
    determined: float = 0.5
    """Largest standard deviation of an added mode."""
    added_damping: float = 1e-3
    """Least damping ratio of an added mode: below, it may be a line."""
    decisive_misfit: float = 1.1
    """Misfit from where on the likelihood of a band decides nothing."""
    irreplaceable: float = 100.0
    """Times what its parameters are worth that the likelihood falls at once without a mode, from
    where on no mode but one that overlaps with it makes up for it: of two views of one mode one
    began at 0.4 and 0.6, its twin at 62; half of all modes are beyond 500."""
    replacing_steps: int = 10
    """Steps of the other modes to the place of one that is left out."""

    # A refined mode is accepted by what it was refined from.
    accepted_misfit: float = 3.0
    """Largest misfit of a band that the model describes at all."""
    force_chance: float = 1e-3
    """Share of modes without motion in step with their force that are taken to have it.  The test
    takes the other forces for known and so errs less often: of 490 modes under independent forces
    none was below 0.01."""
    one_force: float = 0.8
    """Squared coherence of the forces of two modes from where on they may be one force."""
    bent_std: float = 3.0
    """Standard deviations that a mode may move by where few forces may do more than drive modes.
    Of 90 such fits of made responses, with modes far above that nobody found, one frequency and no
    damping ratio was farther from the truth."""
    known_chance: float = 1e-3
    """Share of bands whose response to known inputs the model describes that are taken to bend."""
    ending_odds: float = math.log(1000.0)
    """Log odds of a bell that ends against a resonance, from where on it is that of a force.  Of
    457 modes that no such force reached 1 came there, of 28 peaks of such forces 13 (97 random
    records of these, seeds from 987000, and 29 of random families, from 383100)."""
    ending_apart: float = 0.75
    """Distance up to which such a bell is that of the supposed mode; with 0.5 it was 11 of the
    28, with 1 a further mode."""

    # It replaces the plain estimate (Hausman 1978).
    adopted_misfit: float = 1.05
    """Largest misfit of what replaces a plain estimate."""
    hopeless_misfit: float = 1.15
    """Misfit from where on the next window will hardly be described better."""
    differing_std: float = 4.0
    """Standard deviations that the two estimates may differ by."""
    same_of_one_channel: float = 1.0
    """Distance up to which the refined estimate of one channel is taken all the same.  Of 505
    modes of 209 random records 45 differed by more than chance, or were told without σ.  Of 38
    within it 35 refined damping ratios held 2σ, and 1 of the 5 plain ones with a σ; 34 and 35
    frequencies.  Beyond it, 13 times in 339 records, neither estimate was the better one."""
    least_spread: float = 0.75
    """Share of the plain estimate's deviation that the deviation of the difference has at
    least."""
    pair_bias: float = 0.25
    """Of the plain estimate where a mode overlaps with another, which its deviation does not
    include.  The end of the spectrum adds the half-width over the distance to it: there no model
    of few orders describes a broad mode."""
    farthest_turn: float = 10.0
    """Times the refined shape's own loss of MAC that the two shapes of a mode that overlaps with
    no other may differ by.  Under independent forces none of 334 differed by so much."""
    turn_bias: float = 0.03
    """Loss of MAC of the plain shape by its bias."""

    # Poles that nothing tells apart.
    repeated_mac: float = 0.95
    """MAC of two poles that overlap from where on they are one mode."""
    repeated_chance: float = 0.01
    """Largest share of unrelated real shapes that may be so alike: four channels or more tell."""


REFINEMENT = RefinementThresholds()
