"""Several set-ups with shared references become one set of modes over all points.

Each set-up is identified, and the modes are joined (PoSER, post separate estimation re-scaling).
A mode that some set-ups did not see is kept with the points that were seen.

References
----------
Reynders, Magalhães, De Roeck and Cunha (2009), IMAC XXVII, Merging strategies for multi-setup
operational modal analysis.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
import math

import numpy as np
from numpy.typing import NDArray

from modal_core.errors import LayoutError
from modal_core.mode import Mode, ModeSet
from modal_core.numbers.indicators import mpc, mpd
from modal_core.samples import Samples
from oma_identifier.compare.common_values import common_positive
from oma_identifier.compare.joined_shape import joined_shape, own_variance, PartialShape
from oma_identifier.compare.known_poles import shapes_at_poles
from oma_identifier.compare.same_modes import same_modes
from oma_identifier.compare.thresholds import COMPARISON

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class MergedModes:
    """Modes of several set-ups as one.

    Parameters
    ----------
    modes : ModeSet
        Over all points; NaN in a shape where none of the set-ups that saw the mode had a sensor.
    seen_in : tuple of tuple of int
        Per mode, which set-ups saw it.
    read_in : tuple of tuple of int
        Per mode, out of which others' covariances it was read.
    n_setups : int
        How many there are.
    frequency_scatter, damping_scatter : float
        Between set-ups beyond chance, as a share; it is in the standard deviations.
    """

    modes: ModeSet
    seen_in: tuple[tuple[int, ...], ...]
    read_in: tuple[tuple[int, ...], ...]
    n_setups: int
    frequency_scatter: float
    damping_scatter: float


def shared_channels(names: Sequence[Sequence[str]]) -> tuple[str, ...]:
    """Return the channel names all set-ups have, in the order of the first.

    Raises
    ------
    LayoutError
        There is none.
    """
    shared = tuple(name for name in names[0] if all(name in other for other in names[1:]))
    if not shared:
        raise LayoutError(
            'the set-ups share no channel',
            found='; '.join(', '.join(one) for one in names),
            advice='keep at least one reference sensor in place in all set-ups',
        )
    return shared


def merge_modes(
    setups: Sequence[ModeSet], samples: Callable[[int], Samples | None] | None = None
) -> MergedModes:
    """Merge the modes of several set-ups.

    Frequency and damping are those common to set-ups that scatter; shapes are fitted to each
    other at the points that set-ups share.

    Parameters
    ----------
    setups : sequence of ModeSet
        With shared channel names.
    samples : callable or None
        Number of a set-up to its samples, where they are at hand: modes that it does not show
        are read out of their covariances.

    Raises
    ------
    LayoutError
        No channel is shared by all.
    """
    shared = shared_channels([modes.channel_names for modes in setups])
    names = tuple(dict.fromkeys(name for modes in setups for name in modes.channel_names))
    groups = same_modes(setups, shared)
    frequency = common_positive(
        _table(setups, groups, 'frequency_hz'),
        _table(setups, groups, 'frequency_std_hz'),
        1.0,
        COMPARISON.largest_scatter[0],
    )
    # The root of a damping ratio scatters alike whatever its size.
    damping = common_positive(
        _table(setups, groups, 'damping_ratio'),
        _table(setups, groups, 'damping_ratio_std'),
        0.5,
        COMPARISON.largest_scatter[1],
    )
    values = (frequency.value, damping.value, frequency.std, damping.std)
    poles = [
        Mode(f, d, np.empty(0, dtype=complex), f_std, d_std)
        for f, d, f_std, d_std in np.transpose(values).tolist()
    ]
    parts = [
        {k: _part(setups[k].modes[i], setups[k].channel_names, names) for k, i in group.items()}
        for group in groups
    ]
    read_in: list[tuple[int, ...]] = [()] * len(groups)
    modes = [_with_shape(*each, len(names)) for each in zip(poles, parts, strict=True)]
    if samples is not None:
        read_in = _read_out(len(setups), modes, parts, (names, shared), samples)
        modes = [_with_shape(*each, len(names)) for each in zip(poles, parts, strict=True)]
    order = np.argsort(frequency.value)
    return MergedModes(
        ModeSet(tuple(modes[row] for row in order), names, setups[0].method),
        tuple(tuple(sorted(groups[row])) for row in order),
        tuple(read_in[row] for row in order),
        len(setups),
        frequency.scatter,
        damping.scatter,
    )


def _read_out(
    n_setups: int,
    modes: Sequence[Mode],
    parts: Sequence[dict[int, PartialShape]],
    points: tuple[tuple[str, ...], tuple[str, ...]],
    samples: Callable[[int], Samples | None],
) -> list[tuple[int, ...]]:
    """Add what set-ups tell of modes that they do not show; return which did, per mode.

    A shape without deviations gives way to one that has them.
    """
    names, shared = points
    references = [names.index(name) for name in shared]
    found: list[tuple[int, ...]] = [()] * len(modes)
    seen_in = [frozenset(own) for own in parts]
    for k in range(n_setups):
        rows = [
            row
            for row, mode in enumerate(modes)
            if (k not in seen_in[row] or parts[row][k].variance is None)
            and np.isfinite(mode.shape[references]).all()
        ]
        own = samples(k) if rows else None
        if own is None:
            continue
        wanted = [replace(modes[row], shape=modes[row].shape[references]) for row in rows]
        beside = [mode for row, mode in enumerate(modes) if row not in rows]
        place = np.array([names.index(name) for name in own.channel_names])
        for row, part in zip(rows, shapes_at_poles(own, shared, beside, wanted), strict=True):
            if part is not None:
                parts[row][k] = replace(part, rows=place[part.rows])
                if k not in seen_in[row]:
                    found[row] = (*found[row], k)
    return found


def _table(setups: Sequence[ModeSet], groups: Sequence[dict[int, int]], name: str) -> Array:
    """Return a field of the modes, (n_modes, n_setups), NaN where a set-up has none."""
    table = np.full((len(groups), len(setups)), math.nan)
    for row, group in enumerate(groups):
        for column, place in group.items():
            table[row, column] = getattr(setups[column].modes[place], name)
    return table


def _with_shape(mode: Mode, parts: Mapping[int, PartialShape], n_points: int) -> Mode:
    """Return a mode with what the set-ups saw of its shape."""
    joined = joined_shape([parts[k] for k in sorted(parts)], n_points)
    seen = joined.shape[np.isfinite(joined.shape)][:, None]
    return replace(
        mode,
        shape=joined.shape,
        mpc=float(mpc(seen)[0]),
        mpd=float(mpd(seen)[0]),
        shape_std=joined.std,
        mac_loss=joined.mac_loss,
        mac_loss_std=joined.mac_loss_std,
    )


def _part(mode: Mode, own: Sequence[str], names: Sequence[str]) -> PartialShape:
    """Return what a mode says of the points; nothing of a channel that took no part."""
    std = mode.shape_std
    seen = np.isfinite(mode.shape) & ((mode.shape != 0.0) | (std is not None and std != 0.0))
    rows = np.array([names.index(name) for name, here in zip(own, seen, strict=True) if here])
    shape = mode.shape[seen]
    return PartialShape(rows, shape, None if std is None else own_variance(shape, std[seen]))
