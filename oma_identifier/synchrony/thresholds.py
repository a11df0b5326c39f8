"""What tells that a sensor is late, hears something else or changed, with source or measure."""

from dataclasses import dataclass
import math


@dataclass(frozen=True, slots=True)
class SynchronyThresholds:
    """Limits of the tests of sensors against one another, in the order in which they are made."""

    # Peaks that are looked at.
    prominence_db: float = 6.0
    """Height above both valleys: two and a half deviations of a difference of averaged powers."""
    top: float = 0.86
    """Share of the band up to where samples are shifted without error."""
    coherent: float = 0.3
    """Least squared coherence of a peak; noise of 11 values comes there in one of thirty-five."""
    fewest_free: float = 6.0
    """Independent values of a peak, at least."""
    beat_lines: int = 12
    """Lines of a peak from where on its beat is its own and not that of the taper."""
    line_kurtosis: float = 1.1
    """Fourth moment of the amplitude of a peak, over the square of its second, below which a
    machine makes it: of a random response it is 2, less in few lines.  Of 1,432 peaks of random
    structures with as many lines as a beat needs five came below (seeds 384600 to 384604 of the
    families and five milling arms without lines); so did all of 58 lines of steady machines and 38
    of 42 of a spindle whose speed grows."""
    phase_alike: float = 0.05
    beat_alike: float = 0.2
    """Power of a sensor at a peak, in shares of its variance, over that of the others, or the
    inverse, from where on its phase, and its beat, are those of that mode.  Of 80 random
    structures of two or three parts that share little but one or two forces (seeds 985500 to
    985579) 110 of 595 healthy sensors were said to be late without either, 6 with the second
    alone, none with both; of 80 with a late sensor it alone was named in 14 without, in 18 with
    both.  Of 80 whose modes have forces of their own it was in 41 and 36, and no healthy one
    either way."""

    # A sensor is late.
    shortest_s: float = 10.0
    """Of a shorter window nothing is told."""
    latest_s: float = 0.5
    """Largest delay that is looked for."""
    delay_odds: float = 1e3
    """Odds of a delay against none from where on it is believed.  Of 968 synchronous sensors of
    random structures, shapes of up to 30 % imaginary part, one came there; none was said to be
    late."""
    sure: float = 0.99
    """Share of what speaks for delays that must speak for one of them."""
    largest_phase_rad: float = math.radians(10.0)
    """Largest error of a phase, at three deviations of the delay, that a shape is published
    with."""
    surprise: float = 4.0
    """Standard deviations from where on a newer delay is another one."""

    # A sensor does not show what the others show.
    above_noise: float = 4.0
    """Power of a peak over that of the noise, from where on it is looked at."""
    least_coherence: float = 0.8
    """Share of a sensor's power at a peak, noise left out, that the others explain.  In 1,200
    records of random structures (one to twelve modes, damped by 0.2 to 12 %; seeds from 905000) 18
    of 924 healthy channels of two sensors with three axes came below, none of 5,103 of three to
    five, and 2 of 5,406 of four to fifteen sensors of one axis; of 150 sensors each with old
    samples, with a clock that drifts and with images of higher frequencies 93, 93 and 67 % did."""
    left_out_coherence: float = 0.6
    """The same below which a sensor is left out; between the two it is named only.  One of the
    healthy channels above came below; of the faulty sensors 83, 83 and 46 %."""
    fewest_used: float = 1.5
    """Coefficients from where on others can tell: two modes that overlap are more than one of
    them."""
    fewest_others: int = 3
    """Channels from where on others are asked at all: of three healthy channels one in twenty came
    below ``least_coherence`` in structures of up to twelve modes."""
    agreed: float = 0.95
    """Share of the others' power at a peak that they explain of one another, from where on a
    sensor that they do not explain contradicts them.  Where more modes overlap than they have
    channels they explain neither one another nor a healthy sensor."""
    alike: float = 0.2
    """Power over the others', both in shares of their variance, from where on a peak is compared.
    One that a sensor shows alone may be an image of what lies above half its rate, or a part of
    its own that rattles: the two cannot be told apart, and neither is a mode of the structure."""
    left_out_alike: float = 0.5
    """The same from where on a sensor is left out, and not only named: where it moves less than
    the others it shows neighbouring modes and noise as well.  Healthy sensors of measured and
    simulated buildings were left out of 24 windows in 236, without it of 48; of 64 sensors with
    old samples or a clock that drifts 86 % were, without it 91 %, and 97 % were named."""
    deaf: float = 1e-3
    """Chance above which a channel has no more in common with the others than noise has."""

    # A sensor is not heard for a while.
    fewest_blocks: int = 16
    """Blocks that tell what is usual."""
    fewest_witnesses: int = 2
    """Sensors beside those that are not heard."""
    unexplained: float = 0.1
    """Share of a channel's power that the others leave in most blocks, at most."""
    lost: float = 0.3
    """The same, at least, of a channel that followed the others before and no longer does."""
    gone: float = 0.5
    """The same, from where on a block may be none of the structure."""
    heard: float = 0.25
    """Squared correlation of a channel with what the others say in a block, from where on it is
    heard; where the rest is as many times as loud it cannot come there.  With 0.5 alone, 0.25 and
    0.1, 11, 4 and 2 of 204 healthy sensors of bridges crossed by vehicles were said not to be
    (985000 to 985011, 985200 to 985211), and 21, 20 and 19 of 24 faults were told (983500 to
    983523), with 1, 1 and 3 false modes left."""
    surprising: float = 20.0
    """Times of what is usually left in a block as loud.  Of 140 healthy records of seven random
    families (white to bursting forces, drifting frequencies, lines; seeds from 983800) none had a
    suspected channel; of 20 of a robot that moves, and nobody says so, two had."""
    others_go_on: float = 4.0
    """The same, a mean over the others, up to which they go on as before."""
    follows: float = 0.5
    """Squared correlation with what the others say, from where on a channel follows them."""
    most_interrupted: float = 0.2
    """Share of a window that is filled in, at most; see ``QUALITY.most_filled``."""

    # A sensor is not what it was.
    same_pose_rad: float = 0.05
    """Largest difference of a joint between windows that are compared."""
    seen: float = 0.3
    """Share of a channel's power at a peak that the fit may leave for the channel to count
    there."""
    failure_chance: float = 1e-4
    """Probability that a channel's prediction fails at one peak, for one moment."""
    least_share: float = 0.03
    """Share of a channel's power that the prediction must lack: of a gain that is off by a fifth,
    or a mount turned by 10 degrees."""
    fewest_peaks: int = 2
    """Peaks at which a sensor must break."""
    share_of_peaks: float = 0.67
    """The same, of those at which it is seen."""
    fewest_left: int = 2
    """Sensors that bear witness of one another."""
    most_changed: int = 2
    """Sensors that may change at once; more are a change of the structure."""
    unlikely_moment: float = 6.0
    """Log-likelihood below the best from where on a moment is not that of the change."""
    explained: float = 0.15
    """Share of a misfit that may be left for a kind of change to explain it."""
    preferred: float = 2.0
    """Times what the best kind leaves, up to which a simpler one is preferred."""
    peaks_to_spare: int = 2
    """Peaks beyond as many as channels, which any mixture of channels would explain."""


SYNCHRONY = SynchronyThresholds()
