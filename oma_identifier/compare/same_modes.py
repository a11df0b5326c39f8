"""Which modes of several set-ups are one: the odds of it, and groups that make them largest.

Two estimates are of one mode when their frequencies and their shapes at the references lie closer
than those of two modes would.  Odds are compared for all pairs of set-ups; a group has at most one
mode of each, and whether one belongs to it is asked of all its members, not of the nearest.
"""

from collections.abc import Iterator, Sequence
import math

import numpy as np
from numpy.typing import NDArray
from scipy.special import betaln, gammaln, logsumexp

from modal_core.mode import Mode, ModeSet
from modal_core.numbers.assignment import cheapest_pairs
from modal_core.numbers.indicators import mac
from oma_identifier.compare.thresholds import COMPARISON

NEVER = -1e3
MOST_ROUNDS = 10

Array = NDArray[np.float64]


def same_modes(setups: Sequence[ModeSet], references: Sequence[str]) -> list[dict[int, int]]:
    """Return the groups of modes that are one, by frequency.

    Parameters
    ----------
    setups : sequence of ModeSet
        With the references among their channels.
    references : sequence of str
        Channels they share.
    """
    if not any(len(modes) for modes in setups):
        return []
    owner = np.array([k for k, modes in enumerate(setups) for _ in modes], dtype=int)
    place = np.array([i for modes in setups for i in range(len(modes))], dtype=int)
    odds = _log_odds(setups, references)
    odds[owner[:, None] == owner] = NEVER
    label = _rearranged(_joined(odds, owner), odds, owner)
    label = _without_unclear(label, odds, owner)
    frequency = np.concatenate([modes.frequency_hz for modes in setups])
    groups = [np.flatnonzero(label == one) for one in np.unique(label[label >= 0])]
    groups.sort(key=lambda members: float(np.median(frequency[members])))
    return [{int(owner[i]): int(place[i]) for i in members} for members in groups]


def _log_odds(setups: Sequence[ModeSet], references: Sequence[str]) -> Array:
    """Return the log odds of any two modes being one against being two, (n, n) array."""
    modes = [mode for each in setups for mode in each]
    log_f = np.log([mode.frequency_hz for mode in modes])
    std = np.nan_to_num([mode.frequency_std_hz / mode.frequency_hz for mode in modes])
    step = log_f[:, None] - log_f
    total = std[:, None] ** 2 + std**2 + 2.0 * np.square(COMPARISON.scatters)[:, None, None]
    same = logsumexp(-0.5 * (step**2 / total + np.log(2.0 * np.pi * total)), axis=0)
    same -= math.log(len(COMPARISON.scatters))
    same += _damping_odds(modes)
    shapes = np.concatenate(
        [each.shapes[[each.channel_names.index(name) for name in references]] for each in setups],
        axis=1,
    )
    shapes = np.nan_to_num(shapes)
    loss = np.array([mode.mac_loss if math.isfinite(mode.mac_loss) else 0.0 for mode in modes])
    alike = _shape_odds(
        1.0 - mac(shapes, shapes), loss[:, None] + loss + COMPARISON.shape_slack, references
    )
    return np.asarray(same - math.log(_density(setups)) + alike)


def _damping_odds(modes: Sequence[Mode]) -> Array:
    """Return the log odds of damping ratios so far apart, of one mode against of any two."""
    log_d = np.log([max(mode.damping_ratio, 1e-6) for mode in modes])
    std = [mode.damping_ratio_std / max(mode.damping_ratio, 1e-6) for mode in modes]
    own = np.nan_to_num(std, nan=COMPARISON.withheld_scatter) ** 2 + COMPARISON.damping_scatter**2
    one, two = own[:, None] + own, 2.0 * max(float(np.var(log_d)), COMPARISON.damping_scatter**2)
    square = (log_d[:, None] - log_d) ** 2
    return np.asarray(0.5 * (square / (one + two) - square / one + np.log(1.0 + two / one)))


def _density(setups: Sequence[ModeSet]) -> float:
    """Return the number of modes in an interval of 1 of log frequency."""
    each = [modes.frequency_hz for modes in setups if len(modes)]
    return max(
        [len(f) / max(math.log(f[-1] / f[0]), COMPARISON.narrowest) for f in each], default=1.0
    )


