"""The expanded arm, and where points of its links ride."""

from dataclasses import dataclass
from functools import cached_property
import threading
from typing import Any

import numpy as np
from numpy.typing import NDArray
import pinocchio as pin

from modal_core.errors import ModelError
from structural_model.assembly.stations import Divided

Matrix = NDArray[np.float64]


@dataclass(frozen=True)
class Assembly:
    """The expanded arm.

    Parameters
    ----------
    model : pinocchio.Model
        One coordinate per joint; nq = nv.
    dof_names : tuple of str
        Flexible degrees of freedom, in the order of M, C, K.
    flexible : (n_flexible,) int array
        Place of those before the motors in pinocchio's vectors.
    drives : (n_joints,) int array
        Place of the robot joints in pinocchio's vectors.
    motors : (n_motors,) int array
        Joints whose servo is not stiff; their motor deviations are the last rows of M, C, K.
    motor_inertia : (n_motors,) array [kg m²]
        Rotor inertia seen behind the gear.
    stiffness, damping : (n_dof, n_dof) array
        Of springs and dampers; pose-independent.
    links : dict
        Link of the URDF to its moving joint (0: base) and placement in that joint's frame.
    divided : dict
        Moving joint (0: base) to its bodies.
    """

    model: pin.Model
    dof_names: tuple[str, ...]
    flexible: NDArray[np.intp]
    drives: NDArray[np.intp]
    motors: NDArray[np.intp]
    motor_inertia: Matrix
    stiffness: Matrix
    damping: Matrix
    links: dict[str, tuple[int, pin.SE3]]
    divided: dict[int, Divided]

    @cached_property
    def sensor_maps(self) -> dict[Any, Any]:
        """Memory of ``sensing.sensor_map``."""
        return {}

    @cached_property
    def _local(self) -> threading.local:
        return threading.local()

    @property
    def data(self) -> pin.Data:
        """Work space of pinocchio's algorithms, one per thread."""
        if not hasattr(self._local, 'data'):
            self._local.data = self.model.createData()
        return self._local.data

    def link(self, name: str) -> tuple[int, pin.SE3]:
        """Return a link's moving joint (0: base) and its placement in that joint's frame.

        Raises
        ------
        ModelError
            No such link.
        """
        if name not in self.links:
            raise ModelError('unknown link', found=name, expected=', '.join(self.links))
        return self.links[name]

    def attach(self, link: str, position: Matrix) -> tuple[int, pin.SE3]:
        """Return the pinocchio joint a point of a link rides on and the link frame moved there.

        Raises
        ------
        ModelError
            No such link.
        """
        parent, placement = self.link(link)
        return self.divided[parent].attach(placement, position)
