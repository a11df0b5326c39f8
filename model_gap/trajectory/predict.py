"""What fitted laws predict of a recording, one that took no part included."""

import numpy as np

from model_gap.trajectory.fit import Fit
from model_gap.trajectory.problem import Layout
from model_gap.trajectory.term import Array, Track


def predicted(track: Track, layout: Layout, fit: Fit) -> Array:
    """Return what laws add to the model's prediction along a recording, (n, n_rows).

    Where friction stood when the recording began no model can know: that state is fitted, one
    number per axis, which acts until the axis has turned by its presliding angle.

    Parameters
    ----------
    track : Track
        The recording.
    layout : Layout
        Of the terms.
    fit : Fit
        Their weights.
    """
    sum_of = np.zeros_like(track.left(layout.terms[0].quantity))
    local, scale = [], []
    for item in fit.chosen:
        term = layout.terms[item]
        sum_of += term.columns(track) @ fit.of(layout, item)[0]
        columns = term.local_columns(track)
        local.append(columns)
        scale += [term.local_scale()] * columns.shape[2]
    if not scale:
        return sum_of
    columns = np.concatenate(local, axis=2)
    left = track.left(layout.terms[0].quantity) - sum_of
    # Samples agree with their neighbours: together they weigh as ten would.
    spread = np.sqrt(fit.variance * len(left) / 10.0)
    rows = (columns / spread[:, np.newaxis]).reshape(-1, columns.shape[2]) * np.array(scale)
    right = (left / spread).ravel()
    state = np.linalg.solve(rows.T @ rows + np.eye(len(scale)), rows.T @ right)
    return np.asarray(sum_of + columns @ (state * np.array(scale)))
