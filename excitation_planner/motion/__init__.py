"""Motions in time: in come seeds, ranges and limits; out go trajectories and their spectra.

Pseudo-random pulses of constant acceleration (Jiao et al. 2025, doi:10.1038/s41598-025-95339-6),
band-limited noise, noise on slow sweeps, and what any of them contains over frequency.
"""

from excitation_planner.motion.band_noise import band_noise_velocity, BandNoiseSettings
from excitation_planner.motion.pulse_shape import PulseShape
from excitation_planner.motion.pulses import Pulse, pulse_velocity, PulseSettings, random_pulses
from excitation_planner.motion.quickest_shape import (
    fitted_shape,
    LEAST_ACCELERATION,
    LEAST_JERK,
    quickest_shape,
)
from excitation_planner.motion.raised_shape import LARGEST_GAIN, raised_shape, Stretch
from excitation_planner.motion.sliding import (
    expected_share,
    LEAST_OF_SHARE,
    MOVING_S,
    sliding_share,
    SlidingJoints,
    sweep_speed,
    sweep_velocity,
    SweepSettings,
    turn_rise,
    wanted_half_range,
)
from excitation_planner.motion.spectrum import (
    flat_spectrum,
    predicted_spectrum,
    PredictedSpectrum,
    Whiteness,
    whiteness,
)
from excitation_planner.motion.trajectory import CONSISTENT_RAD, MotionOnGrid, Trajectory

__all__ = [
    'CONSISTENT_RAD',
    'LARGEST_GAIN',
    'LEAST_ACCELERATION',
    'LEAST_JERK',
    'LEAST_OF_SHARE',
    'MOVING_S',
    'BandNoiseSettings',
    'MotionOnGrid',
    'PredictedSpectrum',
    'Pulse',
    'PulseSettings',
    'PulseShape',
    'SlidingJoints',
    'Stretch',
    'SweepSettings',
    'Trajectory',
    'Whiteness',
    'band_noise_velocity',
    'expected_share',
    'fitted_shape',
    'flat_spectrum',
    'predicted_spectrum',
    'pulse_velocity',
    'quickest_shape',
    'raised_shape',
    'random_pulses',
    'sliding_share',
    'sweep_speed',
    'sweep_velocity',
    'turn_rise',
    'wanted_half_range',
    'whiteness',
]
