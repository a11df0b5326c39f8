"""The arm with its flexibilities as one larger pinocchio model.

In come the rigid arm and a spec; out goes an assembly, in which every flexible degree of freedom
is a joint of its own, with the springs and dampers on them.
"""

from structural_model.assembly.assemble import assemble
from structural_model.assembly.assembled import Assembly
from structural_model.assembly.rigid_arm import correctable_links

__all__ = ['Assembly', 'assemble', 'correctable_links']
