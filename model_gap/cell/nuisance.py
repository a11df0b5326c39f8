"""What is known only to a percent or so: a tolerance that must not be given a name.

Every tolerance is a standard normal number; the prior is its own standard deviation.
"""

from collections.abc import Callable
import dataclasses
from dataclasses import dataclass

import numpy as np

from model_gap.cell.cell_model import CellModel

RELATIVE = '1'


@dataclass(frozen=True)
class Nuisance:
    """One tolerance.

    Parameters
    ----------
    name : str
        What it is, for the report.
    kind : str
        ``spring``, ``spec`` (masses), ``sensor`` (place and axes), ``pose`` (encoders) or
        ``gain``: how far its influence reaches.
    change : callable
        (cell, amount) -> cell; the amount in its unit, relative ones as a logarithm.
    sigma : float
        One standard deviation of the amount.
    unit : str
        ``m``, ``rad`` or, for relative ones, ``1``.
    what : str
        ``stiffness`` or ``damping`` of a joint's drive, ``encoder`` of a joint, ``base``, ``mass``
        of a link (or where it is), ``rotation`` or ``position`` of a sensor, or nothing: what an
        effect may stand for.
    joint, link, sensor : str
        The joint whose drive it is of, the link whose mass, the sensor, or nothing.
    """

    name: str
    kind: str
    change: Callable[[CellModel, float], CellModel]
    sigma: float
    unit: str = RELATIVE
    what: str = ''
    joint: str = ''
    link: str = ''
    sensor: str = ''

    def apply(self, cell: CellModel, deviations: float) -> CellModel:
        """Return a cell so many standard deviations from the given one."""
        return self.change(cell, self.sigma * deviations)

    def sized(self, stated: float) -> 'Nuisance':
        """Return it with another standard deviation: relative, in metres, or in degrees."""
        angle = self.unit == 'rad'
        return dataclasses.replace(self, sigma=float(np.deg2rad(stated)) if angle else stated)

    def stated(self, sigma: float) -> float:
        """Return a standard deviation of its amount as one states it."""
        return float(np.rad2deg(sigma)) if self.unit == 'rad' else sigma
