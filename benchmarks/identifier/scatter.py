"""Scatter, bias and honesty against the uncertainty law, over many simulated records.

`python -m benchmarks.identifier.scatter --runs 100 --out runs.jsonl` appends every run as it is
done, and leaves out what the file already holds.
"""

import argparse
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass
import json
from pathlib import Path
import time
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.stats import binom

from benchmarks.identifier.plant import chain_plant, Plant, simulate, with_uneven_damping
from benchmarks.table import Line
from modal_core.mode import Mode
from modal_core.numbers.indicators import mac
from modal_core.samples import Samples
from oma_identifier.identify import identify_samples
from oma_identifier.settings import IdentificationSettings

FIRST_SEED = 70000
SIMULATION_RATE_HZ = 16384.0
ESTIMATORS = ('subspace alone', 'as reported')
HONEST = (0.93, 0.97)
FREQUENCY_REACH, DAMPING_REACH, BIAS_REACH = 1.25, 1.45, 0.3


@dataclass(frozen=True, order=True)
class Case:
    """Records of one kind.

    Parameters
    ----------
    n_dampers : int
        Places of uneven damping, drawn anew for every record; 0: the damping of each mode alone.
    """

    n_channels: int
    duration_s: float
    n_dampers: int = 0

    def record(self, seed: int) -> tuple[Plant, Samples]:
        """Return a plant and its responses."""
        plant, rate_hz = case_plant(self.n_channels)
        generator = np.random.default_rng(seed)
        if self.n_dampers:
            plant = with_uneven_damping(plant, generator, self.n_dampers)
        samples = simulate(
            plant,
            generator,
            self.duration_s,
            rate_hz,
            simulation_rate_hz=SIMULATION_RATE_HZ,
        )
        return plant, samples

    def __str__(self) -> str:
        """Return what tables call it."""
        uneven = ', uneven damping' if self.n_dampers else ''
        return f'{self.n_channels} channels, {self.duration_s:.0f} s{uneven}'


CASES = (*(Case(n, t) for t in (20.0, 60.0, 120.0) for n in (6, 42)), Case(42, 60.0, 1))


def law(plant: Plant, duration_s: float) -> NDArray[np.float64]:
    """Return the least relative deviations (Au 2014) of frequency and damping, (2, n_modes)."""
    product = 2.0 * np.pi * plant.frequency_hz * plant.damping_ratio * duration_s
    return np.array([plant.damping_ratio / np.sqrt(product), 1.0 / np.sqrt(product)])


def case_plant(n_channels: int) -> tuple[Plant, float]:
    """Return the plant and the sample rate [Hz] of a number of channels."""
    if n_channels == 42:
        return chain_plant(42), 512.0
    return chain_plant(n_channels, 110.0), 256.0


def run(case: Case, seed: int) -> dict[str, Any]:
    """Identify one simulated record; errors and deviations in units of the law."""
    plant, samples = case.record(seed)
    start = time.process_time()
    found = identify_samples(samples, IdentificationSettings(refine=False))
    middle = time.process_time()
    reported = identify_samples(samples)
    end = time.process_time()
    limit = law(plant, case.duration_s)
    estimates = {}
    for name, modes, cpu_s in zip(
        ESTIMATORS, (found.modes, reported.modes), (middle - start, end - middle), strict=True
    ):
        values, left = match(modes, plant)
        truth = np.array([plant.frequency_hz, plant.damping_ratio])
        error = (values[0] / truth - 1.0) / limit
        deviation = values[1] / truth / limit
        estimates[name] = {
            'error': error.tolist(),
            'deviation': deviation.tolist(),
            'n_extra': len(left),
            'cpu_s': cpu_s,
        }
    return {**asdict(case), 'seed': seed, **estimates}


def match(modes: Iterable[Mode], plant: Plant) -> tuple[NDArray[np.float64], list[Mode]]:
    """Match modes to the truth, one to one: within 2 % and a MAC of 0.8.

    Returns
    -------
    values : (2, 2, n_modes) array
        Frequency [Hz] and damping ratio, then their standard deviations; NaN where not found.
    left : list of Mode
        Modes that are none of the plant's.
    """
    values = np.full((2, 2, len(plant.frequency_hz)), np.nan)
    left = list(modes)
    for index, truth_hz in enumerate(plant.frequency_hz):
        alike = [
            float(mac(mode.shape, plant.shapes[:, index])[0, 0])
            if abs(mode.frequency_hz / truth_hz - 1.0) < 0.02
            else 0.0
            for mode in left
        ]
        if not alike or max(alike) < 0.8:
            continue
        mode = left.pop(int(np.argmax(alike)))
        values[0, :, index] = mode.frequency_hz, mode.damping_ratio
        values[1, :, index] = mode.frequency_std_hz, mode.damping_ratio_std
    return values, left


