"""The equations of motion of the flexible arm, and what they answer.

In come an assembled arm and a pose; out go mass, damping and stiffness, modes, responses in
frequency and time, and what sensors see.
"""

from structural_model.equations.dynamics import Dynamics
from structural_model.equations.linearise import (
    gravity_rows,
    reading_rows,
    rest_readings,
    sensor_rows,
    state_space,
)
from structural_model.equations.matrices import (
    damped_modes,
    DampedModes,
    ModelModes,
    StructuralMatrices,
    undamped_modes,
)
from structural_model.equations.remainder import remainder
from structural_model.equations.response import (
    frequency_response,
    Hold,
    Kind,
    simulate,
    StateSpace,
    TimeResponse,
)
from structural_model.equations.scan import random_poses, scan, WorkspaceScan
from structural_model.equations.sensing import rigid_readings
from structural_model.equations.trajectory import follow

__all__ = [
    'DampedModes',
    'Dynamics',
    'Hold',
    'Kind',
    'ModelModes',
    'StateSpace',
    'StructuralMatrices',
    'TimeResponse',
    'WorkspaceScan',
    'damped_modes',
    'follow',
    'frequency_response',
    'gravity_rows',
    'random_poses',
    'reading_rows',
    'remainder',
    'rest_readings',
    'rigid_readings',
    'scan',
    'sensor_rows',
    'simulate',
    'state_space',
    'undamped_modes',
]
