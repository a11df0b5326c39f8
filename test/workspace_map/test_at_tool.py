"""Predicted modes in the vocabulary of every room."""

import numpy as np

from workspace_map import PredictedModes, receptance, tool_modes

SEED = 7


def test_response_and_covariance_are_those_of_the_prediction():
    print('seed', SEED)
    rng, n = np.random.default_rng(SEED), 3
    root = 0.02 * rng.standard_normal((5 * n, 5 * n))
    predicted = PredictedModes(
        np.zeros(6), np.array([9.0, 12.0, 30.0]), np.array([0.02, 0.03, 0.025]),
        rng.standard_normal((3, n)), np.zeros((0, n)), root @ root.T, np.zeros((3, 3)),
    )  # fmt: skip
    modes, lines = tool_modes(predicted), np.array([8.0, 11.0, 29.0])
    assert np.allclose(modes.receptance(lines), receptance(predicted, lines))
    std = np.sqrt(np.diag(modes.covariance)).reshape(n, 5)
    assert np.allclose(std[:, 0], predicted.frequency_std_hz / predicted.frequency_hz)
    assert np.allclose(std[:, 1], predicted.damping_ratio_std / predicted.damping_ratio)
    assert np.allclose(std[:, 2:], predicted.tool_shape_std.T)
