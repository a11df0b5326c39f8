"""Substructures joined by what their receptances say, rotations included.

Y = Y₀ − Y₀ Bᵀ (B Y₀ Bᵀ + Z⁻¹)⁻¹ B Y₀ with the receptances Y₀ of both side by side, the places B
that meet, and the stiffness Z of the joint between them; a rigid joint has Z⁻¹ = 0.

References
----------
De Klerk, Rixen and Voormeeren (2008), doi:10.2514/1.33274, equation 26.
"""

import numpy as np
from numpy.typing import NDArray

from machining.joining.beam import N_TIP
from modal_core.errors import SettingsError

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]


def joined_tip(tool: Complex, machine: Complex, joint: Complex | None = None) -> Complex:
    """Return the receptance of the tip of a tool in a machine, (n_lines, 5, 5).

    Parameters
    ----------
    tool : (n_lines, 10, 10) array
        Of the free tool, tip first (``tool_receptance``).
    machine : (n_lines, 5, 5) array
        Of the holder where the tool ends: x, slope along x, y, slope along y, z, slopes along the
        axis from the tip to the holder.
    joint : (n_lines, 5, 5) array or None
        Compliance of the joint; None: rigid.

    Returns
    -------
    array
        The same coordinates at the tip; x, y and z are rows and columns 0, 2 and 4.
    """
    if machine.shape != (len(tool), N_TIP, N_TIP) or tool.shape[1:] != (2 * N_TIP, 2 * N_TIP):
        raise SettingsError(
            'tool and machine do not fit', found=machine.shape, expected='(n_lines, 5, 5)'
        )
    tip, end = slice(None, N_TIP), slice(N_TIP, None)
    between = tool[:, end, end] + machine + (0.0 if joint is None else joint)
    pushed = np.linalg.solve(between, tool[:, end, tip])
    return np.asarray(tool[:, tip, tip] - tool[:, tip, end] @ pushed)


def with_joint(frequency_hz: Real, stiffness: Real, damping: Real) -> Complex:
    """Return the compliance of a joint, (n_lines, 5, 5).

    Parameters
    ----------
    frequency_hz : (n_lines,) array [Hz]
    stiffness : (5,) array [N/m], [N m/rad]
        Along x, slope along x, y, slope along y, z; inf is rigid.
    damping : (5,) array [N s/m], [N m s/rad]
    """
    rate = 2j * np.pi * np.asarray(frequency_hz, float)[:, None]
    with np.errstate(divide='ignore', invalid='ignore'):
        give = np.where(np.isinf(stiffness), 0.0, 1.0 / (stiffness + rate * damping))
    return np.asarray(give[:, :, None] * np.eye(N_TIP))


def with_rotations(near: Complex, cross: Complex, far: Complex, apart_m: float) -> Complex:
    """Return a 5 x 5 receptance out of those of two points along the axis.

    Slopes are differences over the distance: their noise goes with 1/distance, that of a slope
    over a moment with its square.

    Parameters
    ----------
    near, far : (n_lines, 3, 3) array [m/N]
        At the end of the holder, and further up the axis.
    cross : (n_lines, 3, 3) array [m/N]
        Displacement near over force far.
    apart_m : float [m]
        Distance of the points.
    """
    if not apart_m > 0.0:
        raise SettingsError('two points at one place tell no rotation', found=apart_m)
    whole = np.block([[near, cross], [cross.transpose(0, 2, 1), far]])
    # Displacements of both points: x, y, z near, then far; slopes count from near to far.
    out = np.zeros((N_TIP, 6))
    out[[0, 2, 4], [0, 1, 2]] = 1.0
    for row, axis in ((1, 0), (3, 1)):
        out[row, axis], out[row, 3 + axis] = -1.0 / apart_m, 1.0 / apart_m
    return np.asarray(out @ whole @ out.T)
