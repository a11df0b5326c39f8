"""The fixtures of a cell, for all tests of the emulator."""

from test.support.cell_fixtures import *  # noqa: F403
