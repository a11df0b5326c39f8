"""Ways to map modes without a model of the arm: what the literature does, one mode at a time.

Plain GPR (Nguyen, Cvitanic, Melkote 2020), a random forest (Wang 2022) and a multi-task GP
(Lei, Hou, Ding 2022) on sines and cosines of the joint angles.  Modes are numbered by frequency.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from workspace_map.regression import (
    covariance,
    evidence_of,
    most_probable_scales,
    posterior,
    Rows,
    Scales,
)

Array = NDArray[np.float64]
Predictor = Callable[[Array], Array]
"""Poses, (n, n_joints), to log f, (n, n_modes)."""


def plain_gpr(q: Array, log_f: Array, std: Array) -> Predictor:
    """Return a Gaussian process per mode."""
    each = [_process(q, log_f[:, [mode]], std[:, [mode]]) for mode in range(log_f.shape[1])]
    return lambda at: np.hstack([predictor(at) for predictor in each])


def multi_task_gp(q: Array, log_f: Array, std: Array) -> Predictor:
    """Return one process for all modes with the covariance B x k, B = w wᵀ + diag(v)."""
    return _process(q, log_f, std, shared=True)


def random_forest(q: Array, log_f: Array, std: Array) -> Predictor:
    """Return 300 trees with leaves of two poses."""
    from sklearn.ensemble import RandomForestRegressor

    found = RandomForestRegressor(300, min_samples_leaf=2, random_state=0)
    found.fit(_features(q), log_f)
    return lambda at: found.predict(_features(at))


def _features(q: Array) -> Array:
    return np.hstack([np.sin(q), np.cos(q)])


def _process(q: Array, log_f: Array, std: Array, shared: bool = False) -> Predictor:
    """Return a Gaussian process: exact, scales by marginal likelihood."""
    n_poses, n_modes = log_f.shape
    mean = log_f.mean(axis=0)
    parts = len(_parts(np.zeros(1, int), n_modes, shared))
    sizes = np.full(parts, 0.1)
    scales = Scales(np.zeros(parts), sizes, np.array([0.01]), np.ones(q.shape[1]))
    mode = np.tile(np.arange(n_modes), n_poses)
    pose = np.repeat(np.arange(n_poses), n_modes)
    rows = Rows(_parts(mode, n_modes, shared), q, pose, np.zeros_like(pose))
    residual, noise = (log_f - mean).ravel(), std.ravel()
    scales = most_probable_scales(evidence_of(rows, residual, noise, scales, 1.0), scales, 1)
    found = posterior(rows, residual, noise, scales)

    def predict(at: Array) -> Array:
        there = Rows(
            _parts(np.tile(np.arange(n_modes), len(at)), n_modes, shared),
            at,
            np.repeat(np.arange(len(at)), n_modes),
            np.zeros(len(at) * n_modes, int),
        )
        off = covariance(there, rows, scales) @ found.weight
        return mean + off.reshape(len(at), n_modes)

    return predict


def _parts(mode: Array, n_modes: int, shared: bool) -> tuple[Array, ...]:
    own = np.eye(n_modes)[mode]
    return (np.ones((len(mode), 1)), own) if shared else (own,)
