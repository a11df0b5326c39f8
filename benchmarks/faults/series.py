"""A series of records, each once whole and once with a fault drawn for it."""

from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
import os
import resource
import signal
from types import FrameType

import numpy as np
from scipy.stats import poisson

from benchmarks.faults.arm_faults import ARM_FAULTS, arm_run
from benchmarks.faults.data_faults import FAULTS
from benchmarks.faults.file_faults import Notes, WAYS
from benchmarks.faults.judge import judge, Outcome, run
from benchmarks.faults.scene import measurements, random_scene
from benchmarks.table import Line

FIRST_SEED = 880_000
"""Seeds of reports; development uses others."""
ARM_SHARE = 5
"""Runs of an arm for every run of each other kind."""
TWO_AT_ONCE = 0.15
SLOWEST = 2.0
SPARED_S = 0.5
"""Processor time that no record is too short to need: the first use of each path costs it."""
LONGEST_S = 30
"""Processor time after which a run counts as hanging; without a fault it takes a second."""
MOST_BYTES = 4 << 30
"""Address space of a run."""
BY_CHANCE = 0.0027
"""Share beyond three standard deviations."""


@dataclass(frozen=True)
class Finding:
    """What one fault did.

    Parameters
    ----------
    seed : int
        Draws record, fault and place.
    faults : str
        Kinds.
    clean_s, cpu_s : float [s]
        Processor time without and with the fault.
    n_clean_values, n_clean_outside : int
        Values published without the fault, and those beyond three deviations.
    n_values : int
        Values published.
    outside : tuple of str
        What is wrong and not flagged.
    n_flagged : int
        What is wrong under a flag.
    share_identified : float
        Results with modes, of those the record has without the fault.
    silent : bool
        Results are missing and nothing says why.
    crash, refusal : str
        Exception; one line.
    flags : tuple of str
        That the record has because of the fault.
    """

    seed: int
    faults: str
    clean_s: float = 0.0
    cpu_s: float = 0.0
    n_clean_values: int = 0
    n_clean_outside: int = 0
    n_values: int = 0
    outside: tuple[str, ...] = ()
    n_flagged: int = 0
    share_identified: float = 0.0
    silent: bool = False
    crash: str = ''
    refusal: str = ''
    flags: tuple[str, ...] = ()

    @property
    def hangs(self) -> bool:
        """Whether it took more than twice the time of the record without the fault."""
        return self.cpu_s > SLOWEST * self.clean_s + SPARED_S


def kind_of(seed: int) -> str:
    """Return the name of the fault that a seed stands for; a second one may come to it."""
    kinds = [*FAULTS, *WAYS]
    number = seed % (len(kinds) + ARM_SHARE)
    return kinds[number].__name__ if number < len(kinds) else 'arm'


def examine(seed: int) -> Finding:
    """Run one record with and without a fault."""
    rng = np.random.default_rng(seed)
    number = seed % (len(FAULTS) + len(WAYS) + ARM_SHARE)
    if number >= len(FAULTS) + len(WAYS):
        return _examine_arm(seed, rng)
    scene = random_scene(rng)
    signal.setitimer(signal.ITIMER_PROF, LONGEST_S)
    clean = run(measurements(scene))
    chosen = [FAULTS[number]] if number < len(FAULTS) else []
    way = WAYS[number - len(FAULTS)] if not chosen else None
    if rng.random() < TWO_AT_ONCE:
        chosen.append(FAULTS[rng.integers(len(FAULTS))])
    faulty = scene
    for fault in chosen:
        faulty = fault(rng, faulty)
    signal.setitimer(signal.ITIMER_PROF, LONGEST_S)
    notes = Notes()
    outcome = run(way(rng, faulty, notes) if way else measurements(faulty))
    outcome.flags |= notes
    signal.setitimer(signal.ITIMER_PROF, 0)
    control, published = judge(clean, scene, set()), judge(outcome, faulty, clean.flags)
    return Finding(
        seed=seed,
        faults=' + '.join(kind.__name__ for kind in (way, *chosen) if kind),
        clean_s=clean.cpu_s,
        cpu_s=outcome.cpu_s,
        n_clean_values=control.n_values,
        n_clean_outside=len(control.outside) + control.n_flagged,
        n_values=published.n_values,
        outside=tuple(published.outside),
        n_flagged=published.n_flagged,
        share_identified=outcome.n_identified / max(1, clean.n_identified),
        silent=_silent(outcome, clean),
        crash=outcome.crash,
        refusal=outcome.refusal,
        flags=tuple(sorted(outcome.flags - clean.flags)),
    )


