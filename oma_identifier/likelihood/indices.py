"""What a position counts: a number of one kind cannot be passed as one of another."""

from typing import NewType

ModeIndex = NewType('ModeIndex', int)
"""Position among all modes of a record, those of :class:`StartModes`."""
BandIndex = NewType('BandIndex', int)
"""Position among the free modes of the fit of one band."""
