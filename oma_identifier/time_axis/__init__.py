"""When each sample was taken: stamps and counters made into one uniform time axis per source.

In come samples in the order they arrive; out go rows at equal steps, with gaps filled by
autoregressive interpolation (Janssen, Veldhuis and Vries 1986, doi:10.1109/TASSP.1986.1164824)
and rates joined by band-limited resampling. What no other message confirms is set aside and
counted.
"""

from oma_identifier.time_axis.block_clock import BlockClock
from oma_identifier.time_axis.block_gate import BlockGate, Passed
from oma_identifier.time_axis.candidates import Candidates
from oma_identifier.time_axis.coarse_stamps import count, is_coarse, tick_of
from oma_identifier.time_axis.far_values import FarValue, FarValues
from oma_identifier.time_axis.gaps import longest_filled, measured, no_measurement
from oma_identifier.time_axis.lattice import (
    GridRows,
    Lattice,
    make_lattice,
    margin_ns,
    on_grid,
)
from oma_identifier.time_axis.rate_check import tells_rate, typical_step
from oma_identifier.time_axis.resample import (
    HALF_WIDTH,
    half_width,
    interpolate,
    KAISER_BETA,
)
from oma_identifier.time_axis.source_stream import OrderedSamples, SourceStream
from oma_identifier.time_axis.thresholds import TIME_AXIS

__all__ = [
    'HALF_WIDTH',
    'KAISER_BETA',
    'TIME_AXIS',
    'BlockClock',
    'BlockGate',
    'Candidates',
    'FarValue',
    'FarValues',
    'GridRows',
    'Lattice',
    'OrderedSamples',
    'Passed',
    'SourceStream',
    'count',
    'half_width',
    'interpolate',
    'is_coarse',
    'longest_filled',
    'make_lattice',
    'margin_ns',
    'measured',
    'no_measurement',
    'on_grid',
    'tells_rate',
    'tick_of',
    'typical_step',
]
