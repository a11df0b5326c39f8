"""Receptances of a free tool of round segments: Timoshenko beams, stiff along the axis.

Deflection v, its slope by bending θ, moment M and shear V obey along the axis
v' = θ + V/κGA, θ' = M/EI, M' = −ρIω²θ − V, V' = −ρAω²v; a segment is the exponential of that.

References
----------
Timoshenko (1921), doi:10.1080/14786442108636264; shear coefficient of Cowper (1966),
doi:10.1115/1.3625046; receptance coupling of tools: Schmitz and Donaldson (2000),
doi:10.1016/S0007-8506(07)62950-3.
"""

from collections.abc import Sequence
from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm

from modal_core.errors import SettingsError

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]
N_TIP = 5
"""Coordinates of an end: x, slope along x, y, slope along y, z."""


@dataclass(frozen=True, slots=True)
class Material:
    """What a tool is made of; carbide unless said otherwise.

    Parameters
    ----------
    youngs_pa : float [Pa]
    density_kg_m3 : float [kg/m³]
    poisson : float
    loss_factor : float
        Structural damping: the imaginary share of Young's modulus.
    """

    youngs_pa: float = 580e9
    density_kg_m3: float = 14_400.0
    poisson: float = 0.22
    loss_factor: float = 0.003


@dataclass(frozen=True, slots=True)
class Segment:
    """A round part of a tool, from the tip to the holder.

    Parameters
    ----------
    length_m : float [m]
    diameter_m : float [m]
        Of a fluted part that of the round one as stiff, about 0.8 of the cutter's.
    bore_m : float [m]
        Inner diameter.
    """

    length_m: float
    diameter_m: float
    bore_m: float = 0.0

    def __post_init__(self) -> None:
        if not (0.0 < self.length_m < 10.0 and 0.0 <= self.bore_m < self.diameter_m < 10.0):
            raise SettingsError('no segment of a tool', found=self)

    @property
    def area_m2(self) -> float:
        """Cross section [m²]."""
        return 0.25 * math.pi * (self.diameter_m**2 - self.bore_m**2)

    @property
    def inertia_m4(self) -> float:
        """Second moment of area [m⁴]."""
        return math.pi / 64.0 * (self.diameter_m**4 - self.bore_m**4)


def tool_receptance(
    segments: Sequence[Segment], frequency_hz: Real, material: Material | None = None
) -> Complex:
    """Return displacements over forces at both ends of a free tool, (n_lines, 10, 10).

    Parameters
    ----------
    segments : sequence of Segment
        From the tip to the end at the holder.
    frequency_hz : (n_lines,) array [Hz]
        Above 0.
    material : Material or None

    Returns
    -------
    array [m/N], [1/N], [rad/(N m)]
        Tip first; of each end x, slope along x, y, slope along y, z.  Slopes are dx/ds and dy/ds
        along the axis from the tip to the holder.
    """
    made = material or Material()
    lines = np.asarray(frequency_hz, float)
    if not len(segments) or not (lines > 0.0).all():
        raise SettingsError('a tool needs segments, and frequencies above 0')
    both = np.array([_plane(segments, 2.0 * math.pi * line, made) for line in lines])
    found = np.zeros((len(lines), 2 * N_TIP, 2 * N_TIP), complex)
    for plane in (0, 2):
        rows = np.array([plane, plane + 1, N_TIP + plane, N_TIP + plane + 1])
        found[:, rows[:, None], rows] = both
    mass = sum(made.density_kg_m3 * each.area_m2 * each.length_m for each in segments)
    ends = np.array([N_TIP - 1, 2 * N_TIP - 1])
    found[:, ends[:, None], ends] = (-1.0 / (mass * (2.0 * math.pi * lines) ** 2))[:, None, None]
    return found


def _plane(segments: Sequence[Segment], omega: float, made: Material) -> Complex:
    """Return receptances in one plane, (4, 4): v and θ of the tip, then of the other end."""
    over = np.eye(4, dtype=complex)
    for each in segments:
        over = expm(_rate(each, omega, made) * each.length_m) @ over
    # Ends feel -M, -V at the tip and M, V at the other; loads below are forces before moments.
    order = [1, 0]
    moved, by_load = over[:2, :2], over[:2, 2:][:, order]
    load, on = over[2:, :2][order], over[2:, 2:][order][:, order]
    free = np.linalg.inv(load)
    tip = np.hstack([free @ on, free])
    return np.vstack([tip, moved @ tip - np.hstack([by_load, np.zeros((2, 2))])])


def _rate(segment: Segment, omega: float, made: Material) -> Complex:
    youngs = made.youngs_pa * (1.0 + 1j * made.loss_factor)
    shear = youngs / (2.0 * (1.0 + made.poisson))
    kappa = 6.0 * (1.0 + made.poisson) / (7.0 + 6.0 * made.poisson)
    area, inertia = segment.area_m2, segment.inertia_m4
    found = np.zeros((4, 4), complex)
    found[0, 1], found[0, 3] = 1.0, 1.0 / (kappa * shear * area)
    found[1, 2] = 1.0 / (youngs * inertia)
    found[2, 1], found[2, 3] = -made.density_kg_m3 * inertia * omega**2, -1.0
    found[3, 0] = -made.density_kg_m3 * area * omega**2
    return found
