"""Identified modes."""

from collections.abc import Iterator
from dataclasses import dataclass, Field, fields
import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

SCATTERED_MPD_RAD = math.radians(10.0)
"""Mean phase deviation above which a mode calls for a second look; its collinearity is then
below about 0.9."""
MODE_ORDER = (
    'id',
    'frequency_hz',
    'frequency_std_hz',
    'damping_ratio',
    'damping_ratio_std',
    'shape',
    'shape_std',
    'mac_loss',
    'mac_loss_std',
    'mpc',
    'mpd',
    'harmonic',
)
"""Order of fields in files; a new field needs no entry and stands at the end."""
COMPLEX = ('shape', 'shape_std')


@dataclass(frozen=True, slots=True)
class Mode:
    """One mode of vibration with its standard deviations.

    Parameters
    ----------
    frequency_hz : float [Hz]
        Undamped natural frequency.
    damping_ratio : float
        Fraction of critical damping.
    shape : (n_channels,) complex array
        Mode shape, largest entry 1 + 0i; NaN at points that no set-up with this mode has.
    frequency_std_hz, damping_ratio_std : float [Hz], [-]
        NaN when not estimated.
    mpc : float
        Modal phase collinearity, 0..1.
    mpd : float [rad]
        Mean phase deviation.
    harmonic : bool
        A line of a machine or drive, not a mode of the structure.
    id : int
        Stays the same over windows; 0 before tracking.
    shape_std : (n_channels,) complex array or None
        Standard deviations of the real parts + i · those of the imaginary parts of ``shape``, 0 at
        its largest entry; None when not estimated.
    mac_loss, mac_loss_std : float
        Mean and standard deviation of what chance takes from the MAC of ``shape`` with the true
        one; NaN when not estimated.
    """

    frequency_hz: float
    damping_ratio: float
    shape: NDArray[np.complex128]
    frequency_std_hz: float = math.nan
    damping_ratio_std: float = math.nan
    mpc: float = math.nan
    mpd: float = math.nan
    harmonic: bool = False
    id: int = 0
    shape_std: NDArray[np.complex128] | None = None
    mac_loss: float = math.nan
    mac_loss_std: float = math.nan

    def values(self) -> dict[str, Any]:
        """Return the fields as files and messages name them, complex ones in two parts.

        In the order of :data:`MODE_ORDER`, fields that are not in it at the end.
        """
        found: dict[str, Any] = {}
        for item in sorted(fields(self), key=_place):
            value = getattr(self, item.name)
            if item.name in COMPLEX:
                found[f'{item.name}_real'] = None if value is None else np.real(value)
                found[f'{item.name}_imag'] = None if value is None else np.imag(value)
            else:
                found[item.name] = value
        return found

    @property
    def phases_scatter(self) -> bool:
        """Whether the points of the shape move neither in nor against phase."""
        return self.mpd > SCATTERED_MPD_RAD


def _place(item: Field[Any]) -> int:
    return MODE_ORDER.index(item.name) if item.name in MODE_ORDER else len(MODE_ORDER)


MODE_KEYS = tuple(Mode(math.nan, math.nan, np.empty(0, dtype=complex)).values())
"""What :meth:`Mode.values` names."""


@dataclass(frozen=True, slots=True)
class ModeSet:
    """The modes of one window or one recording, by frequency.

    Parameters
    ----------
    modes : tuple of Mode
        Sorted by natural frequency.
    channel_names : tuple of str
        Entries of the mode shapes.
    method : str
        How they were identified, for example ``ssi_cov``.
    """

    modes: tuple[Mode, ...]
    channel_names: tuple[str, ...]
    method: str = 'ssi_cov'

    def __iter__(self) -> Iterator[Mode]:
        """Iterate by frequency."""
        return iter(self.modes)

    def __len__(self) -> int:
        """Return the number of modes."""
        return len(self.modes)

    @property
    def frequency_hz(self) -> NDArray[np.float64]:
        """Natural frequencies [Hz]."""
        return np.array([mode.frequency_hz for mode in self.modes])

    @property
    def damping_ratio(self) -> NDArray[np.float64]:
        """Damping ratios."""
        return np.array([mode.damping_ratio for mode in self.modes])

    @property
    def shapes(self) -> NDArray[np.complex128]:
        """Mode shapes as columns, (n_channels, n_modes)."""
        if not self.modes:
            return np.empty((len(self.channel_names), 0), dtype=complex)
        return np.column_stack([mode.shape for mode in self.modes])
