"""The cases whose cost is compared; `python -m benchmarks.cases NAME FILE` runs one."""

from collections.abc import Callable
from dataclasses import replace
import json
from pathlib import Path
import sys
import time

import numpy as np

from benchmarks import peers
from benchmarks.plant import chain_plant, Plant, simulate
from modal_core.channel import Channel
from modal_core.mode import ModeSet
from modal_core.samples import Samples
from oma_identifier.fdd import efdd
from oma_identifier.identify import identify_samples
from oma_identifier.methods import identify_by
from oma_identifier.output_covariance import lagged_products
from oma_identifier.plscf import plscf
from oma_identifier.references import choose_references
from oma_identifier.refinement import refine
from oma_identifier.ssi_cov import factorise, MultiOrder, poles_of_orders
from oma_identifier.ssi_data import ssi_data

BLOCK_ROWS, ORDER, RATE_HZ = 20, 60, 512.0
ORDERS = range(2, ORDER + 1, 2)


def write_window(path: Path) -> None:
    """Simulate 42 channels, 120 s at 512 Hz, so that no case pays for it."""
    samples = simulate(chain_plant(42), np.random.default_rng(1), 120.0, RATE_HZ)
    np.save(path, samples.acceleration)


def window(path: Path) -> tuple[Plant, Samples]:
    rows = np.load(path)
    channels = tuple(Channel(f's{row // 3:02d}.{"xyz"[row % 3]}') for row in range(42))
    return chain_plant(42), Samples(rows, RATE_HZ, channels)


def references(samples: Samples, count: int) -> np.ndarray:
    return choose_references(samples.acceleration, count)


def ours_ssi_cov(samples: Samples, count: int) -> object:
    rows = samples.acceleration - samples.acceleration.mean(axis=0)
    used = references(samples, count)
    lags = 2 * BLOCK_ROWS - 1
    covariance = lagged_products(rows, np.zeros((lags, rows.shape[1])), used) / len(rows)
    factors = factorise(covariance, BLOCK_ROWS, ORDER)
    system = MultiOrder(factors, ORDER)
    return poles_of_orders([system.solve(order) for order in ORDERS], factors.left[:42])


def ours_ssi_data(samples: Samples, count: int) -> object:
    rows = samples.acceleration - samples.acceleration.mean(axis=0)
    return ssi_data(rows, references(samples, count), BLOCK_ROWS, ORDERS)


def ours_plscf(samples: Samples) -> object:
    rows = samples.acceleration - samples.acceleration.mean(axis=0)
    return plscf(rows, references(samples, 6), 512, range(2, 13), (0.01, 0.45))


def damping_errors(plant: Plant, frequency_hz: np.ndarray, damping: np.ndarray) -> str:
    """Return how many modes were found and their damping errors."""
    errors = []
    for truth, ratio in zip(plant.frequency_hz, plant.damping_ratio, strict=True):
        near = np.flatnonzero(np.abs(frequency_hz / truth - 1.0) < 0.02)
        if len(near):
            best = near[np.argmin(np.abs(frequency_hz[near] - truth))]
            errors.append(abs(damping[best] / ratio - 1.0))
    if not errors:
        return 'no mode found'
    return (
        f'{len(errors)}/{len(plant.frequency_hz)} modes, damping error mean '
        f'{100 * np.mean(errors):.0f} %, median {100 * np.median(errors):.0f} %'
    )


def of_modes(plant: Plant, modes: ModeSet) -> str:
    return damping_errors(plant, modes.frequency_hz, modes.damping_ratio)


def of_poles(plant: Plant, frequency: np.ndarray, damping: np.ndarray) -> str:
    """Use the highest order, as a user without a stabilisation diagram would."""
    frequency, damping = frequency[:, -1], damping[:, -1]
    keep = np.isfinite(frequency) & (damping > 0.0) & (damping < 0.15)
    return damping_errors(plant, frequency[keep], damping[keep])


