"""Whether the samples of a channel are measurements.

In come the rows of one window; out go the health of each channel and the reason where it is
left out: clipped, frozen, repeated, wrapped, without sign, reversed, copied, lost or against
gravity.
"""

from oma_identifier.quality.converter_watch import ConverterWatch
from oma_identifier.quality.copies import COPIED, copies
from oma_identifier.quality.filled import DAMPING_UNSURE, is_damping_unsure, SureDamping
from oma_identifier.quality.flagged import channels_by_flag
from oma_identifier.quality.health import (
    ChannelHealth,
    examine,
    EXCLUDING,
    joined,
    noise_rms,
    summarise,
    Summary,
)
from oma_identifier.quality.heard import heard_to_hz, without_unheard
from oma_identifier.quality.repeats import RepeatWatch
from oma_identifier.quality.setup_check import check_gravity
from oma_identifier.quality.sizes import check_sizes, times_of_alike
from oma_identifier.quality.thresholds import QUALITY

__all__ = [
    'COPIED',
    'DAMPING_UNSURE',
    'EXCLUDING',
    'QUALITY',
    'ChannelHealth',
    'ConverterWatch',
    'RepeatWatch',
    'Summary',
    'SureDamping',
    'channels_by_flag',
    'check_gravity',
    'check_sizes',
    'copies',
    'examine',
    'heard_to_hz',
    'is_damping_unsure',
    'joined',
    'noise_rms',
    'summarise',
    'times_of_alike',
    'without_unheard',
]