def _shape_odds(apart: Array, loss: Array, references: Sequence[str]) -> Array:
    """Return the log odds of shapes so alike being one against being of random directions.

    1 - MAC of one: a sum of n - 1 squares of mean ``loss``; of random directions in n
    dimensions: Beta((n - 1) / 2, 1 / 2) distributed.
    """
    half = 0.5 * (len(references) - 1)
    if half == 0.0:
        return np.zeros_like(apart)
    one = half * np.log(half / loss) - gammaln(half) - half * apart / loss
    two = -0.5 * np.log(np.clip(1.0 - apart, 1e-6, 1.0)) - betaln(half, 0.5)
    return np.asarray(one - two)


def _joined(odds: Array, owner: NDArray[np.intp]) -> NDArray[np.intp]:
    """Join the two groups that are most surely one, by the mean of all pairs, until none is."""
    n = len(owner)
    label = np.arange(n)
    sums, count = odds.copy(), np.ones(n)
    taken = np.zeros((n, owner.max(initial=0) + 1), dtype=bool)
    taken[np.arange(n), owner] = True
    np.fill_diagonal(sums, NEVER)
    apart = owner[:, None] == owner
    while n:
        mean = np.where(apart, NEVER, sums / np.outer(count, count))
        first, second = np.unravel_index(int(np.argmax(mean)), mean.shape)
        if mean[first, second] <= 0.0:
            break
        sums[first] += sums[second]
        sums[:, first] += sums[:, second]
        count[first] += count[second]
        taken[first] |= taken[second]
        apart[second] = apart[:, second] = True
        clash = (taken & taken[first]).any(axis=1)
        apart[first] |= clash
        apart[:, first] |= clash
        label[label == second] = first
    return label


def _rearranged(label: NDArray[np.intp], odds: Array, owner: NDArray[np.intp]) -> NDArray[np.intp]:
    """Give the modes of one set-up after the other to the groups of all others, best in all."""
    for _ in range(MOST_ROUNDS):
        before = label.copy()
        for setup in np.unique(owner):
            own = np.flatnonzero(owner == setup)
            label[own] = -1 - own
            groups, gain = _gains(own, label, odds)
            # Beside the groups each may stay alone, which gains nothing.
            cost = np.concatenate([-gain, np.zeros((len(own), len(own)))], axis=1)
            rows, columns = cheapest_pairs(cost)
            for row, column in zip(rows, columns, strict=True):
                joins = column < len(groups) and cost[row, column] < 0.0
                label[own[row]] = groups[column] if joins else own[row]
            _renamed(label)
        if np.array_equal(_renamed(before), label):
            break
    return label


def _gains(
    own: NDArray[np.intp], label: NDArray[np.intp], odds: Array
) -> tuple[NDArray[np.intp], Array]:
    """Return the groups of others and the mean log odds of belonging to each, (n_own, n)."""
    others = label.copy()
    others[own] = -1
    groups = np.unique(others[others >= 0])
    gain = [odds[np.ix_(own, others == group)].mean(axis=1) for group in groups]
    return groups, np.array(gain).reshape(len(groups), len(own)).T


def _without_unclear(
    label: NDArray[np.intp], odds: Array, owner: NDArray[np.intp]
) -> NDArray[np.intp]:
    """Take modes, the least clear first, out of groups that they could have exchanged."""
    label = label.copy()
    while True:
        swaps = [swap for setup in np.unique(owner) for swap in _swaps(setup, label, odds, owner)]
        margin, members = min(swaps, default=(COMPARISON.clear, ()))
        if margin >= COMPARISON.clear:
            return label
        label[list(members)] = -1


def _swaps(
    setup: int, label: NDArray[np.intp], odds: Array, owner: NDArray[np.intp]
) -> Iterator[tuple[float, tuple[int, ...]]]:
    """Yield what an exchange between two groups would cost in log odds, and who takes part."""
    own = np.flatnonzero((owner == setup) & (label >= 0))
    groups, gain = _gains(own, label, odds)
    at = {int(label[member]): row for row, member in enumerate(own)}
    for column, group in enumerate(groups):
        if (row := at.get(int(group))) is None:
            continue
        for other, there in enumerate(groups):
            if other == column or (label == there).sum() < 2:
                continue
            margin = gain[row, column] - gain[row, other]
            members: tuple[int, ...] = (int(own[row]),)
            if (second := at.get(int(there))) is not None:
                margin += gain[second, other] - gain[second, column]
                members += (int(own[second]),)
            yield float(margin), members


def _renamed(label: NDArray[np.intp]) -> NDArray[np.intp]:
    """Name each group, in place, by its first member."""
    _, first, inverse = np.unique(label, return_index=True, return_inverse=True)
    label[:] = first[inverse]
    return label
