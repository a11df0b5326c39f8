"""Scatter, bias and honesty of identified and of refined modes against the uncertainty law."""

from dataclasses import dataclass
import time

import numpy as np
from numpy.typing import NDArray

from benchmarks.plant import chain_plant, Plant, simulate
from modal_core.indicators import mac
from modal_core.mode import ModeSet
from oma_identifier.identify import identify_samples
from oma_identifier.refinement import refine


@dataclass(frozen=True)
class Scatter:
    """Monte Carlo of one estimator; errors in units of the law, rows are runs.

    Parameters
    ----------
    label : str
        What was run.
    error : (n_runs, 2, n_modes) array
        Relative error of frequency and damping over the law; NaN where a mode was not found.
    deviation : (n_runs, 2, n_modes) array
        Reported standard deviations, in the same units.
    n_extra : float
        Modes per run that are none of the plant's.
    cpu_s : float [s]
        Mean per run.
    """

    label: str
    error: NDArray[np.float64]
    deviation: NDArray[np.float64]
    n_extra: float
    cpu_s: float

    def row(self) -> str:
        """Return one row of the table."""
        scatter = np.nanmedian(np.nanstd(self.error, axis=0), axis=1)
        bias = np.nanmedian(np.abs(np.nanmean(self.error, axis=0)), axis=1)
        found = np.isfinite(self.error[:, 0])
        inside = np.abs(self.error) < 2.0 * self.deviation
        share = [100.0 * np.mean(inside[:, part][found]) for part in (0, 1)]
        return (
            f'| {self.label} | {scatter[0]:.2f} | {scatter[1]:.2f} '
            f'| {bias[0]:.2f} | {bias[1]:.2f} | {share[0]:.0f} % | {share[1]:.0f} % '
            f'| {found.mean():.3f} '
            f'| {100.0 * np.mean(found.all(axis=1)):.0f} % | {self.n_extra:.2f} '
            f'| {self.cpu_s:.2f} |'
        )


HEADER = (
    '| channels, length, estimator | σ_f/law | σ_ζ/law | bias f | bias ζ | f within 2σ '
    '| ζ within 2σ | recall | all found | false modes | CPU s |\n'
    '|---|---|---|---|---|---|---|---|---|---|---|'
)


def law(plant: Plant, duration_s: float) -> NDArray[np.float64]:
    """Return the least relative deviations (Au 2014) of frequency and damping, (2, n_modes)."""
    product = 2.0 * np.pi * plant.frequency_hz * plant.damping_ratio * duration_s
    return np.array([plant.damping_ratio / np.sqrt(product), 1.0 / np.sqrt(product)])


def monte_carlo(
    n_channels: int, duration_s: float, n_runs: int, first_seed: int = 5000
) -> tuple[Scatter, Scatter]:
    """Return the scatter of the automatic identification and of its refinement."""
    plant = chain_plant(n_channels, 250.0 if n_channels == 42 else 110.0)
    rate_hz = 512.0 if n_channels == 42 else 256.0
    limit = law(plant, duration_s)
    collected: dict[str, list[tuple[NDArray[np.float64], float, float]]] = {'ssi': [], 'fit': []}
    for seed in range(first_seed, first_seed + n_runs):
        samples = simulate(plant, np.random.default_rng(seed), duration_s, rate_hz)
        start = time.process_time()
        found = identify_samples(samples)
        middle = time.process_time()
        refined = refine(samples, found.modes, found.harmonics)
        end = time.process_time()
        collected['ssi'].append((*_match(found.modes, plant, limit), middle - start))
        collected['fit'].append((*_match(refined.modes, plant, limit), end - middle))
    label = f'{n_channels}, {duration_s:.0f} s'
    return (
        _scatter(f'{label}, identified', collected['ssi']),
        _scatter(f'{label}, refined', collected['fit']),
    )


def _match(
    modes: ModeSet, plant: Plant, limit: NDArray[np.float64]
) -> tuple[NDArray[np.float64], float]:
    """Return error and deviation of each true mode, (2, 2, n_modes), and the modes left over."""
    values = np.full((2, 2, len(plant.frequency_hz)), np.nan)
    truth = np.array([plant.frequency_hz, plant.damping_ratio])
    left = list(modes)
    for index in range(len(plant.frequency_hz)):
        near = [
            mode
            for mode in left
            if abs(mode.frequency_hz / truth[0, index] - 1.0) < 0.02
            and mac(mode.shape, plant.shapes[:, index])[0, 0] > 0.8
        ]
        if not near:
            continue
        mode = max(near, key=lambda mode: mac(mode.shape, plant.shapes[:, index])[0, 0])
        left = [other for other in left if other is not mode]
        value = np.array([mode.frequency_hz, mode.damping_ratio])
        sigma = np.array([mode.frequency_std_hz, mode.damping_ratio_std])
        values[0, :, index] = (value / truth[:, index] - 1.0) / limit[:, index]
        values[1, :, index] = sigma / truth[:, index] / limit[:, index]
    return values, float(len(left))


def _scatter(label: str, runs: list[tuple[NDArray[np.float64], float, float]]) -> Scatter:
    values = np.array([run[0] for run in runs])
    return Scatter(
        label,
        values[:, 0],
        values[:, 1],
        float(np.mean([run[1] for run in runs])),
        float(np.mean([run[2] for run in runs])),
    )
