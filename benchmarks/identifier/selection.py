"""Automatic selection: what is found, what is made up, and what becomes of harmonics."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
import time

import numpy as np

from benchmarks.identifier import peers
from benchmarks.identifier.plant import chain_plant, Plant, random_plant, simulate
from benchmarks.identifier.record import reference_channels
from benchmarks.identifier.scatter import match
from benchmarks.table import Line
from modal_core.mode import Mode
from modal_core.samples import Samples
from oma_identifier.covariance import Decimation, plan_bands, WhenFull
from oma_identifier.identify import identify_samples
from oma_identifier.selection import identify_band, select_in_band
from oma_identifier.settings import IdentificationSettings
from oma_identifier.subspace import BandStream

FIRST_SEED = 72000
LINES = ((24.0, 0.5), (48.0, 0.25), (72.0, 0.12))
PRESETS = ('hier_avg', 'affinity', 'Dederichs')


@dataclass(frozen=True)
class Case:
    """Records of one kind; ``plant`` None: another random plant for each seed."""

    what: str
    plant: Plant | None
    rate_hz: float
    duration_s: float
    with_lines: bool = False

    def record(self, seed: int) -> tuple[Plant, Samples, tuple[float, ...]]:
        """Return the plant, its samples and the frequencies of the harmonics [Hz]."""
        generator = np.random.default_rng(seed)
        plant = self.plant or random_plant(generator)
        lines = LINES if self.with_lines else ()
        if self.with_lines and self.plant is None:
            first = generator.uniform(15.0, 30.0)
            lines = tuple((first * (k + 1), level) for k, (_, level) in enumerate(LINES))
        samples = simulate(plant, generator, self.duration_s, self.rate_hz, lines=lines)
        return plant, samples, tuple(hz for hz, _ in lines)


CASES = (
    Case('6 channels, 60 s', chain_plant(6, 110.0), 256.0, 60.0),
    Case('6 channels, 60 s, 3 harmonics', chain_plant(6, 110.0), 256.0, 60.0, True),
    Case('6 channels, 20 s', chain_plant(6, 110.0), 256.0, 20.0),
    Case('42 channels, 120 s', chain_plant(42), 512.0, 120.0),
    Case('random structures, a pair 1 % apart, 6 channels, 60 s', None, 256.0, 60.0),
    Case('the same with 3 harmonics anywhere', None, 256.0, 60.0, True),
)


@dataclass
class Tally:
    """Sums over runs."""

    n_runs: int = 0
    n_true: int = 0
    n_found: int = 0
    n_complete: int = 0
    n_false: int = 0
    n_lines: int = 0
    n_lines_reported: int = 0

    def add(self, modes: list[Mode], plant: Plant, lines_hz: tuple[float, ...]) -> None:
        """Count one run."""
        values, left = match(modes, plant)
        found = np.isfinite(values[0, 0])
        on_line = [
            mode
            for mode in left
            if any(abs(mode.frequency_hz / hz - 1.0) < 0.005 for hz in lines_hz)
        ]
        self.n_runs += 1
        self.n_true += len(found)
        self.n_found += int(found.sum())
        self.n_complete += bool(found.all())
        self.n_false += len(left) - len(on_line)
        self.n_lines += len(lines_hz)
        self.n_lines_reported += len(on_line)

    def figures(self) -> str:
        """Return recall, all found, false modes a run, harmonics kept out."""
        text = f'{self.n_found / self.n_true:.3f}, {self.n_complete / self.n_runs:.0%}, '
        text += f'{self.n_false / self.n_runs:.2f}'
        return text + (f', {1 - self.n_lines_reported / self.n_lines:.1%}' if self.n_lines else '')

    @property
    def enough(self) -> bool:
        """Whether all that is to be reached is."""
        return (
            self.n_found >= 0.99 * self.n_true
            and self.n_complete >= 0.95 * self.n_runs
            and self.n_false <= 0.02 * self.n_runs
            and self.n_lines_reported <= 0.01 * self.n_lines
        )


def rows(n_runs: int, n_peer_runs: int, presets: tuple[str, ...] = PRESETS[:1]) -> Iterator[Line]:
    """Yield the lines; the peer's presets see the first of our records."""
    if not peers.installed('pyoma2'):
        presets = ()
    peer_cost: list[float] = []
    for case in CASES:
        ours, theirs = Tally(), {preset: Tally() for preset in presets}
        for seed in range(FIRST_SEED, FIRST_SEED + n_runs):
            plant, samples, lines_hz = case.record(seed)
            ours.add(list(identify_samples(samples).modes), plant, lines_hz)
            if presets and seed < FIRST_SEED + n_peer_runs:
                select = _peer(samples)
                for preset in presets:
                    start = time.process_time()
                    modes = select(preset)
                    peer_cost.append(time.process_time() - start)
                    theirs[preset].add(modes, plant, lines_hz)
        best = max(theirs, key=lambda name: theirs[name].n_found, default=None)
        yield Line(
            'selection: recall, all found, false modes a run'
            + (', harmonics kept out' if ours.n_lines else '')
            + f'; {case.what} ({n_runs} runs, peer {min(n_runs, n_peer_runs)})',
            ours.figures(),
            f'{theirs[best].figures()} ({best})' if best else '-',
            reach='0.99, 95 %, 0.02' + (', 99 %' if ours.n_lines else ''),
            met=ours.enough,
        )
    cost_s = float(np.median([selection_cost(CASES[0], seed) for seed in range(5)]))
    other = float(np.median(peer_cost)) if peer_cost else float('nan')
    yield Line(
        'selection: CPU of selection alone with its σ, 6 channels, 60 s, all bands',
        f'{1e3 * cost_s:.1f} ms',
        f'{1e3 * other:.0f} ms',
        f'{other / cost_s:.0f}',
        '≤ 10 ms',
        cost_s <= 0.010,
    )


