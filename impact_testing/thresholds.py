"""Limits of a tap test, each with where it comes from."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class ImpactLimits:
    """What makes a tap good, and a mode a mode.

    Parameters
    ----------
    above_noise : float
        A pulse is this many standard deviations above the noise of the force: of a million
        samples of Gaussian noise one in five hundred records has one.
    double_share : float
        Share of the peak that a second pulse must reach: 2 to 5 % by common practice of modal
        testing; the upper end, for the filter of a converter rings.
    pulse_widths : float
        A pulse may ring this many widths behind its peak.
    ringing_share : float
        Share of the peak up to which a filter rings within those widths (9 % by Gibbs, twice).
    weak_share : float
        Share of the median peak below which a tap is weak (-20 dB).
    unlike : float
        A tap whose answer differs this many times as much as the median tap's does hit another
        point or direction: of healthy taps, whose differences have thousands of degrees of
        freedom, none differs twice as much.
    one_point : float
        By what share a mode may differ from tap to tap on one point.  A tap 1 cm off the end of a
        beam of 1.2 m moves its third mode by 7 % less.
    steps_of_top : float
        Steps of the converter by which a round top of three equal samples falls at most.
    force_range : float
        Share of the power of the force at which the analysed band ends (-20 dB).
    false_modes : float
        Share of tests in which chance adds a mode, by the stated noise.
    most_damping : float
        Damping ratio beyond which a pole is background, no mode: its half-power band is half its
        frequency.
    """

    above_noise: float = 6.0
    double_share: float = 0.05
    pulse_widths: float = 3.0
    ringing_share: float = 0.2
    weak_share: float = 0.1
    unlike: float = 5.0
    one_point: float = 0.2
    steps_of_top: float = 4.0
    force_range: float = 0.01
    false_modes: float = 1e-3
    most_damping: float = 0.25


IMPACT = ImpactLimits()