@dataclass(frozen=True)
class Scatter:
    """Many runs of one estimator; rows are runs.

    Parameters
    ----------
    error, deviation : (n_runs, 2, n_modes) array
        Relative error of frequency and damping, and what was reported as its standard
        deviation, over the law; NaN where a mode was not found.
    n_extra : float
        Modes per run that are none of the plant's.
    cpu_s : float [s]
        Median per run.
    """

    error: NDArray[np.float64]
    deviation: NDArray[np.float64]
    n_extra: float
    cpu_s: float

    @property
    def spread(self) -> NDArray[np.float64]:
        """Standard deviation over the runs, (2, n_modes)."""
        return np.asarray(np.nanstd(self.error, axis=0))

    @property
    def bias(self) -> NDArray[np.float64]:
        """Mean error over the runs, (2, n_modes)."""
        return np.asarray(np.nanmean(self.error, axis=0))

    @property
    def inside(self) -> NDArray[np.float64]:
        """Share of the runs with the truth within two standard deviations, (2, n_modes)."""
        found = np.isfinite(self.error)
        held = (np.abs(self.error) < 2.0 * self.deviation) & found
        return np.asarray(held.sum(axis=0) / np.maximum(found.sum(axis=0), 1))

    @property
    def dishonest(self) -> list[int]:
        """Modes whose share of frequency or of damping chance does not bring to 93-97 %."""
        n_found = np.isfinite(self.error).sum(axis=0)
        held = np.rint(self.inside * n_found)
        low = binom.cdf(held, n_found, HONEST[0]) < 0.01
        high = binom.sf(held - 1, n_found, HONEST[1]) < 0.01
        return [int(mode) for mode in np.flatnonzero((low | high).any(axis=0))]

    @property
    def recall(self) -> float:
        """Share of the modes found."""
        return float(np.isfinite(self.error[:, 0]).mean())

    @property
    def all_found(self) -> float:
        """Share of the runs that found all modes."""
        return float(np.isfinite(self.error[:, 0]).all(axis=1).mean())


def case_of(record: dict[str, Any]) -> Case:
    """Return the case of a run."""
    return Case(record['n_channels'], record['duration_s'], record['n_dampers'])


def collect(records: Iterable[dict[str, Any]], case: Case, name: str) -> Scatter:
    """Return what an estimator did in the records of one case."""
    own = [record[name] for record in records if case_of(record) == case]
    return Scatter(
        np.array([each['error'] for each in own], dtype=float),
        np.array([each['deviation'] for each in own], dtype=float),
        float(np.mean([each['n_extra'] for each in own])),
        float(np.median([each['cpu_s'] for each in own])),
    )


def runs(
    n_runs: int, cases: Sequence[Case] = CASES, store: Path | None = None
) -> list[dict[str, Any]]:
    """Run what the store lacks, all cases of a seed before the next seed."""
    records = [json.loads(line) for line in _lines(store)]
    known = {(case_of(each), each['seed']) for each in records}
    for seed in range(FIRST_SEED, FIRST_SEED + n_runs):
        for case in cases:
            if (case, seed) in known:
                continue
            records.append(run(case, seed))
            if store is not None:
                with store.open('a', encoding='ascii') as file:
                    file.write(json.dumps(records[-1]) + '\n')
    return records


def _lines(store: Path | None) -> list[str]:
    if store is None or not store.exists():
        return []
    return store.read_text(encoding='ascii').splitlines()


def rows(records: list[dict[str, Any]]) -> Iterator[Line]:
    """Yield the lines of the table; beside ours not a peer but the subspace estimate alone."""
    for case in sorted({case_of(record) for record in records}):
        plain, ours = (collect(records, case, name) for name in ESTIMATORS)
        hz = case_plant(case.n_channels)[0].frequency_hz
        title = f'{case}, {len(ours.error)} runs'
        for part, (symbol, reach) in enumerate((('f', FREQUENCY_REACH), ('ζ', DAMPING_REACH))):
            spread, bias, inside = (float(value) for value in _middle(ours, part))
            worst = int(np.argmax(np.abs(ours.bias[part])))
            yield Line(
                f'{symbol}: σ and bias over the law, share within 2σ; {title}',
                f'{spread:.2f}, {bias:.2f} (most {abs(ours.bias[part, worst]):.2f} at'
                f' {hz[worst]:g} Hz), {inside:.1%}',
                '{:.2f}, {:.2f}, {:.1%}'.format(*_middle(plain, part)),
                reach=f'{reach}, {BIAS_REACH}, 93-97 %',
                met=spread <= reach and bias <= BIAS_REACH and HONEST[0] <= inside <= HONEST[1],
            )
        yield Line(
            f'modes with less or more than 93-97 % of f or ζ within 2σ beyond chance; {title}',
            ', '.join(_dishonest(ours, hz)) or 'none',
            ', '.join(_dishonest(plain, hz)) or 'none',
            reach='none',
            met=not ours.dishonest,
        )
        yield Line(
            f'recall, all found, false modes a run; {title}',
            f'{ours.recall:.3f}, {ours.all_found:.0%}, {ours.n_extra:.2f}',
            reach='0.99, 95 %, 0.02',
            met=ours.recall >= 0.99 and ours.all_found >= 0.95 and ours.n_extra <= 0.02,
        )


def _middle(scatter: Scatter, part: int) -> tuple[np.float64, np.float64, np.float64]:
    """Return the medians over the modes of scatter and bias, and the mean share within 2σ."""
    bias = np.abs(scatter.bias[part])
    return np.median(scatter.spread[part]), np.median(bias), scatter.inside[part].mean()


def _dishonest(scatter: Scatter, hz: NDArray[np.float64]) -> list[str]:
    inside = scatter.inside
    return [
        f'{hz[mode]:g} Hz ({inside[0, mode]:.0%}, {inside[1, mode]:.0%})'
        for mode in scatter.dishonest
    ]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--runs', type=int, default=100)
    parser.add_argument('--out', type=Path, required=True)
    arguments = parser.parse_args()
    for line in rows(runs(arguments.runs, store=arguments.out)):
        print(line.markdown())


if __name__ == '__main__':
    main()
