"""True modes of a path, beside which the demo puts what it found."""

import numpy as np

from autonomous_modal_analysis.demos.demonstration import mean_of, TrueModes


def _truth(frequency_hz, order, angle):
    return TrueModes(
        frequency_hz=np.array(frequency_hz),
        damping_ratio=np.array([0.01, 0.02])[order],
        shapes=np.eye(2, dtype=complex)[:, order],
        channel_names=('a', 'b'),
        position=np.array([angle]),
    )


def test_modes_of_a_path_are_followed_by_shape_and_averaged():
    # The second mode falls below the first at the last pose.
    path = [_truth([10.0, 10.4], [0, 1], 0.0), _truth([10.1, 10.3], [0, 1], 0.1)]
    path.append(_truth([9.9, 10.2], [1, 0], 0.2))
    mean = mean_of(path)
    np.testing.assert_allclose(mean.frequency_hz, [10.1, 10.2])
    np.testing.assert_allclose(mean.damping_ratio, [0.01, 0.02])
    assert mean.position == 0.1 and np.array_equal(mean.shapes, np.eye(2))