def run(name: str, path: Path) -> tuple[float, str]:
    plant, samples = window(path)
    prepared = _prepared(name, samples)
    start = time.process_time()
    result = CASES[name](plant, samples, prepared)
    return time.process_time() - start, result


def _prepared(name: str, samples: Samples) -> object:
    """Results of an earlier step that the case does not pay for."""
    return identify_samples(samples).modes if name == 'ours refine' else None


def _refined(plant: Plant, samples: Samples, modes: object) -> str:
    assert isinstance(modes, ModeSet)
    bare = replace(modes)
    result = refine(samples, bare)
    return f'{result.n_refined}/{len(bare)} refined; {of_modes(plant, result.modes)}'


def _raw(function: Callable[[Samples], object]) -> Callable[[Plant, Samples, object], str]:
    def case(plant: Plant, samples: Samples, _: object) -> str:
        function(samples)
        return ''

    return case


def _list(samples: Samples, count: int) -> list[int]:
    return [int(index) for index in references(samples, count)]


CASES: dict[str, Callable[[Plant, Samples, object], str]] = {
    'ours idle': _raw(lambda samples: None),
    'ours cov 42': _raw(lambda samples: ours_ssi_cov(samples, 42)),
    'ours cov 6': _raw(lambda samples: ours_ssi_cov(samples, 6)),
    'ours data 42': _raw(lambda samples: ours_ssi_data(samples, 42)),
    'ours data 6': _raw(lambda samples: ours_ssi_data(samples, 6)),
    'ours plscf poles': _raw(ours_plscf),
    'ours plscf': lambda plant, samples, _: of_modes(plant, identify_by('plscf', samples).modes),
    'ours efdd': lambda plant, samples, _: of_modes(plant, efdd(samples)),
    'ours automatic': lambda plant, samples, _: of_modes(plant, identify_samples(samples).modes),
    'ours refine': _refined,
    'pyoma2 cov 42': lambda plant, samples, _: of_poles(
        plant, *peers.pyoma2_ssi(samples, 'cov', BLOCK_ROWS, ORDER, None)
    ),
    'pyoma2 cov 6': lambda plant, samples, _: of_poles(
        plant, *peers.pyoma2_ssi(samples, 'cov', BLOCK_ROWS, ORDER, _list(samples, 6))
    ),
    'pyoma2 cov_R 42': lambda plant, samples, _: of_poles(
        plant, *peers.pyoma2_ssi(samples, 'cov_R', BLOCK_ROWS, ORDER, None)
    ),
    'pyoma2 data 42': lambda plant, samples, _: of_poles(
        plant, *peers.pyoma2_ssi(samples, 'dat', BLOCK_ROWS, ORDER, None)
    ),
    'pyoma2 data 6': lambda plant, samples, _: of_poles(
        plant, *peers.pyoma2_ssi(samples, 'dat', BLOCK_ROWS, ORDER, _list(samples, 6))
    ),
    'pyoma2 std 6': lambda plant, samples, _: of_poles(
        plant,
        *peers.pyoma2_ssi(samples, 'cov', BLOCK_ROWS, ORDER, _list(samples, 6), with_std=True),
    ),
    'pyoma2 plscf': lambda plant, samples, _: of_poles(plant, *peers.pyoma2_plscf(samples, 6)),
    'pyoma2 efdd': lambda plant, samples, _: damping_errors(
        plant, *peers.pyoma2_efdd(samples, list(plant.frequency_hz))
    ),
    'koma cov': _raw(lambda samples: peers.koma_ssi(samples, BLOCK_ROWS, ORDER)),
}


def main() -> None:
    cpu_s, detail = run(sys.argv[1], Path(sys.argv[2]))
    # Not ru_maxrss: a child inherits that from the process that started it.
    status = Path('/proc/self/status').read_text(encoding='ascii').split('VmHWM:')[1]
    peak_mb = float(status.split()[0]) / 1024.0
    print(json.dumps({'cpu_s': cpu_s, 'peak_mb': peak_mb, 'detail': detail}))


if __name__ == '__main__':
    main()
