"""The arm as points and lines, and where a mode moves them."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True)
class Geometry:
    """A wireframe at rest.

    Parameters
    ----------
    points_m : (n_points, 3) array [m]
        Places in the base frame, z upwards.
    lines : tuple of tuple of int
        Polylines through points, for example base, elbow, wrist, flange.
    sensors : tuple of int
        Points that carry a sensor.
    fixed : tuple of int
        Points that do not move.
    numbers : tuple of int
        Of the points, where a file numbers them; empty: from 1.
    """

    points_m: NDArray[np.float64]
    lines: tuple[tuple[int, ...], ...]
    sensors: tuple[int, ...] = ()
    fixed: tuple[int, ...] = (0,)
    numbers: tuple[int, ...] = ()


def sensor_displacements(
    geometry: Geometry,
    shape: NDArray[np.complex128],
    directions: NDArray[np.float64],
    points: Sequence[int],
) -> NDArray[np.complex128]:
    """Return how a mode moves every point, known at the sensors and interpolated between them.

    Parameters
    ----------
    geometry : Geometry
        The wireframe.
    shape : (n_channels,) complex array
        Mode shape.
    directions : (n_channels, 3) array
        Unit vector of each channel in the base frame.
    points : sequence of int
        Point each channel sits at.

    Returns
    -------
    (n_points, 3) complex array
        Displacements; a direction no channel measures stays zero.
    """
    moved = np.full((len(geometry.points_m), 3), np.nan, dtype=complex)
    at = np.asarray(points, dtype=int)
    for point in np.unique(at):
        rows = at == point
        # Smallest motion that agrees with all axes of the sensors at this point.
        moved[point] = np.linalg.pinv(directions[rows]) @ shape[rows]
    return interpolate_displacements(geometry, moved)


def interpolate_displacements(
    geometry: Geometry, displacement: NDArray[np.complex128]
) -> NDArray[np.complex128]:
    """Fill the rows that are NaN from their neighbours along the lines.

    Parameters
    ----------
    geometry : Geometry
        The wireframe.
    displacement : (n_points, 3) complex array
        NaN rows where the motion is not known.

    Returns
    -------
    (n_points, 3) complex array
        Linear in arc length between known points; beyond the last known one, as that one.
    """
    filled = np.array(displacement, dtype=complex)
    filled[list(geometry.fixed)] = 0.0
    for line in geometry.lines:
        points = np.asarray(line, dtype=int)
        steps = np.linalg.norm(np.diff(geometry.points_m[points], axis=0), axis=1)
        place = np.concatenate(([0.0], np.cumsum(steps)))
        known = np.isfinite(filled[points]).all(axis=1)
        if not known.any():
            continue
        for axis in range(3):
            values = filled[points[known], axis]
            at_unknown = place[~known]
            filled[points[~known], axis] = np.interp(at_unknown, place[known], values)
    filled[~np.isfinite(filled)] = 0.0
    return filled
