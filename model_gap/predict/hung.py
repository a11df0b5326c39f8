"""What the sensors read otherwise when something hangs at a point of a link.

It acts by its force there alone, so that the arm's own response at that point gives the change
exactly, with no arm built and solved anew: hundreds of points cost as much as one simulation.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modal_core.channel import AXES, Channel
from model_gap.campaign import Complex, hann
from model_gap.cell import CellModel, PoseSystem
from model_gap.predict.predict import Predictor
from structural_model import FlexibleJointModel
from structural_model.equations import reading_rows

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Motion:
    """How a link moves in one record, and what forces on it do: six ways, or a point's three.

    Parameters
    ----------
    own : (n_bins, n) complex array
        Its acceleration.
    per_force : (n_bins, n, n) complex array
        Its acceleration per force on it.
    readings : (n_bins, n_channels, n) complex array
        What the sensors read per force on it.
    """

    own: Complex
    per_force: Complex
    readings: Complex

    def through(self, way: Array) -> 'Motion':
        """Return the motion of what moves as (m, n) of these ways."""
        return Motion(self.own @ way.T, way @ self.per_force @ way.T, self.readings @ way.T)


def link_motions(cell: CellModel, predictor: Predictor, link: str) -> list[Motion]:
    """Return how the origin of a link moves along its axes and turns about them, per record."""
    solved, model = predictor.solved(cell), predictor.arm(cell.spec)
    rows = [
        _rows(model, pose, link, system.arm.rest)
        for pose, system in zip(predictor.poses, solved.systems, strict=True)
    ]
    found = []
    for item, state, group in zip(predictor.records, solved.states, predictor.groups, strict=True):
        system, own = solved.systems[group], rows[group]
        flexible, rigid = own[:, : model.n_dof], own[:, model.n_dof :]
        moved = flexible @ (-(state.omega**2) * state.deflection) + rigid @ state.acceleration
        per_force, readings = _answers(system, item.omega[:, 1], flexible)
        found.append(Motion(hann(moved.reshape(len(own), -1, 3)).T, per_force, readings))
    return found


def _rows(model: FlexibleJointModel, pose: Array, link: str, rest: Array) -> Array:
    """Return how all coordinates move a link, (6, n_dof + n_joints), as sensors would tell."""
    places = ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
    channels = [
        Channel(f'{number}.{axis}', link, direction, place)
        for number, place in enumerate(places)
        for axis, direction in AXES.items()
    ]
    motion, _ = reading_rows(model.dynamics, pose, channels, rest)
    here, beyond_x, beyond_y = motion.reshape(3, 3, -1)
    turning = [beyond_y[2] - here[2], here[2] - beyond_x[2], beyond_x[1] - here[1]]
    return np.vstack([here, turning])


def _answers(system: PoseSystem, omega: Array, flexible: Array) -> tuple[Complex, Complex]:
    """Return acceleration of a link and readings per force on each of its ways."""
    moved, read = [], []
    for row in flexible:
        force = np.repeat(row[:, None], len(omega), axis=1).astype(complex)
        deflection = system.deflection(omega, force)
        acceleration = -(omega**2) * deflection
        moved.append(flexible @ acceleration)
        read.append(system.flexible @ acceleration + system.gravity @ deflection)
    return np.transpose(moved, (2, 1, 0)), np.transpose(read, (2, 1, 0))


def at_point(point: tuple[float, float, float]) -> Array:
    """Return how a point of a link moves with it, (3, 6)."""
    x, y, z = point
    arm = np.array([[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]])
    return np.hstack([np.eye(3), arm])


def hung(
    motion: Motion, omega: Array, mass: float, along: Array, frequencies: Array, damping: float
) -> Complex:
    """Return the change of the readings, (n_frequencies, n_channels, n_bins).

    Parameters
    ----------
    motion : Motion
        Of the point it hangs at.
    omega : (n_bins,) array [rad/s]
        Where.
    mass : float [kg]
        Of what hangs there.
    along : (3,) array
        Unit vector it swings along; across it moves with the link.
    frequencies : (n_frequencies,) array [Hz]
        It swings at, each alone.
    damping : float
        Damping ratio.
    """
    own = 2.0 * np.pi * frequencies[:, None]
    spring = own**2 + 2j * damping * own * omega
    follows = spring / (spring - omega**2) - 1.0
    weight = mass * (np.eye(3) + follows[..., None, None] * np.outer(along, along))
    pull = (weight @ motion.own[:, :, None])[..., 0]
    force = -np.linalg.solve(np.eye(3) + weight @ motion.per_force, pull[..., None])
    return np.asarray((motion.readings @ force)[..., 0].transpose(0, 2, 1))
