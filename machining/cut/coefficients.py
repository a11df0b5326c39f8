"""What a material asks of the edges: force per area of chip and per length of edge."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modal_core.errors import SettingsError

Real = NDArray[np.float64]
LARGEST_PA = 1e12


@dataclass(frozen=True, slots=True)
class Coefficients:
    """Cutting and edge coefficients of the mechanistic force.

    Parameters
    ----------
    tangential_pa, radial_pa, axial_pa : float [N/m²]
        Force per area of chip against the turn, away from the work, along the axis to the work.
    tangential_edge_n_m, radial_edge_n_m, axial_edge_n_m : float [N/m]
        Force per length of edge in the cut.
    relative_std : float
        Standard deviation of the three cutting coefficients relative to their size, one for all,
        as they share material and edge; 0: exactly known.

    References
    ----------
    Budak, Altintas and Armarego (1996), doi:10.1115/1.2831014.
    """

    tangential_pa: float
    radial_pa: float
    axial_pa: float = 0.0
    tangential_edge_n_m: float = 0.0
    radial_edge_n_m: float = 0.0
    axial_edge_n_m: float = 0.0
    relative_std: float = 0.0

    def __post_init__(self) -> None:
        if not 0.0 < self.tangential_pa <= LARGEST_PA:
            raise SettingsError(
                'tangential cutting coefficient out of range [Pa]',
                found=self.tangential_pa,
                expected=f'above 0, up to {LARGEST_PA:g}',
            )
        if not (np.abs([*self.cutting_pa, *self.edge_n_m]) <= LARGEST_PA).all():
            raise SettingsError('cutting coefficients out of range', found=self.cutting_pa)
        if not 0.0 <= self.relative_std < 1.0:
            raise SettingsError(
                'relative σ of the cutting coefficients out of range',
                found=self.relative_std,
                expected='0 to below 1',
            )

    @property
    def cutting_pa(self) -> tuple[float, float, float]:
        """Tangential, radial, axial [N/m²]."""
        return self.tangential_pa, self.radial_pa, self.axial_pa

    @property
    def edge_n_m(self) -> tuple[float, float, float]:
        """Tangential, radial, axial [N/m]."""
        return self.tangential_edge_n_m, self.radial_edge_n_m, self.axial_edge_n_m
