"""What a window tells about the next one: where its refinement may start."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import NDArray

from modal_core.mode import Mode
from modal_core.numbers.indicators import mac
from oma_identifier.likelihood import (
    BandIndex,
    BandModel,
    continued,
    GroupFit,
    ModeIndex,
    ReducedBand,
    StartModes,
    whole_shape,
)
from oma_identifier.refinement.thresholds import REFINEMENT


@dataclass(frozen=True, slots=True)
class RefinedMode:
    """A mode that was refined, and the fit that did it.

    Parameters
    ----------
    mode : Mode
        As it was adopted.
    fit : GroupFit
        Of its band.
    position : BandIndex
        Of the mode in the fit.
    """

    mode: Mode
    fit: GroupFit
    position: BandIndex

    def shape_with(self, plain: NDArray[np.complex128]) -> NDArray[np.complex128]:
        """Return the shape, what was not refined of it taken from a new estimate.

        Were it kept instead, it would be that of the first window for ever.
        """
        if self.fit.fit is None or self.fit.band is None:
            return plain
        new = self.fit.fit.model.shapes[:, self.position]
        return whole_shape(self.fit.band, new, plain[:, None])


@dataclass(frozen=True, slots=True)
class WarmStart:
    """What the refinement of one stretch leaves for the next.

    Parameters
    ----------
    channels : (n_alive,) int array
        That were not dead.
    modes : tuple of RefinedMode
        Those adopted.
    """

    channels: NDArray[np.intp]
    modes: tuple[RefinedMode, ...]

    def start(
        self,
        given: Sequence[Mode],
        start: StartModes,
        alive: NDArray[np.intp],
        idle: Collection[ModeIndex],
    ) -> 'StartingValues | None':
        """Return where to start; None where the structure may have changed.

        Parameters
        ----------
        given : sequence of Mode
            As identified now.
        start : StartModes
            The same.
        alive : (n_alive,) int array
            Channels of ``start``.
        idle : collection of ModeIndex
            Modes that will not be refined and stay as given.
        """
        if not np.array_equal(alive, self.channels):
            return None
        frequency, damping = start.frequency_hz.copy(), start.damping_ratio.copy()
        shapes, known = start.shapes.copy(), dict[ModeIndex, RefinedMode]()
        for index, mode in zip(start.indices(), given, strict=True):
            if index in idle:
                continue
            like = min(self.modes, key=lambda known: abs(_apart(mode, known.mode)), default=None)
            if like is None or not _agrees(mode, like.mode):
                return None
            frequency[index] = like.mode.frequency_hz
            damping[index] = like.mode.damping_ratio
            shapes[:, index] = like.shape_with(start.shapes[:, index])
            known[index] = like
        return StartingValues(StartModes(frequency, damping, shapes), known)


@dataclass(frozen=True, slots=True)
class StartingValues:
    """Where the refinement of a window starts.

    Parameters
    ----------
    modes : StartModes
        All modes.
    known : dict of ModeIndex to RefinedMode
        Those refined before.
    """

    modes: StartModes
    known: dict[ModeIndex, RefinedMode]

    def begin(self, band: ReducedBand) -> BandModel | None:
        """Return where the fit of a band begins, if one fit before was of the same modes."""
        free = band.included[: band.model.n_free]
        fits = [self.known[mode].fit for mode in free if mode in self.known]
        if len(fits) < len(free) or any(fit is not fits[0] for fit in fits):
            return None
        index = {mode: each.fit.group[each.position] for mode, each in self.known.items()}
        return continued(band, fits[0], index)


def _apart(mode: Mode, other: Mode) -> float:
    return mode.frequency_hz - other.frequency_hz


def _agrees(mode: Mode, other: Mode) -> bool:
    """Tell whether a mode is where another was; False for a deviation of NaN."""
    if len(mode.shape) != len(other.shape):
        return False
    f_spread = math.hypot(mode.frequency_std_hz, other.frequency_std_hz)
    d_spread = math.hypot(mode.damping_ratio_std, other.damping_ratio_std)
    return (
        abs(_apart(mode, other)) <= REFINEMENT.remembered_std * f_spread
        and abs(mode.damping_ratio - other.damping_ratio) <= REFINEMENT.remembered_std * d_spread
        and bool(mac(mode.shape, other.shape)[0, 0] > REFINEMENT.remembered_mac)
    )
