"""Every method on the same records: `python -m benchmarks.methods`, about four minutes.

Random families, structures that a tool cuts on, and ones shaken at one place after the other.
Nobody tunes on these seeds.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
import time
import warnings

import numpy as np

from benchmarks.families.drawing import draw
from benchmarks.families.family import FAMILIES
from benchmarks.families.judge import judge, Verdict
from benchmarks.families.record import Record
from benchmarks.families.tally import Tally
from benchmarks.identifier.plant import simulate
from benchmarks.methods.milled import Cut, milled, RATE_HZ
from benchmarks.results import write_rows
from modal_core.channel import Channel
from modal_core.errors import ModalAnalysisError
from modal_core.samples import Samples
from oma_identifier.methods import identify_by

FIRST_SEED = 790_000
DRAWN, N_DRAWN = ('plain', 'heavy', 'noisy', 'few'), 2
N_MILLED, N_IN_TURN, IN_TURN_S = 5, 4, 120.0
ON_ALL = ('ssi_cov', 'ssi_data', 'plscf', 'var', 'psdtm', 'efdd')
ON_MILLED = ('ssi_cov', 'ssi_data', 'var', 'notch', 'vmd')
IN_TURN = ('ssi_cov', 'ssi_data', 'var', 'psdtm')
COLUMNS = (
    'records',
    'method',
    'modes found',
    'false modes',
    'lines as modes',
    '2σ of f',
    '2σ of ζ',
    'f, ζ over the law',
    'CPU s a record',
)


@dataclass(frozen=True)
class Case:
    """Records, and the methods that are asked."""

    what: str
    records: Sequence[Record]
    methods: tuple[str, ...]


def cases() -> Iterator[Case]:
    """Yield the cases; records are drawn when they are wanted."""
    seeds = range(FIRST_SEED, FIRST_SEED + N_DRAWN)
    drawn = [draw(FAMILIES[name], seed) for seed in seeds for name in DRAWN]
    yield Case(f'{len(drawn)} random structures', drawn, ON_ALL)
    for what, cut in (
        ('milling, steady speed', Cut()),
        ('milling, speed grows by 10 %', Cut(ramp=0.1)),
        ('milling, speed wavers by ± 1 %', Cut(waver=0.01)),
    ):
        seeds = range(FIRST_SEED, FIRST_SEED + N_MILLED)
        records = [milled(seed, replace(cut, speed=seed % 3)).truth for seed in seeds]
        yield Case(f'{what}, {N_MILLED} structures', records, ON_MILLED)
    records = [in_turn(FIRST_SEED + number) for number in range(N_IN_TURN)]
    yield Case(f'one coloured force after the other, {N_IN_TURN} structures', records, IN_TURN)


def in_turn(seed: int) -> Record:
    """Return a record of a structure that two coloured forces shake one after the other."""
    truth = milled(seed, Cut(turns=False)).truth
    rng, plant = np.random.default_rng(seed), truth.plant
    rows = [
        simulate(
            replace(plant, participation=plant.participation[:, [force]]),
            rng,
            IN_TURN_S,
            RATE_HZ,
            noise=truth.noise,
            colour=0.98,
        ).acceleration
        for force in (0, 1)
    ]
    return replace(truth, acceleration=np.concatenate(rows), forces='coloured in turn')


def verdict_on(record: Record, method: str) -> Verdict | str:
    """Return what a method makes of a record, or why it refuses."""
    names = tuple(Channel(f'ch{one + 1}') for one in range(record.acceleration.shape[1]))
    start = time.process_time()
    try:
        found = identify_by(method, Samples(record.acceleration, record.rate_hz, names))
    except ModalAnalysisError as error:
        return str(error)
    verdict = judge(found.modes.modes, found.harmonics.modes, record)
    verdict.cpu_s = time.process_time() - start
    return verdict


def row(case: Case, method: str) -> list[str]:
    """Return the line of a method."""
    results = [verdict_on(record, method) for record in case.records]
    verdicts = [each for each in results if isinstance(each, Verdict)]
    if not verdicts:
        return [case.what, method, 'refused', *[''] * 6]
    tally = Tally(verdicts)
    asked = sum(sum(each.asked) for each in verdicts)
    n_found = sum(sum(each.found) for each in verdicts)
    n_lines = tally.total('n_lines')
    law = [tally.scatter(part)[0] for part in (1, 2)]
    return [
        case.what,
        method,
        f'{n_found} of {asked}',
        f'{tally.total("n_false"):.0f}',
        f'{tally.total("n_lines_as_modes"):.0f} of {n_lines:.0f}' if n_lines else '-',
        str(tally.inside(0)),
        str(tally.inside(1)),
        ', '.join('-' if np.isnan(each) else f'{each:.2f}' for each in law),
        f'{np.mean([each.cpu_s for each in verdicts]):.2f}',
    ]


def main() -> None:
    """Measure, print and keep the table."""
    warnings.simplefilter('ignore')
    rows = []
    print(' | '.join(COLUMNS))
    for case in cases():
        for method in case.methods:
            rows.append(row(case, method))
            print(' | '.join(rows[-1]), flush=True)
    write_rows('methods', COLUMNS, rows)


if __name__ == '__main__':
    main()
