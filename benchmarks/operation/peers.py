"""What pyOMA2 and koma make of the same records: SSI-cov and their own automatic selection."""

import math

import numpy as np
from numpy.typing import NDArray

from benchmarks.identifier import peers
from modal_core.mode import Mode
from modal_core.samples import Samples
from oma_identifier.covariance import choose_references

Rows = NDArray[np.float64]
ORDERS = 60
PYOMA2_ROWS, KOMA_ROWS = 30, 30
N_REFERENCES = 6
PYOMA2_SELECTION = 'hier_avg'
KOMA_STABLE = {'freq': 0.02, 'damping': 0.1, 'mac': 0.05}
KOMA_FEWEST = 8
"""Poles of a cluster, of thirty orders; twenty is the default, of more orders."""


def pyoma2_modes(samples: Samples) -> list[Mode]:
    """Return the modes of pyOMA2: SSI-cov, 30 block rows, order 60, hierarchical clusters."""
    from pyoma2.algorithms import SSI
    from pyoma2.algorithms.data.run_params import Clustering
    from pyoma2.setup import SingleSetup

    rows = _centred(samples)
    references = choose_references(rows[:10_000], min(N_REFERENCES, rows.shape[1]))
    algorithm = SSI(
        name='peer',
        method='cov',
        br=max(PYOMA2_ROWS, math.ceil(ORDERS / rows.shape[1]) + 1),
        ordmin=0,
        ordmax=ORDERS,
        step=2,
        ref_ind=[int(row) for row in references],
    )
    peers.run_pyoma2(SingleSetup(rows, fs=samples.sample_rate_hz), algorithm)
    with peers.quiet():
        algorithm.add_clustering(Clustering(name=PYOMA2_SELECTION, quick=PYOMA2_SELECTION))
        algorithm.run_clustering(PYOMA2_SELECTION)
    result = algorithm.result.clustering_results[PYOMA2_SELECTION]
    if not np.size(result.Fn):
        return []
    shapes = np.reshape(result.Phi, (rows.shape[1], -1)).T
    values = zip(np.ravel(result.Fn), np.ravel(result.Xi), shapes, strict=True)
    return [Mode(float(f), float(z), np.asarray(shape, complex)) for f, z, shape in values]


def koma_modes(samples: Samples) -> list[Mode]:
    """Return the modes of koma: SSI-cov, 30 block rows, stable poles, HDBSCAN clusters."""
    from koma.clustering import group_clusters, PoleClusterer
    from koma.oma import covssi, find_stable_poles

    rows = _centred(samples)
    orders = np.arange(2, ORDERS + 2, 2)
    with peers.quiet():
        poles, shapes, of_order = covssi(
            rows, samples.sample_rate_hz, KOMA_ROWS, orders, showinfo=False
        )
        stable = find_stable_poles(poles, shapes, of_order, 2, stabcrit=KOMA_STABLE)
        if len(stable[0]) < KOMA_FEWEST:
            return []
        clusterer = PoleClusterer(*stable[:3], KOMA_FEWEST, KOMA_FEWEST)
        chosen = clusterer.postprocess(prob_threshold=0.5)
        if not len(chosen[0]):
            return []
        zeta, omega, vectors, *_ = group_clusters(*chosen)
    return [
        Mode(float(np.mean(w)) / (2.0 * math.pi), float(np.mean(z)), _mean_shape(v))
        for z, w, v in zip(zeta, omega, vectors, strict=True)
    ]


def _mean_shape(vectors: NDArray[np.complex128]) -> NDArray[np.complex128]:
    """Return the first principal direction of a cluster's shapes, (n_channels,)."""
    unit = vectors / np.linalg.norm(vectors, axis=0)
    return np.asarray(np.linalg.svd(unit)[0][:, 0])


def _centred(samples: Samples) -> Rows:
    rows = samples.widened()
    return np.asarray(rows - rows.mean(axis=0))
