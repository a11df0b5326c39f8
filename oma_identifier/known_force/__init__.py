"""Forces that were measured beside the responses, and the modal masses that follow from them.

In come a force and samples; out go samples with the force as known input, and how far the force
moves each mode.
"""

from oma_identifier.known_force.known_force import KnownForce
from oma_identifier.known_force.lines_apart import lines_apart
from oma_identifier.known_force.modal_scaling import modal_scaling, ModalScaling

__all__ = ['KnownForce', 'ModalScaling', 'lines_apart', 'modal_scaling']
