"""CPU time, peak memory and agreement with the peers on the same records, case by case."""

from collections.abc import Iterator
from dataclasses import dataclass
import math
from pathlib import Path
import tempfile

import numpy as np
from numpy.typing import NDArray

from benchmarks.identifier import peers
from benchmarks.identifier.cost import Cost, measure
from benchmarks.identifier.plant import DAMPING_RATIO, FREQUENCY_HZ
from benchmarks.identifier.record import FIRST_SEED, write_record
from benchmarks.table import Line

LONG_S = 4.0
"""Cases that take longer are run once unless all repeats are asked for."""
SAME_POLE = 1e-6


@dataclass(frozen=True)
class Pair:
    """Ours beside a peer's, with the least ratios of time and memory to reach."""

    what: str
    ours: str
    peer: str
    faster: float = math.nan
    leaner: float = math.nan
    same_poles: bool = False


PAIRS = (
    Pair('SSI-cov, 42 references', 'ours cov 42', 'pyoma2 cov 42', 10.0, 7.0, same_poles=True),
    Pair('SSI-cov, 6 references', 'ours cov 6', 'pyoma2 cov 6', 8.0, 7.0, same_poles=True),
    Pair('SSI-cov, 42 references, against `cov_R`', 'ours cov 42', 'pyoma2 cov_R 42', 4.0),
    Pair('σ of all poles of all orders, 6 references', 'ours std of all poles', 'pyoma2 std'),
    Pair('σ of 12 modes, 6 references', 'ours std of the modes', 'pyoma2 std', 50.0),
    Pair('SSI-data, 42 references', 'ours data 42', 'pyoma2 data 42', 5.0, 5.0),
    Pair('SSI-data, 6 references', 'ours data 6', 'pyoma2 data 6', 5.0, 5.0),
    Pair('pLSCF, poles to order 6, 42 references', 'ours plscf poles', 'pyoma2 plscf', 5.0, 5.0),
    Pair(
        'pLSCF, unattended, with σ, against poles to order 6 without',
        'ours plscf',
        'pyoma2 plscf',
        5.0,
        5.0,
    ),
    Pair('EFDD, unattended, against picked peaks', 'ours efdd', 'pyoma2 efdd', 5.0, 5.0),
    Pair('SSI-cov, 42 references, against koma', 'ours cov 42', 'koma cov 42'),
    Pair('SSI-cov, 42 references, against strid', 'ours cov 42', 'strid cov 42'),
    Pair('SSI-cov, 6 references, against strid', 'ours cov 6', 'strid cov 6'),
    Pair('all by default: bands, selection, σ, refined', 'ours automatic', 'pyoma2 std'),
)
DAMPING = (
    ('pLSCF', 'ours plscf', 'pyoma2 plscf', 'its highest order'),
    ('EFDD', 'ours efdd', 'pyoma2 efdd', 'its default bells of 1 Hz'),
    ('EFDD', 'ours efdd', 'pyoma2 efdd wide', 'bells as wide as the mode'),
)
DAMPING_REACH = 0.15


def rows(n_repeats: int, every_repeat: bool = False) -> Iterator[Line]:
    """Yield the lines, each repeat on another record, ours and the peer's in turn."""
    with tempfile.TemporaryDirectory() as folder:
        records = []
        for seed in range(FIRST_SEED, FIRST_SEED + n_repeats):
            records.append(Path(folder) / f'{seed}.npy')
            write_record(records[-1], seed)
        store = _Store(records, every_repeat)
        for pair in PAIRS:
            yield from _pair_lines(pair, store)
        yield _alone(store)
        for name, ours, peer, how in DAMPING:
            yield _damping_line(name, store.costs(ours), store.costs(peer), how)


class _Store:
    """Measures a case when it is first asked for."""

    def __init__(self, records: list[Path], every_repeat: bool) -> None:
        self._records, self._every = records, every_repeat
        self._known: dict[str, list[Cost]] = {}

    def pair(self, ours: str, peer: str) -> tuple[list[Cost], list[Cost]]:
        """Return the costs of two cases; what is not known yet is measured in turn."""
        for record in self._records:
            for case in (ours, peer):
                self._next(case, record)
        return self._known[ours], self._known[peer]

    def costs(self, case: str) -> list[Cost]:
        for record in self._records:
            self._next(case, record)
        return self._known[case]

    def _next(self, case: str, record: Path) -> None:
        known = self._known.setdefault(case, [])
        if len(known) > self._records.index(record):
            return
        stop = known and (known[-1].error or (known[-1].cpu_s > LONG_S and not self._every))
        if not stop:
            absent = not case.startswith('ours') and not peers.installed(case.split()[0])
            known.append(Cost(error='not installed') if absent else measure(case, record))


