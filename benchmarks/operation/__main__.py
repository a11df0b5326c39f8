"""Methods and peers on the milling arm: `make bench BENCH=operation`, five minutes of one core.

Nobody tunes on the seeds of the report; development has seeds below 780,000.
"""

import argparse
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
import time
import warnings

import numpy as np
from numpy.typing import NDArray

from autonomous_modal_analysis import identify
from benchmarks.operation.judge import judge, Verdict
from benchmarks.operation.peers import koma_modes, pyoma2_modes
from benchmarks.operation.scene import left_db, Scene, scene, SPEEDS_RPM
from benchmarks.results import versions, write_rows
from modal_core.errors import ModalAnalysisError
from modal_core.mode import Mode
from modal_core.samples import Samples
from oma_identifier.methods import identify_by
from oma_identifier.moving_lines import without_moving

FIRST_SEED, N_ARMS = 781_000, 3
RAMP = 0.1
HEADLINE = 'ama identify'
METHODS = ('ssi_cov', 'ssi_data', 'plscf', 'var', 'notch', 'vmd', 'efdd', 'fdd', 'psdtm')
PEERS = {'pyOMA2': pyoma2_modes, 'koma': koma_modes}
COLUMNS = (
    'the arm mills',
    'method',
    'modes found',
    'false modes',
    'lines as modes',
    'f within 2σ',
    'ζ within 2σ',
    'f off by % (rms)',
    'ζ off by % (rms)',
    'CPU s a record',
)
Find = Callable[[Samples], Sequence[Mode]]


@dataclass(frozen=True)
class Case:
    """Records of one kind: seed, speed and ramp of each."""

    what: str
    records: tuple[tuple[int, int, float], ...]

    def scenes(self) -> Iterator[Scene]:
        """Yield the records."""
        for seed, speed, ramp in self.records:
            yield scene(seed, speed, ramp)


def cases(first_seed: int, n_arms: int, ramp: bool) -> tuple[Case, ...]:
    """Return what is measured: steady speeds, or one that grows."""
    seeds = range(first_seed, first_seed + n_arms)
    speeds = range(len(SPEEDS_RPM))
    steady = tuple(
        Case(f'{rpm:.0f} rpm', tuple((seed, speed, 0.0) for seed in seeds))
        for speed, rpm in enumerate(SPEEDS_RPM)
    )
    ramps = tuple((seed, speed, RAMP) for seed in seeds for speed in speeds)
    return (Case(f'speed grows by {RAMP:.0%}', ramps),) if ramp else steady


def finders() -> dict[str, Find]:
    """Return all methods and peers by name."""

    def ours(name: str) -> Find:
        return lambda samples: list(identify_by(name, samples).modes)

    return {HEADLINE: first_printed, **{name: ours(name) for name in METHODS}, **PEERS}


def first_printed(samples: Samples) -> list[Mode]:
    """Return what `ama identify` prints first: the default method, refined.

    A channel that was left out stands still in all shapes.
    """
    n_channels = len(samples.channels)
    modes = identify(samples.widened(), samples.sample_rate_hz).modes
    # An array's channels are numbered.
    kept = [int(name.removeprefix('ch')) - 1 for name in modes.channel_names]
    return [replace(mode, shape=_spread(mode.shape, kept, n_channels)) for mode in modes]


def _spread(shape: NDArray[np.complex128], kept: list[int], n: int) -> NDArray[np.complex128]:
    spread = np.zeros(n, dtype=complex)
    spread[kept] = shape
    return spread


def verdict(find: Find, one: Scene) -> Verdict:
    """Return what a method or a peer makes of a record."""
    start = time.process_time()
    try:
        modes, refused = find(one.samples), ''
    except ModalAnalysisError as error:
        modes, refused = [], str(error)
    found = judge(modes, one)
    found.cpu_s, found.refused = time.process_time() - start, refused
    return found


def row(what: str, name: str, verdicts: Sequence[Verdict]) -> list[str]:
    """Return the line of a method in one case."""
    if all(each.refused for each in verdicts):
        return [what, name, 'refused', *[''] * 7]
    asked = sum(each.n_asked for each in verdicts)
    f, zeta = (
        np.concatenate([getattr(each, part) for each in verdicts])
        for part in ('f_error', 'z_error')
    )
    return [
        what,
        name,
        f'{sum(each.n_found for each in verdicts)} of {asked}',
        str(sum(each.n_false for each in verdicts)),
        str(sum(each.n_lines for each in verdicts)),
        _inside(verdicts, 0),
        _inside(verdicts, 1),
        _rms(f),
        _rms(zeta),
        f'{np.mean([each.cpu_s for each in verdicts]):.1f}',
    ]


def _rms(errors: NDArray[np.float64]) -> str:
    known = errors[np.isfinite(errors)]
    return f'{100.0 * np.sqrt(np.mean(known**2)):.2g}' if len(known) else '-'


def _inside(verdicts: Sequence[Verdict], part: int) -> str:
    known = [each[part] for own in verdicts for each in own.inside if each[part] is not None]
    return f'{sum(map(bool, known))} of {len(known)}' if known else 'no σ'


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure, print and keep the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--first-seed', type=int, default=FIRST_SEED)
    parser.add_argument('--arms', type=int, default=N_ARMS)
    parser.add_argument(
        '--ramp', action='store_true', help='a speed that grows instead; printed, not kept'
    )
    chosen = parser.parse_args(arguments)
    warnings.simplefilter('ignore')
    rows, levels = [], []
    print(' | '.join(COLUMNS))
    for case in cases(chosen.first_seed, chosen.arms, chosen.ramp):
        all_of: dict[str, list[Verdict]] = {name: [] for name in finders()}
        left: list[float] = []
        for one in case.scenes():
            levels += one.above_db
            for name, find in finders().items():
                all_of[name].append(verdict(find, one))
            if one.moves:
                rest = without_moving(one.samples)[0]
                left += left_db(rest.widened(), one.chips, one.lines_hz)
        for name, verdicts in all_of.items():
            rows.append(row(case.what, name, verdicts))
            print(' | '.join(rows[-1]), flush=True)
        if left:
            told = f'{np.median(left):.1f} (worst {max(left):.1f}) dB over the chips'
            rows.append([case.what, 'what following leaves of lines', told, *[''] * 7])
            print(' | '.join(rows[-1]), flush=True)
    low, middle, high = np.percentile(levels, (10, 50, 90))
    where = f'lines {middle:.0f} dB (10 to 90 %: {low:.0f} to {high:.0f}) above the response'
    print(where)
    if (chosen.first_seed, chosen.arms, chosen.ramp) == (FIRST_SEED, N_ARMS, False):
        write_rows('operation', COLUMNS, rows, (*versions(), where))


if __name__ == '__main__':
    main()
