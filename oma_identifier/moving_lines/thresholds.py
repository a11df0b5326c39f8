"""What decides about lines that move, in one place, with the reasons."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class MovingThresholds:
    """Limits of the search for lines that move with a speed."""

    widest_change: float = 0.15
    """Share of its frequency by which a line may move within a record, at about that frequency a
    frame of the spectrogram is as long as the motion within it allows."""
    sweep: float = 0.3
    """The same from where on it is no speed that varies but a sweep, which shakes the structure
    and is the excitation itself: such a line stays."""
    highest: float = 0.42
    """Share of the sample rate up to which lines are looked for: above stand converters' filters.
    """
    ridge: float = 1.5
    """Mean logarithm of power along the best ridge over the median at its frequency, from where on
    a line is looked for there: 0.7 to 0.9 without one (20 records), 3 and more for lines 20 dB
    above the response in 1 Hz.  Only spares time: what follows decides."""
    steps: tuple[int, ...] = (4, 8, 16, 24)
    """Knots of the course of the speed: as few as make its lines stand still."""
    moved: float = 12.0
    """Spectral lines that an order must move to prove a course by being narrow in its time alone:
    below, it may be narrow as it is.  Where the course is known otherwise one line does."""
    far: float = 8.0
    """The same over the number of knots where one order is all there is: a course could follow the
    random phase of a light mode of ζfT up to the number of knots, which moves by some
    half-widths."""
    narrowest_waver: int = 4
    """Half-width in spectral lines of the narrowest peak whose envelope is looked at."""
    widest_waver: float = 0.03
    """Share of its frequency up to which a speed wavers; more is a change of speed."""
    waver_stands_out: float = 10.0
    """Power of a peak over what is usual within eight widths: that of a mode, or a line.  Only
    spares time, as the next two: the proof decides."""
    wavers_tried: int = 4
    """Peaks of every width."""
    even_by_chance: float = 0.3
    """Chance of so even an envelope of a mode."""
    coherent: float = 1.1
    """Power of an order that is coherent in the shaft's time over that in the samples, from where
    on it proves a course: in 40 milled records with steady lines it was 1.011 at most, with 0.05 %
    of wander 1.04 to 1.8."""
    lowest_order: int = 8
    """Of its shaft that the strongest line, and the lowest one, is at most."""
    same_order: float = 2.0
    """Spectral lines within which all are multiples of a fraction of the lowest one."""
    base_by_chance: float = 1e-3
    """Chance that they are, of lines anywhere."""
    wrong_order: float = 1e-3
    """Chance that one of the orders that are then asked about is none."""
    most_shafts: int = 3
    """Courses that are looked for in turn."""
    most_orders: int = 32
    """Orders of a shaft."""
    most_knots: int = 48
    """Of the amplitude of a line; more would follow the response to random forces."""


MOVING = MovingThresholds()