def _pair_lines(pair: Pair, store: _Store) -> Iterator[Line]:
    ours, peer = store.pair(pair.ours, pair.peer)
    error = ours[0].error or peer[0].error
    if error:
        yield Line(pair.what, '-' if ours[0].error else _seconds(ours), error)
        return
    for what, unit, of, reach in (
        ('CPU', 's', lambda cost: cost.cpu_s, pair.faster),
        ('peak memory', 'MB', lambda cost: cost.peak_mb, pair.leaner),
    ):
        own, other = (float(np.median([of(cost) for cost in each])) for each in (ours, peer))
        digits = '.3g' if unit == 's' else '.0f'
        yield Line(
            f'{pair.what}: {what}',
            f'{own:{digits}} {unit}',
            f'{other:{digits}} {unit}',
            f'{other / own:.1f}',
            f'≥ {reach:g}' if math.isfinite(reach) else '-',
            other / own >= reach if math.isfinite(reach) else None,
        )
    if pair.same_poles:
        yield _agreement_line(pair.what, ours, peer)
    if 'deviation' in ours[0].found and 'deviation' in peer[0].found:
        yield _deviation_line(pair.what, ours[0], peer[0])


def _agreement_line(what: str, ours: list[Cost], peer: list[Cost]) -> Line:
    """Every pole of the peer, at every order, has its equal among ours."""
    distances = [
        distance
        for own, other in zip(ours, peer, strict=False)
        for distance in _nearest(own, other)[0]
    ]
    worst = max(distances)
    return Line(
        f'{what}: relative distance of poles, largest of {len(distances)}',
        f'{worst:.1e}',
        reach=f'≤ {SAME_POLE:g}',
        met=worst <= SAME_POLE,
    )


def _deviation_line(what: str, ours: Cost, peer: Cost) -> Line:
    _, own, other = _nearest(ours, peer)
    ratio = ours.found['deviation'][own] / peer.found['deviation'][other]
    middle = np.nanmedian(ratio, axis=0)
    return Line(
        f'{what}: ours over the peer’s σ of f, ζ, median', f'{middle[0]:.2f}, {middle[1]:.2f}'
    )


def _nearest(
    ours: Cost, peer: Cost
) -> tuple[NDArray[np.float64], NDArray[np.int64], NDArray[np.int64]]:
    """Return for each of the peer's poles the relative distance to ours and both indices."""
    distances, own, other = [], [], []
    for order in np.unique(peer.found['order']):
        mine = np.flatnonzero(ours.found['order'] == order)
        theirs = np.flatnonzero(peer.found['order'] == order)
        if len(mine) == 0:
            continue
        target = peer.found['pole'][theirs]
        gap = np.abs(target[:, None] - ours.found['pole'][mine]) / np.abs(target)[:, None]
        distances.append(gap.min(axis=1))
        own.append(mine[gap.argmin(axis=1)])
        other.append(theirs)
    return np.concatenate(distances), np.concatenate(own), np.concatenate(other)


def _alone(store: _Store) -> Line:
    """What the standard deviations add to the poles."""
    with_std, without = store.pair('ours std of the modes', 'ours poles for std')
    added = float(np.median([a.cpu_s - b.cpu_s for a, b in zip(with_std, without, strict=True)]))
    return Line('σ of 12 modes alone: CPU', f'{added:.3f} s', reach='≤ 0.2 s', met=added <= 0.2)


def _damping_line(name: str, ours: list[Cost], peer: list[Cost], how: str) -> Line:
    own, other = _damping_error(ours), _damping_error(peer)
    met = own[0] <= DAMPING_REACH
    return Line(
        f'{name} damping error, mean of the modes found; peer with {how}',
        f'{own[0]:.0%}, {own[1]:.3g} of 12 found',
        f'{other[0]:.0%}, {other[1]:.3g} of 12 found',
        reach=f'≤ {DAMPING_REACH:.0%}',
        met=met,
    )


def _damping_error(costs: list[Cost]) -> tuple[float, float]:
    """Return the mean relative error and how many modes are found, within 2 % of frequency."""
    errors, counts = [], []
    for cost in costs:
        if 'frequency' not in cost.found:
            continue
        frequency, damping = cost.found['frequency'], cost.found['damping']
        found = 0
        for hz, ratio in zip(FREQUENCY_HZ, DAMPING_RATIO, strict=True):
            gap = np.abs(frequency / hz - 1.0)
            if len(gap) and gap.min() < 0.02:
                found += 1
                errors.append(abs(damping[gap.argmin()] / ratio - 1.0))
        counts.append(found)
    return (float(np.mean(errors)), float(np.mean(counts))) if errors else (math.nan, 0.0)


def _seconds(costs: list[Cost]) -> str:
    return f'{np.median([cost.cpu_s for cost in costs]):.3g} s'
