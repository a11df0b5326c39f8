"""Identified modes."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modal_core.settings.quantity import quantities_of, Quantity, quantity

SCATTERED_MPD_RAD = math.radians(10.0)
"""Mean phase deviation above which a mode calls for a second look; its collinearity is then
below about 0.9."""
LOWEST_HZ, HIGHEST_HZ = 1e-6, 1e7
ROUNDING = 1e-9
LARGEST_ID = 2**32 - 1


@dataclass(frozen=True, slots=True)
class Mode:
    """One mode of vibration with its standard deviations; a new field stands here alone.

    Files, tables, the reading of both and the documents follow; a message has it when
    oma_msgs/Mode names it.  Shapes are (n_channels,) complex arrays.  What was not estimated is
    NaN, or None.
    """

    frequency_hz: float = quantity('undamped natural frequency', 'Hz', LOWEST_HZ, HIGHEST_HZ)
    damping_ratio: float = quantity('fraction of critical damping', '', 0.0, 1.0)
    shape: NDArray[np.complex128] = quantity(
        'mode shape, largest entry 1 + 0i; NaN at points that no set-up with this mode has'
    )
    frequency_std_hz: float = quantity(
        'standard deviation of the natural frequency', 'Hz', 0.0, default=math.nan
    )
    damping_ratio_std: float = quantity(
        'standard deviation of the damping ratio', '', 0.0, default=math.nan
    )
    mpc: float = quantity(
        'modal phase collinearity; 1: a real mode', '', 0.0, 1.0 + ROUNDING, default=math.nan
    )
    mpd: float = quantity(
        'mean phase deviation; 0: a real mode', 'rad', 0.0, math.pi, default=math.nan
    )
    harmonic: bool = quantity(
        'a line of a machine or drive, not a mode of the structure', default=False
    )
    id: int = quantity(
        'stays the same over windows; 0 before tracking', '', 0, LARGEST_ID, default=0
    )
    shape_std: NDArray[np.complex128] | None = quantity(
        'standard deviations of the real parts + i · those of the imaginary parts of the shape, 0'
        ' at its largest entry',
        '',
        0.0,
        default=None,
    )
    mac_loss: float = quantity(
        'mean of what chance takes from the MAC of the shape with the true one',
        '',
        0.0,
        default=math.nan,
        single=False,
    )
    mac_loss_std: float = quantity(
        'standard deviation of that loss', '', 0.0, default=math.nan, single=False
    )
    known_motion: bool = quantity(
        'estimated with the known motion of the joints, not from the responses alone',
        default=False,
    )

    @property
    def untold(self) -> 'Mode':
        """The mode without standard deviations."""
        return replace(
            self,
            frequency_std_hz=math.nan,
            damping_ratio_std=math.nan,
            shape_std=None,
            mac_loss=math.nan,
            mac_loss_std=math.nan,
        )

    def values(self) -> dict[str, Any]:
        """Return the fields as files and messages name them, complex ones in two parts.

        In the order of :data:`MODE_ORDER`, fields that are not in it at the end.
        """
        found: dict[str, Any] = {}
        for item in _fields_of(type(self)):
            found |= item.write(getattr(self, item.name))
        return found

    @classmethod
    def from_values(cls, values: Mapping[str, Any], n_channels: int) -> 'Mode':
        """Return a mode from its values in a file or a message; what is not there is not known.

        Raises
        ------
        ValueError, TypeError, OverflowError
            Nothing that an identification can find.
        """
        return cls(**{item.name: item.read(values, n_channels) for item in _fields_of(cls)})

    @property
    def phases_scatter(self) -> bool:
        """Whether the points of the shape move neither in nor against phase."""
        return self.mpd > SCATTERED_MPD_RAD


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


def _in_order(kind: type[Mode]) -> tuple[Quantity, ...]:
    found = quantities_of(kind)
    return tuple(sorted(found, key=lambda item: (*MODE_ORDER, item.name).index(item.name)))


def _fields_of(kind: type[Mode]) -> tuple[Quantity, ...]:
    return MODE_FIELDS if kind is Mode else _in_order(kind)


MODE_FIELDS = _in_order(Mode)
"""The fields of a mode in the order of files."""
MODE_KEYS = tuple(key for item in MODE_FIELDS for key in item.keys)
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

    @property
    def shapes_std(self) -> NDArray[np.complex128]:
        """Standard deviations of the real parts + i · those of the imaginary parts of ``shapes``.

        (n_channels, n_modes); NaN: not known.
        """
        unknown = np.full(len(self.channel_names), complex(np.nan, np.nan))
        columns = [unknown if mode.shape_std is None else mode.shape_std for mode in self.modes]
        return np.reshape(columns, (len(columns), len(unknown))).T.astype(complex)
