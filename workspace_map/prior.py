"""What arms of a kind may have that their models lack: parts of the unknown and their scales."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from workspace_map.arm import Arm, PAYLOAD_NUMBERS, Slopes, State
from workspace_map.regression import Scales

Array = NDArray[np.float64]
PARTS = ('springs of joints', 'springs under the base', 'couplings', 'payload', 'links')
TOOLS_OWN = (PARTS.index('payload'),)
"""What goes with a tool when it is taken off."""
FREQUENCY, SHAPE = 0, 1
"""Kinds of rows."""
SPREAD = 1.0
"""Standard deviation of the logarithm of every scale: e times more or less is no surprise."""
PART_OF_TOLERANCES = 0.2
"""Of what the springs of arms in general depart by, between two of one make: 4 % of a spring."""


def structure_scales(n_joints: int) -> Scales:
    """Return the median scales of springs, couplings and masses, before anything is measured.

    Gear stiffness of data sheets and of fitted models is known to a fifth, floors to a factor of
    two, masses of links to a few percent; a payload of some kilograms is forgotten easily.
    """
    return Scales(
        constant=np.array([0.2, 0.7, 0.03, 0.3, 0.03]),
        varying=np.array([0.05, 0.0, 0.02, 0.0, 0.0]),
        white=np.array([0.002, 0.02]),
        length=np.ones(n_joints),
    )


def damping_scales(n_joints: int) -> Scales:
    """Return the median scales of dampers: nobody knows damping to better than a half."""
    return Scales(
        constant=np.array([0.4, 0.4]),
        varying=np.array([0.1, 0.0]),
        white=np.array([0.03]),
        length=np.ones(n_joints),
    )


def of_same_make(structure: Scales, damping: Scales) -> tuple[Scales, Scales]:
    """Return the median scales of how one arm differs from another of the same make.

    Both lack the same of their model; what is left are tolerances of parts, and floor and tool,
    which are the site's and not the maker's.
    """
    part = PART_OF_TOLERANCES
    constant = structure.constant * np.array([part, 1.0, part, 1.0, part])
    return (
        replace(structure, constant=constant, varying=part * structure.varying),
        replace(damping, constant=2.0 * part * damping.constant, varying=part * damping.varying),
    )


def structure_parts(arm: Arm, slopes: Slopes) -> tuple[Array, ...]:
    """Return rows of derivatives, divided into `PARTS`."""
    base = arm.is_base
    return (
        slopes.spring[:, ~base],
        slopes.spring[:, base],
        slopes.coupling,
        slopes.mass[:, :PAYLOAD_NUMBERS],
        slopes.mass[:, PAYLOAD_NUMBERS:],
    )


def structure_of(arm: Arm, state: State) -> tuple[Array, ...]:
    """Return the members of `PARTS` that a state has."""
    masses = state.mass[:PAYLOAD_NUMBERS], state.mass[PAYLOAD_NUMBERS:]
    return (state.spring[~arm.is_base], state.spring[arm.is_base], state.coupling, *masses)


def damping_parts(arm: Arm, slopes: Array) -> tuple[Array, ...]:
    """Return rows of derivatives of log ζ: dampers of joints, dampers under the base."""
    return slopes[:, ~arm.is_base], slopes[:, arm.is_base]


def state_of(arm: Arm, structure: tuple[Array, ...], dampers: tuple[Array, ...]) -> State:
    """Return the state with these members."""
    joints, base, coupling, payload, links = structure
    return State(
        spring=_together(arm, joints, base),
        coupling=coupling,
        mass=np.concatenate([payload, links]),
        damper=_together(arm, *dampers),
    )


def _together(arm: Arm, joints: Array, base: Array) -> Array:
    found = np.zeros(arm.n_dof)
    found[~arm.is_base], found[arm.is_base] = joints, base
    return found