def _examine_arm(seed: int, rng: np.random.Generator) -> Finding:
    """Run an arm into a fault; whatever it does that it may not is wrong."""
    fault = ARM_FAULTS[int(rng.integers(len(ARM_FAULTS)))]
    crash, end, wrong = '', '', []
    signal.setitimer(signal.ITIMER_PROF, LONGEST_S)
    try:
        end, wrong = arm_run(rng, fault)
    except Exception as error:  # noqa: BLE001 - any crash is a finding
        crash = f'{type(error).__name__}: {error}'
    signal.setitimer(signal.ITIMER_PROF, 0)
    return Finding(
        seed=seed, faults=f'arm: {fault.__name__}', outside=tuple(wrong), crash=crash, refusal=end
    )


def _silent(outcome: Outcome, clean: Outcome) -> bool:
    """Tell whether half the results are missing without a word."""
    told = bool(outcome.flags - clean.flags) or bool(outcome.refusal or outcome.crash)
    return not told and 2 * outcome.n_identified < clean.n_identified


def findings(seeds: Sequence[int]) -> Iterator[Finding]:
    """Yield what each seed's fault did, in the order of the seeds."""
    with ProcessPoolExecutor(os.cpu_count(), initializer=_bound) as pool:
        yield from pool.map(examine, seeds)


def _bound() -> None:
    """Let a run that hangs or takes all memory be a finding and no end of the series."""
    resource.setrlimit(resource.RLIMIT_AS, (MOST_BYTES, MOST_BYTES))
    signal.signal(signal.SIGPROF, _too_long)


def _too_long(_: int, __: FrameType | None) -> None:
    raise TimeoutError(f'not done after {LONGEST_S} s')


def rows(n_runs: int) -> Iterator[Line]:
    """Yield the lines."""
    found = list(findings(range(FIRST_SEED, FIRST_SEED + n_runs)))
    what = f'{n_runs} random faults, seeds from {FIRST_SEED}'
    for name, bad in (
        ('crashes', [each for each in found if each.crash]),
        (
            f'more than {SLOWEST:g} times the processor time',
            [each for each in found if each.hangs],
        ),
        ('half the results missing without a word', [each for each in found if each.silent]),
    ):
        seeds = ', '.join(str(each.seed) for each in bad[:8])
        yield Line(f'{what}: {name}', f'{len(bad)} {seeds}'.strip(), reach='0', met=not bad)
    data = [each for each in found if not each.faults.startswith('arm')]
    yield _line_of_values(f'{what}: beyond 3σ and not flagged', data)
    yield _line_of_arms(what, found)


def _line_of_arms(what: str, found: Sequence[Finding]) -> Line:
    arms = [each for each in found if each.faults.startswith('arm')]
    wrong = [each for each in arms if each.outside]
    seeds = ', '.join(f'{each.seed} {each.outside[0]}' for each in wrong[:4])
    return Line(
        f'{what}: arms that moved unreleased, went beyond their plan or did not stop, of'
        f' {len(arms)} runs',
        f'{len(wrong)} {seeds}'.strip(),
        reach='0',
        met=not wrong,
    )


def _line_of_values(what: str, found: Sequence[Finding]) -> Line:
    n_values = sum(each.n_values for each in found)
    n_outside = sum(len(each.outside) for each in found)
    n_clean = sum(each.n_clean_values for each in found)
    n_clean_outside = sum(each.n_clean_outside for each in found)
    # Overlapping windows and the whole share their data: the records without fault say what
    # chance makes of these very results.
    chance = max(BY_CHANCE, n_clean_outside / max(1, n_clean))
    most = int(poisson.isf(0.01, chance * n_values))
    return Line(
        f'{what}, of {n_values} values (the same records without faults: {n_clean_outside} of'
        f' {n_clean})',
        str(n_outside),
        reach=f'≤ {most}, chance',
        met=n_outside <= most,
    )
