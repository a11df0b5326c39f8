"""Matrix notch filter before poly-reference least squares, as a method of the catalogue."""

from oma_identifier.methods.plscf import Plscf
from oma_identifier.methods.without_lines import WithoutLines
from oma_identifier.moving_lines import by_notch

NOTCH = WithoutLines('notch', Plscf(), by_notch)
"""Lines zeroed by a projector that moves with them, then poly-reference least squares."""
