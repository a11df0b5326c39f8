"""Matrices of the model at a pose, and in which directions the arm may depart from them."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from modal_core.channel import AXES, Channel
from modal_core.errors import MapError
from modal_core.units import ACCELERATION, ANGULAR_VELOCITY
from structural_model.description import LinkSpec

if TYPE_CHECKING:
    from structural_model import FlexibleJointModel

Array = NDArray[np.float64]
NEGLIGIBLE = 1e-15
"""Of the stiffest spring, that one without stiffness gets: what rounding makes of it anyhow."""
# A payload's ten numbers in units of a 20 kg tool, 0.15 m off and of 0.2 m radius of gyration.
PAYLOAD_UNITS = np.array([20.0] + 3 * [3.0] + 6 * [0.8])
PAYLOAD_NUMBERS = len(PAYLOAD_UNITS)


@dataclass(frozen=True, slots=True)
class ToolPoint:
    """Where the tool is: shapes, FRFs and payloads are there.

    Parameters
    ----------
    link : str
        Link of the robot.
    position_m : (3,) tuple [m]
        In its frame, whose axes are those of the tool.
    """

    link: str
    position_m: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def channels(self) -> tuple[Channel, ...]:
        """Return x, y, z of the point, then rotations about them."""
        return tuple(
            Channel(f'tool.{kind}{name}', self.link, axis, self.position_m, unit)
            for kind, unit in (('', ACCELERATION), ('r', ANGULAR_VELOCITY))
            for name, axis in AXES.items()
        )


@dataclass(frozen=True)
class ArmAtPose:
    """The model at one pose.

    Parameters
    ----------
    q : (n_joints,) array [rad]
        Serial joint angles.
    mass : (n_dof, n_dof) array
        Mass matrix.
    mass_changes : (n_masses, n_dof, n_dof) array
        Change of it per payload number (mass, moments, inertia; `PAYLOAD_UNITS`) and per relative
        change of a link's mass.
    springs, dampers : (n_dof, n_dof) array
        Stiffness and damping of what may depart.
    other_stiffness : (n_dof, n_dof) array
        Gravity and compensators.
    mass_damping_1_s : float [1/s]
        Damping in proportion to mass.
    channels : (n_channels, n_dof) array
        Motion of the sensors per deflection.
    tool : (6, n_dof) array
        Motion of the tool point: three displacements, three rotations.
    """

    q: Array
    mass: Array
    mass_changes: Array
    springs: Array
    dampers: Array
    other_stiffness: Array
    mass_damping_1_s: float
    channels: Array
    tool: Array

    @cached_property
    def spring_root(self) -> Array:
        """W with springs = WᵀW, a row per spring; see `roots`."""
        return roots(self.springs)

    @cached_property
    def damper_root(self) -> Array:
        """The same of the dampers."""
        return roots(self.dampers)


def roots(matrix: Array) -> Array:
    """Return the lower triangular W with WᵀW = matrix.

    Drives act on controller axes, which serial joints before them turn too: T of `AxisMap` is
    lower triangular, so that row d of W is the drive's own, sqrt(k_d) times row d of T.
    """
    floor = NEGLIGIBLE * float(np.max(np.diag(matrix), initial=0.0))
    whole = matrix + floor * np.eye(len(matrix))
    return np.asarray(np.linalg.cholesky(whole[::-1, ::-1])[::-1, ::-1].T)


@dataclass(frozen=True)
class Arm:
    """A robot with its sensors and tool.

    Parameters
    ----------
    model : FlexibleJointModel
        The robot.
    channels : tuple of Channel
        What is measured.
    tool : ToolPoint
        Where the tool is.
    """

    model: 'FlexibleJointModel'
    channels: tuple[Channel, ...]
    tool: ToolPoint

    def __post_init__(self) -> None:
        """Refuse a rigid arm."""
        if not self.n_dof:
            raise MapError(
                'the model has no springs, and so no modes', where=self.model.robot_name,
                advice='say how stiff its drives are, in model.yaml',
            )  # fmt: skip

    @property
    def n_dof(self) -> int:
        """Flexible degrees of freedom."""
        return self.model.n_dof

    @property
    def n_masses(self) -> int:
        """Numbers that masses may depart by."""
        return len(PAYLOAD_UNITS) + len(self.heavier)

    @cached_property
    def is_base(self) -> NDArray[np.bool_]:
        """Which degrees of freedom are springs under the base, (n_dof,)."""
        names = self.model.matrices(np.zeros(self.model.n_joints)).dof_names
        return np.array([name.startswith('base/') for name in names])

    @cached_property
    def heavier(self) -> 'tuple[FlexibleJointModel, ...]':
        """The robot with each of its moving links twice as heavy; links without mass are none."""
        spec, found = self.model.spec, []
        here = np.zeros(self.model.n_joints)
        nominal = self.model.mass_matrix(here)
        for name in self.model.body_links:
            known = next((link for link in spec.links if link.name == name), LinkSpec(name))
            others = tuple(link for link in spec.links if link.name != name)
            twice = replace(known, mass_factor=2.0 * known.mass_factor)
            model = self.model.replace(replace(spec, links=(*others, twice)))
            if np.abs(model.mass_matrix(here) - nominal).max() > 0.0:
                found.append(model)
        return tuple(found)

    def same_tool(self, other: 'Arm') -> bool:
        """Tell whether another arm has this tool point and these masses fixed to its links."""
        masses, others = self.model.spec.masses, other.model.spec.masses
        return self.tool == other.tool and sorted(map(repr, masses)) == sorted(map(repr, others))

    def at(self, q: ArrayLike) -> ArmAtPose:
        """Return the model at a pose, (n_joints,) serial angles [rad].

        Raises
        ------
        ModelError
            Not a pose.
        """
        angles = np.asarray(q, dtype=float)
        matrices = self.model.matrices(angles)
        rows = self.model.sensor_jacobian(angles, (*self.tool.channels(), *self.channels))
        tool, channels = np.split(rows, [len(AXES) * 2])
        links = [model.mass_matrix(angles) - matrices.M for model in self.heavier]
        payload = tool.T @ PAYLOAD_FORMS @ tool
        assembly, damping = self.model.assembly, self.model.spec.damping
        return ArmAtPose(
            q=angles,
            mass=matrices.M,
            mass_changes=np.concatenate([payload, np.array(links).reshape(-1, *matrices.M.shape)]),
            springs=assembly.stiffness,
            dampers=assembly.damping + damping.stiffness_proportional_s * assembly.stiffness,
            other_stiffness=matrices.K - assembly.stiffness,
            mass_damping_1_s=damping.mass_proportional_1_s,
            channels=channels,
            tool=tool,
        )


def _payload_forms() -> Array:
    """Return twice the kinetic energy of a body per its ten numbers, (10, 6, 6) in (v, w).

    2 T = m v·v + 2 h·(v x w) + w·I w with the first moment h and the inertia I about the point.
    """
    forms = np.zeros((10, 6, 6))
    forms[0, :3, :3] = np.eye(3)
    for axis in range(3):
        a, b = (axis + 1) % 3, (axis + 2) % 3
        forms[1 + axis, a, 3 + b] = forms[1 + axis, 3 + b, a] = 1.0
        forms[1 + axis, b, 3 + a] = forms[1 + axis, 3 + a, b] = -1.0
        forms[4 + axis, 3 + axis, 3 + axis] = 1.0
        forms[7 + axis, 3 + a, 3 + b] = forms[7 + axis, 3 + b, 3 + a] = 1.0
    return np.asarray(forms * PAYLOAD_UNITS[:, None, None])


PAYLOAD_FORMS = _payload_forms()
