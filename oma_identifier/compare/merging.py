"""Several set-ups with shared references become one mode shape over all points.

Post-identification merging (PoSER): each set-up is identified, and the modes are joined.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
import math

import numpy as np
from numpy.typing import NDArray

from modal_core.errors import LayoutError
from modal_core.indicators import mac, mpc, mpd, normalise
from modal_core.mode import Mode, ModeSet

SAME_MAC = 0.7
SAME_FREQUENCY = 0.03


@dataclass(frozen=True, slots=True)
class _Matched:
    modes: tuple[Mode, ...]


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


def merge_modes(setups: Sequence[ModeSet]) -> ModeSet:
    """Merge the modes of several set-ups (PoSER).

    A mode is kept when every set-up has it: nearest in frequency, alike at the references.
    Frequency and damping are averaged with the inverse variances as weights where they are
    known; shapes are scaled to fit at the references by least squares, which are averaged.

    Parameters
    ----------
    setups : sequence of ModeSet
        With shared channel names.

    Raises
    ------
    LayoutError
        No channel is shared by all.

    References
    ----------
    Reynders, Magalhães, De Roeck and Cunha (2009), IMAC XXVII, Merging strategies for multi-setup
    operational modal analysis.
    """
    shared = shared_channels([modes.channel_names for modes in setups])
    names = list(setups[0].channel_names)
    for modes in setups[1:]:
        names += [name for name in modes.channel_names if name not in names]
    merged = []
    for mode in setups[0]:
        matched = _match(mode, setups, shared)
        if matched is not None:
            merged.append(_merged(matched.modes, setups, shared, names))
    merged.sort(key=lambda mode: mode.frequency_hz)
    return ModeSet(tuple(merged), tuple(names), setups[0].method)


def _at(mode: Mode, names: Sequence[str], wanted: Sequence[str]) -> NDArray[np.complex128]:
    return np.asarray(mode.shape[[list(names).index(name) for name in wanted]])


def _match(mode: Mode, setups: Sequence[ModeSet], shared: Sequence[str]) -> _Matched | None:
    """Return the mode and its like of every other set-up; None where one has none."""
    found = [mode]
    at_references = _at(mode, setups[0].channel_names, shared)
    for other in setups[1:]:
        best, cost = None, math.inf
        for candidate in other:
            apart = abs(candidate.frequency_hz / mode.frequency_hz - 1.0)
            alike = 1.0
            if len(shared) > 1:
                there = _at(candidate, other.channel_names, shared)
                alike = float(mac(at_references, there)[0, 0])
            if apart < SAME_FREQUENCY and alike > SAME_MAC:
                total = apart / SAME_FREQUENCY + (1.0 - alike) / (1.0 - SAME_MAC)
                best, cost = (candidate, total) if total < cost else (best, cost)
        if best is None:
            return None
        found.append(best)
    return _Matched(tuple(found))


def _merged(
    modes: Sequence[Mode], setups: Sequence[ModeSet], shared: Sequence[str], names: list[str]
) -> Mode:
    references = [
        _at(mode, setup.channel_names, shared) for mode, setup in zip(modes, setups, strict=True)
    ]
    total = np.zeros(len(names), dtype=complex)
    count = np.zeros(len(names))
    for mode, setup, reference in zip(modes, setups, references, strict=True):
        factor = np.vdot(reference, references[0]) / np.vdot(reference, reference)
        rows = [names.index(name) for name in setup.channel_names]
        total[rows] += factor * mode.shape
        count[rows] += 1.0
    shape = normalise(np.asarray(total / count, dtype=complex))
    frequency, frequency_std = _pooled(
        [mode.frequency_hz for mode in modes], [mode.frequency_std_hz for mode in modes]
    )
    damping, damping_std = _pooled(
        [mode.damping_ratio for mode in modes], [mode.damping_ratio_std for mode in modes]
    )
    return replace(
        modes[0],
        frequency_hz=frequency,
        damping_ratio=damping,
        shape=shape,
        frequency_std_hz=frequency_std,
        damping_ratio_std=damping_std,
        mpc=float(mpc(shape[:, None])[0]),
        mpd=float(mpd(shape[:, None])[0]),
    )


def _pooled(values: Sequence[float], deviations: Sequence[float]) -> tuple[float, float]:
    deviation = np.array(deviations)
    if np.all(np.isfinite(deviation)) and np.all(deviation > 0.0):
        weight = deviation**-2.0
        mean = float(np.sum(weight * np.array(values)) / np.sum(weight))
        return mean, float(np.sum(weight) ** -0.5)
    return float(np.mean(values)), math.nan
