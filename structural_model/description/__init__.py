"""A robot as it is described: links, joints, springs, limits, and its numbers by name.

In come a URDF and the numbers of a model; out go immutable descriptions that are checked.
"""

from structural_model.description.coupling import AxisCoupling, AxisMap
from structural_model.description.limits import check_length, RobotLimits
from structural_model.description.link_tree import link_of, LinkTree, moves, STANDING
from structural_model.description.parameters import read_parameters, write_parameters
from structural_model.description.shown_units import (
    pose_words,
    read_values,
    shown,
    SLIDING,
    unit_of,
    value_words,
)
from structural_model.description.spec import (
    AbsorberSpec,
    BaseSpec,
    BeamSpec,
    CableSpec,
    CompensatorSpec,
    Drive,
    FoundationSpec,
    HingeSpec,
    JointSpec,
    KnownEffect,
    KnownNumber,
    LinkSpec,
    MassSpec,
    MaterialDamping,
    ModelSpec,
    RodSpec,
    Spring,
    Vector,
)
from structural_model.description.spring_check import check_spring
from structural_model.description.urdf import (
    Joint,
    keep_only,
    load_urdf,
    NEEDED,
    parse_urdf,
    read_urdf,
    read_urdf_file,
    RigidRobot,
    Shape,
)

__all__ = [
    'NEEDED',
    'SLIDING',
    'STANDING',
    'AbsorberSpec',
    'AxisCoupling',
    'AxisMap',
    'BaseSpec',
    'BeamSpec',
    'CableSpec',
    'CompensatorSpec',
    'Drive',
    'FoundationSpec',
    'HingeSpec',
    'Joint',
    'JointSpec',
    'KnownEffect',
    'KnownNumber',
    'LinkSpec',
    'LinkTree',
    'MassSpec',
    'MaterialDamping',
    'ModelSpec',
    'RigidRobot',
    'RobotLimits',
    'RodSpec',
    'Shape',
    'Spring',
    'Vector',
    'check_length',
    'check_spring',
    'keep_only',
    'link_of',
    'load_urdf',
    'moves',
    'parse_urdf',
    'pose_words',
    'read_parameters',
    'read_urdf',
    'read_urdf_file',
    'read_values',
    'shown',
    'unit_of',
    'value_words',
    'write_parameters',
]