def selection_cost(case: Case, seed: int) -> float:
    """Return the CPU time of the selection in all bands [s]; poles are there already."""
    _, samples, _ = case.record(FIRST_SEED + seed)
    settings = IdentificationSettings()
    bands, rows = [], Decimation()
    rows.take(samples.acceleration)
    for band in plan_bands(samples.sample_rate_hz, samples.duration_s, settings):
        stream = BandStream(band, settings, samples.duration_s, WhenFull.JOIN)
        stream.add(rows)
        bands.append(identify_band(stream.result(), settings))
    start = time.process_time()
    for band in bands:
        select_in_band(band, settings)
    return time.process_time() - start


def _peer(samples: Samples) -> Callable[[str], list[Mode]]:
    """Return pyOMA2's selection by preset, its poles being computed."""
    from pyoma2.algorithms import SSI
    from pyoma2.algorithms.data.run_params import Clustering
    from pyoma2.setup import SingleSetup

    n_channels = len(samples.channels)
    options = (
        {'br': 30} if n_channels == 6 else {'br': 20, 'ref_ind': reference_channels(6).tolist()}
    )
    algorithm = SSI(name='peer', method='cov', ordmin=0, ordmax=60, step=2, **options)
    peers.run_pyoma2(SingleSetup(samples.acceleration, fs=samples.sample_rate_hz), algorithm)

    def select(preset: str) -> list[Mode]:
        with peers.quiet():
            algorithm.add_clustering(Clustering(name=preset, quick=preset))
            algorithm.run_clustering(preset)
        result = algorithm.result.clustering_results[preset]
        frequency, damping = np.ravel(result.Fn), np.ravel(result.Xi)
        return [
            Mode(float(hz), float(ratio), np.asarray(shape, dtype=complex))
            for hz, ratio, shape in zip(frequency, damping, result.Phi.T, strict=True)
        ]

    return select
