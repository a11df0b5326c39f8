"""Whether references mean the same in all set-ups: sign, gain and which is which.

A reference that is wired otherwise in one set-up makes two modes of one.  It is told from the
set-up's modes alone: some that fit no other's would, several at once, by one change of one sensor,
or without it.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from modal_core.errors import LayoutError
from modal_core.mode import Mode, ModeSet
from oma_identifier.compare.same_modes import same_modes
from oma_identifier.compare.thresholds import COMPARISON

# A matrix that shapes at the references are multiplied with, (n_references, n_references).
Change = NDArray[np.float64]

SAME_GAIN = 0.3
"""Logarithm of a gain that could be scatter of the shapes; chosen."""


def check_references(
    setups: Sequence[ModeSet], names: Sequence[str], references: Sequence[str]
) -> tuple[int, str] | None:
    """Refuse set-ups one of which has a reference turned, exchanged or of another gain.

    Parameters
    ----------
    setups : sequence of ModeSet
        With the references among their channels.
    names : sequence of str
        Of the set-ups.
    references : sequence of str
        Channels they share.

    Returns
    -------
    tuple of int and str, or None
        Set-up and reference that is to be left out of it: without it modes fit the others that
        no change of it makes fit.  It is dead, or stands elsewhere.  Of two set-ups nothing tells
        which.

    Raises
    ------
    LayoutError
        Naming set-up and sensor.
    """
    at_references = [_at(each, references) for each in setups]
    groups = same_modes(at_references, references)
    found: list[tuple[int, int, int, _Mended]] = []
    for k, at in enumerate(at_references):
        others = [_member(at_references, group, k) for group in groups if set(group) != {k}]
        rest = replace(at, modes=tuple(others))
        n_fit = _n_same(at, rest)
        if others and len(at) - n_fit >= COMPARISON.fewest_mended:
            mended = _mended(at, rest, n_fit)
            found.append((mended.n_same - n_fit, n_fit, k, mended))
    more, n_fit, k, mended = max(found, default=(0, 0, 0, _Mended()))
    if more < COMPARISON.fewest_mended:
        return None
    if len(mended.left_out) == 1 and len(setups) > 2:
        return k, mended.left_out[0]
    left_out = f'{" or ".join(mended.left_out)} left out'
    raise LayoutError(
        'a reference is another in this set-up',
        where=names[k] if len(names) > 2 else ' and '.join(names),
        found=f'{n_fit} of {len(setups[k])} modes are like those of the others, {n_fit + more}'
        f' with {left_out if mended.left_out else " or ".join(mended.changes)}',
        expected='the same place, axis, sign and gain of a reference in all set-ups',
        advice='mend it there, or leave it out of that set-up',
    )


@dataclass(frozen=True, slots=True, order=True)
class _Mended:
    """How many modes fit by the best change of a reference; the changes, or what to leave out."""

    n_same: int = 0
    changes: tuple[str, ...] = ()
    left_out: tuple[str, ...] = ()


def _mended(at: ModeSet, rest: ModeSet, n_fit: int) -> _Mended:
    changes = [
        (_n_same(_changed(at, change), rest), words) for words, change in _changes(at, rest)
    ]
    without = [
        (_n_same(_without(at, name), _without(rest, name)), name)
        for name in at.channel_names
        if len(at.channel_names) > 1
    ]
    most = max(changes, default=(0, ''))[0]
    if most < n_fit + COMPARISON.fewest_mended:
        most = n_fit
    # Fewer references tell modes less apart: one that is left out has to mend more.
    if (better := max(without, default=(0, ''))[0]) >= most + COMPARISON.fewest_mended:
        return _Mended(better, left_out=tuple(name for n, name in without if n == better))
    return _Mended(most, tuple(words for n_same, words in changes if n_same == most))


def _changed(modes: ModeSet, change: Change) -> ModeSet:
    return replace(modes, modes=tuple(replace(m, shape=change @ m.shape) for m in modes))


def _without(modes: ModeSet, name: str) -> ModeSet:
    return _at(modes, [each for each in modes.channel_names if each != name])


def _member(setups: Sequence[ModeSet], group: dict[int, int], besides: int) -> Mode:
    """Return a mode of a group, of another set-up."""
    k = next(each for each in group if each != besides)
    return setups[k].modes[group[k]]


def _at(modes: ModeSet, references: Sequence[str]) -> ModeSet:
    rows = [modes.channel_names.index(name) for name in references]
    kept = tuple(replace(mode, shape=mode.shape[rows], shape_std=None) for mode in modes.modes)
    return ModeSet(kept, tuple(references), modes.method)


def _n_same(own: ModeSet, rest: ModeSet) -> int:
    return sum(len(group) > 1 for group in same_modes([own, rest], own.channel_names))


def _changes(own: ModeSet, rest: ModeSet) -> Iterator[tuple[str, Change]]:
    """Yield what may have been done to references, in words and as it is undone."""
    names = own.channel_names
    gains = _gains(own, rest)
    for place, name in enumerate(names):
        turned = np.ones(len(names))
        turned[place] = -1.0
        yield f'{name} turned', np.diag(turned)
    for one, two in combinations(range(len(names)), 2):
        order = np.arange(len(names))
        order[[one, two]] = two, one
        yield f'{names[one]} and {names[two]} exchanged', np.eye(len(names))[order]
    for place, (name, gain) in enumerate(zip(names, gains, strict=True)):
        if abs(np.log(gain)) < SAME_GAIN:
            continue
        for sign in (1.0, -1.0):
            scaled = np.ones(len(names))
            scaled[place] = sign * gain
            yield f'{name} times {sign * gain:.2g}', np.diag(scaled)


def _gains(own: ModeSet, rest: ModeSet) -> NDArray[np.float64]:
    """Return by how much each reference is larger, over the others, in modes of like frequency."""
    nearest = [int(np.argmin(np.abs(rest.frequency_hz - mode.frequency_hz))) for mode in own.modes]
    mine, theirs = np.abs(own.shapes) ** 2, np.abs(rest.shapes[:, nearest]) ** 2
    share = [(each / np.maximum(each.sum(axis=0) - each, 1e-12)) for each in (theirs, mine)]
    return np.asarray(np.sqrt(np.median(share[0] / np.maximum(share[1], 1e-12), axis=1)))
