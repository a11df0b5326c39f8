"""The fixtures of a cell, for all tests of the bridge."""

from test.support.cell_fixtures import (
    domain,
    drivers,
    message,
    model,
    operator,
    peers,
    plan,
    processes,
    pulses,
    start_deg,
)

__all__ = [
    'domain',
    'drivers',
    'message',
    'model',
    'operator',
    'peers',
    'plan',
    'processes',
    'pulses',
    'start_deg',
]
