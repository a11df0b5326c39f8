"""What was measured at one pose."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from modal_core.errors import MapError
from modal_core.mode import ModeSet
from modal_core.numbers.indicators import rotate_to_real

Array = NDArray[np.float64]


@dataclass(frozen=True)
class MeasuredPose:
    """Modes of one pose with their standard deviations.

    Parameters
    ----------
    q : (n_joints,) array [rad]
        Serial joint angles.
    frequency_hz, frequency_std_hz : (n_modes,) array [Hz]
        Natural frequencies.
    damping_ratio, damping_ratio_std : (n_modes,) array
        Damping ratios; NaN: not known.
    shapes, shape_std : (n_channels, n_modes) array
        Real shapes of unit length over the channels, and their standard deviations; NaN: not
        known, the shape then says which mode it is and nothing more.
    duration_s : float [s]
        Of the record.
    plan_hash : str
        What was played; empty: not known.
    """

    q: Array
    frequency_hz: Array
    frequency_std_hz: Array
    damping_ratio: Array
    damping_ratio_std: Array
    shapes: Array
    shape_std: Array
    duration_s: float = 0.0
    plan_hash: str = ''

    def __post_init__(self) -> None:
        """Refuse what no measurement is."""
        n = np.size(self.frequency_hz)
        own = (self.frequency_std_hz, self.damping_ratio, self.damping_ratio_std)
        right = (
            all(np.shape(part) == (n,) for part in (self.frequency_hz, *own))
            and self.shapes.shape == self.shape_std.shape
        )
        if not right or self.shapes.ndim != 2 or self.shapes.shape[1] != n:
            raise MapError('lists of different length', where='measured pose', found=n)
        values = (self.q, self.frequency_hz, self.frequency_std_hz, self.shapes)
        if not all(np.isfinite(part).all() for part in values):
            raise MapError('not finite', where='measured pose')
        if n and not (self.frequency_hz.min() > 0.0 and self.frequency_std_hz.min() > 0.0):
            raise MapError('a frequency or its standard deviation is not positive')

    @classmethod
    def of(
        cls,
        q: ArrayLike,
        modes: ModeSet,
        channels: Sequence[str],
        duration_s: float = 0.0,
        plan_hash: str = '',
    ) -> 'MeasuredPose':
        """Return the modes of an identification whose frequency has σ, without machines' lines.

        Parameters
        ----------
        q : (n_joints,) array [rad]
            Serial joint angles.
        modes : ModeSet
            Identified.
        channels : sequence of str
            Names of the map's channels; all must be among the identified ones.
        duration_s, plan_hash
            See the class.

        Raises
        ------
        MapError
            A channel is missing.
        """
        missing = sorted(set(channels) - set(modes.channel_names))
        if missing:
            raise MapError('channels without a result', found=', '.join(missing))
        rows = [modes.channel_names.index(name) for name in channels]
        kept = tuple(
            mode
            for mode in modes
            if not mode.harmonic
            and mode.frequency_std_hz > 0.0
            and np.isfinite(mode.frequency_std_hz)
            and np.isfinite(mode.shape).all()
        )
        found = ModeSet(kept, modes.channel_names)
        shapes = rotate_to_real(found.shapes[rows]).real
        size = np.linalg.norm(shapes, axis=0)
        return cls(
            np.asarray(q, dtype=float),
            found.frequency_hz,
            np.array([mode.frequency_std_hz for mode in kept]),
            found.damping_ratio,
            np.array([mode.damping_ratio_std for mode in kept]),
            shapes / size,
            found.shapes_std[rows].real / size,
            duration_s,
            plan_hash,
        )

    def __len__(self) -> int:
        """Return the number of modes."""
        return len(self.frequency_hz)
