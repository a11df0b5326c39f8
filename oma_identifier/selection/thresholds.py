"""What the selection decides by, all in one place, each with its meaning, source or measure."""

from dataclasses import dataclass

from oma_identifier.likelihood import LIKELIHOOD
from oma_identifier.spectra import SPECTRA


@dataclass(frozen=True, slots=True)
class SelectionThresholds:
    """Limits of the selection, in the order in which a pole meets them.

    Blurs, steps and distances are in half-power half-widths ζf of the pole; u₀ is the least blur
    that any method can reach, 1 / sqrt(2π ζ f T) half-widths (Au 2014).
    """

    # A pole repeats from one model order to the next.
    least_relative_step: float = 0.005
    """Frequencies this close agree whatever the damping: lightly damped poles are as sharp."""
    damping_step: float = 0.5
    """Damping ratios agree within this share of their mean; twice what 10 cycles ζfT determine."""
    repeated_mac: float = 0.8
    """Least MAC of poles of successive model orders."""

    # Poles of all orders form clusters.
    cluster_cut: float = 1.0
    """Poles one half-power half-width apart, or with orthogonal shapes, are different modes."""

    # The data determine the pole.
    widest: float = 0.5
    """Largest blur of the most precise member; where most model orders have the pole ``doubtful``
    times u₀.  In 125 random records of light, heavy and mixed damping, 1 to 12 channels and 20 to
    60 s, 45 poles of modes passed by that alone, 7 within two spectral lines of a mode, and no
    other; spurious poles follow the noise, and begin at 9 u₀."""
    widest_mean: float = 1.0
    """Largest blur of what is reported."""
    doubtful: float = 4.0
    """Multiple of u₀ from where on the spectrum must peak."""
    far: float = 6.0
    """Multiple of u₀ from where on the blur must be below ``widest_far``."""
    farthest: float = 9.0
    """Multiple of u₀ from where on there is no mode."""
    widest_far: float = 1.0 / 3.0
    too_certain: float = 0.7
    """Multiple of u₀ below which nothing that random forces move can scatter."""
    least_cycles: float = LIKELIHOOD.told_cycles
    """Least number of half-power half-widths that the record resolves, ζfT; of fewer, the damping
    is biased upwards and its deviation means nothing: it is reported without.  And what it is
    must be shown: it could be a line."""

    # What is reported of it.
    damping_bias: float = 2.0
    """What a record adds to a half-width, over its length [rad/s]: one for lags that it holds less
    often the longer they are, one for estimating (Marriott and Pope 1954).  Measured 1.8 ± 0.2 for
    ζfT of 0.5 to 10, 142 modes."""
    least_left: float = 0.7
    """Share of a damping ratio that is left of it at least: one that is small came out small by
    chance.  Of 139 modes found with ζfT of 0.1 to 1 the true one was 0.75 times it in the median,
    whatever it was."""
    order_bias: float = 0.08
    """Deviation by the finite model order, which the scatter of blocks does not hold, in
    half-widths.  Without it and ``damping_bias`` 2σ covered 92 ± 2 % of 275 frequencies and 89 ±
    2 % of 195 damping ratios that were not refined, in 130 records of random families; with both
    95 ± 1 and 95 ± 2 %."""

    # The members that are averaged.
    trials: tuple[float, ...] = (0.0, 0.2, 0.5, 0.9)
    """Members whose standard deviations are compared, as shares of a cluster by model order;
    those of low order scatter least, those of higher order tell whether the lower are biased."""
    trials_measured: tuple[float, ...] = (0.2, 0.5, 0.9)
    """The same where the force is measured with noise.  The member of lowest order looks most
    precise there, and is off by more than that, while those above scatter too much to tell: of
    225 frequencies under milling forces with it 93 % were within 2σ (worst 5.1σ), without it 99 %
    (2.7σ), the errors being the same.  Where the input is known well it is the best: without it
    errors were 10 % larger, and deviations 1.7 times the errors instead of 1.2 times."""
    biased: float = 1.5
    """Squared difference over its variance from where on a member is biased; 1 on average."""
    within: float = 2.0
    """Members whose variance is within this factor of the best are averaged."""

    # The spectrum and the phases speak for it.
    broad: float = 0.03
    """Damping ratio from where on a pole may describe the edge of an excited band."""
    peak_chance: float = 0.01
    """Probability of taking the edge of an excited band for a peak."""
    least_mpc: float = 0.5
    """Below, the phases of a shape are nearer to a circle than to a line; a close pair mixes."""
    close: float = 3.0
    """Distance of a close pair, in half-widths of the wider mode."""

    # One pole for each mode.
    same_distance: float = 2.0
    """Largest distance of two views of one mode, in half-widths of the wider."""
    same_mac: float = 0.9
    """Least MAC of two views of one mode."""
    same_std: float = 6.0
    """Standard deviations of their difference between two views of one mode at most.  Of 60 random
    pairs, a light mode in the bell of a broad one seen by one or two channels, both are found in
    42 instead of 32, and nothing else; 225 records of random families show 3 modes more and no
    false one."""

    # Lines of machines and drives.
    sharp: float = 2.0 * SPECTRA.suspect_damping
    """What is damped less may be a line; the image of a line has next to no damping."""
    same_line: float = 0.003
    """Relative distance of two views of one line."""
    same_run: float = 0.002
    """Relative step within the undamped poles of one line."""
    line_orders: int = 6
    """Undamped poles of a line repeat over at least one in this many model orders."""
    fewest_line_orders: int = 3
    """And over this many."""
    fewest_filtered: int = 3
    """Fewest channels that a modal filter makes sense of: fewer have no neighbour to spare."""
    least_filtered: float = 0.25
    """Share of a shape's square that a modal filter must leave of it: noise grows as it falls."""
    line_damping: float = 0.01
    """Damping ratio below which a mode that only the likelihood found is the line beside it."""


SELECTION = SelectionThresholds()
