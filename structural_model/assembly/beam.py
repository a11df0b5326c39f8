"""Euler-Bernoulli beams in coordinates of one end relative to the other."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from structural_model.description import BeamSpec


def relative_stiffness(beam: BeamSpec, length_m: float) -> NDArray[np.float64]:
    """Return the stiffness of one segment's outer end relative to its inner end.

    Parameters
    ----------
    beam : BeamSpec
        Section stiffnesses.
    length_m : float [m]
        Length of the segment.

    Returns
    -------
    (6, 6) array
        Displacements along the two axes across and along the beam, then turns about them.  Turn
        about the second axis b = e × a bends towards +a, turn about the first towards -b (e along
        the beam, a and b across).  Infinite diagonal: no such degree of freedom.

    References
    ----------
    Przemieniecki (1968), Theory of Matrix Structural Analysis, Section 5.6: the cantilever block
    [12, 6; 6, 4] EI/L³ of the beam element.
    """
    stiffness = np.zeros((6, 6))
    about_first, about_second = beam.bending_n_m2
    # Towards a: bending about b.  Turning about b by θ moves e towards a, so u' = +θ.
    _bending(stiffness, about_second, length_m, shift=0, turn=4, sign=1.0)
    _bending(stiffness, about_first, length_m, shift=1, turn=3, sign=-1.0)
    stiffness[2, 2] = beam.axial_n / length_m
    stiffness[5, 5] = beam.torsion_n_m2 / length_m
    return stiffness


def _bending(
    matrix: NDArray[np.float64], ei: float, length: float, shift: int, turn: int, sign: float
) -> None:
    matrix[shift, shift] = 12.0 * ei / length**3
    matrix[turn, turn] = 4.0 * ei / length
    if np.isfinite(ei):
        matrix[shift, turn] = matrix[turn, shift] = -6.0 * ei / length**2 * sign


@dataclass(frozen=True, slots=True)
class Slice:
    """The part of a beam that rides rigidly on one node.

    Parameters
    ----------
    mass_kg : float [kg]
        Its mass.
    centre_m : float [m]
        Its centre from the inner end of the beam.
    length_m : float [m]
        Its length.
    """

    mass_kg: float
    centre_m: float
    length_m: float


def slices(mass_kg: float, length_m: float, segments: int) -> tuple[Slice, ...]:
    """Cut a uniform beam half way between its nodes, one slice a node.

    The slices together are the rigid beam, so that lumping changes no rigid-body inertia.

    Parameters
    ----------
    mass_kg, length_m : float [kg], [m]
        Of the whole beam.
    segments : int
        One less than nodes.
    """
    step = length_m / segments
    nodes = np.arange(segments + 1) * step
    starts = np.maximum(nodes - step / 2.0, 0.0)
    ends = np.minimum(nodes + step / 2.0, length_m)
    return tuple(
        Slice(mass_kg * (end - start) / length_m, (start + end) / 2.0, end - start)
        for start, end in zip(starts, ends, strict=True)
    )


def rod_inertia(
    mass_kg: float, length_m: float, gyration_m: float, along: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the inertia of a uniform rod about its centre.

    Parameters
    ----------
    mass_kg, length_m : float [kg], [m]
        Of the rod.
    gyration_m : float [m]
        Radius of gyration about its own axis.
    along : (3,) array
        Unit vector along it.

    Returns
    -------
    (3, 3) array [kg m²]
    """
    axial = np.outer(along, along)
    across = mass_kg * (length_m**2 / 12.0 + gyration_m**2 / 2.0)
    return np.asarray(mass_kg * gyration_m**2 * axial + across * (np.eye(3) - axial))
