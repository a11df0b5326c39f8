"""Which body of a divided link carries a point."""

from bisect import bisect_right
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
import pinocchio as pin

Matrix = NDArray[np.float64]


@dataclass(frozen=True)
class Station:
    """A body that carries part of a link.

    Parameters
    ----------
    joint : int
        Pinocchio joint of the body.
    offset : (3,) array [m]
        Origin of the body in the link frame (the axes are the same).
    """

    joint: int
    offset: Matrix


@dataclass(frozen=True)
class Divided:
    """A link's bodies in order, and the rule which of them carries a point.

    Parameters
    ----------
    stations : tuple of Station
        From the inboard to the outboard body.
    start, direction : (3,) array
        Line along which the link is divided.
    borders : tuple of float [m]
        Distance along the line at which the next station begins.
    """

    stations: tuple[Station, ...]
    start: Matrix
    direction: Matrix
    borders: tuple[float, ...] = ()

    def station(self, position: Matrix) -> Station:
        """Return the body a point of the link rides on, the outboard one at a border."""
        along = float((position - self.start) @ self.direction)
        return self.stations[bisect_right(self.borders, along + 1e-9)]

    def attach(self, placement: pin.SE3, position: Matrix) -> tuple[int, pin.SE3]:
        """Return the joint that a point of a frame rides on, and the frame moved there.

        Parameters
        ----------
        placement : pinocchio.SE3
            Of the frame in that of the link.
        position : (3,) array [m]
            In the frame.
        """
        point = np.asarray(placement.act(position))
        station = self.station(point)
        return station.joint, pin.SE3(placement.rotation, point - station.offset)
