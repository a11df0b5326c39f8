"""A spring that holds and a damper that takes energy away: nothing else is one."""

from modal_core.errors import ModelError
from structural_model.description.spec import Spring


def check_spring(spring: Spring, where: str) -> None:
    """Refuse a spring that pushes away, and a damper that drives.

    Raises
    ------
    ModelError
        Naming which of the two it is.
    """
    if not spring.stiffness > 0.0:
        raise ModelError('spring without positive stiffness', where=where, found=spring.stiffness)
    if not spring.damping >= 0.0:
        raise ModelError('negative damping', where=where, found=spring.damping, expected='>= 0')
