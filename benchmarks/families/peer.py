"""What pyOMA2 makes of a record: SSI-cov and its best automatic selection, at three sizes.

The presets are what its users would turn, with more block rows where few channels need them, and
one channel given twice.  The preset that does best in a family, in modes found less modes made up,
stands beside ours.  The method of lagged products, which gives the same in the limit of long
records, is used where stacked rows would not fit.
"""

import math
import time

import numpy as np

from benchmarks.families.judge import judge, Verdict
from benchmarks.families.record import Record
from benchmarks.identifier import peers
from modal_core.mode import Mode
from oma_identifier.covariance import choose_references

Preset = tuple[int, int]
PRESETS: tuple[Preset, ...] = ((20, 40), (30, 60), (40, 80))
"""Block rows and highest order."""
SELECTION = 'hier_avg'
MOST_REFERENCES = 6
MOST_BYTES = 400_000_000
"""Of its stacked rows."""


def name_of(preset: Preset) -> str:
    """Name a preset as the table does."""
    return 'pyOMA2 {} rows, order {}'.format(*preset)


def peer(record: Record, preset: Preset) -> Verdict:
    """Identify the record; an error of the library finds nothing."""
    start = time.process_time()
    failed = ''
    try:
        modes = _modes(record, *preset)
    except Exception as error:  # noqa: BLE001 - whatever the library raises
        modes, failed = [], f'{type(error).__name__}: {error}'
    verdict = judge(modes, (), record)
    verdict.cpu_s, verdict.failed = time.process_time() - start, failed
    return verdict


def _modes(record: Record, block_rows: int, order: int) -> list[Mode]:
    from pyoma2.algorithms import SSI
    from pyoma2.algorithms.data.run_params import Clustering
    from pyoma2.setup import SingleSetup

    n_own = record.acceleration.shape[1]
    rows = record.acceleration - record.acceleration.mean(axis=0)
    if rows.shape[1] == 1:
        # Its selection asks for phases between channels.
        rows = np.repeat(rows, 2, axis=1)
    n_samples, n_channels = rows.shape
    n_references = min(MOST_REFERENCES, n_channels)
    # An order needs as many rows.
    block_rows = max(block_rows, math.ceil(order / n_channels) + 1)
    stacked = 8 * n_samples * block_rows * (n_channels + n_references)
    algorithm = SSI(
        name='peer',
        method='cov' if stacked < MOST_BYTES else 'cov_R',
        br=block_rows,
        ordmin=0,
        ordmax=order,
        step=2,
        ref_ind=[int(row) for row in choose_references(rows[:10_000], n_references)],
    )
    peers.run_pyoma2(SingleSetup(rows, fs=record.rate_hz), algorithm)
    with peers.quiet():
        algorithm.add_clustering(Clustering(name=SELECTION, quick=SELECTION))
        algorithm.run_clustering(SELECTION)
    result = algorithm.result.clustering_results[SELECTION]
    if not np.size(result.Fn):
        return []
    shapes = np.reshape(result.Phi, (n_channels, -1)).T
    values = zip(np.ravel(result.Fn), np.ravel(result.Xi), shapes, strict=True)
    return [
        Mode(float(f), float(z), np.asarray(shape, dtype=complex)[:n_own])
        for f, z, shape in values
    ]
