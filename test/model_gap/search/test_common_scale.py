"""What no motion tells: masses, springs and dampers that all are so much larger."""

import numpy as np

from model_gap.fit.linearise import tolerance_columns
from model_gap.search.search import Search
from test.support.planar_arm import planar_arm
from test.support.shaken_once import shaken_once

SEED = 61


def test_masses_springs_and_dampers_together_change_nothing(tmp_path):
    """Fits move freely along that line, and σ across it is what is known before."""
    model = planar_arm(tmp_path / 'arm')
    search = Search.begin(model, shaken_once(model, SEED))
    columns = tolerance_columns(search.nominal, search.data.fitting).astype(float)
    scale = np.zeros(len(columns))
    for number, item in enumerate(search.tolerances):
        if item.name.startswith(('stiffness of', 'damping of', 'mass of')):
            scale[number] = 0.01 / item.sigma
    assert np.count_nonzero(scale) == 9
    alone = np.linalg.norm(scale[:, None] * columns)
    assert np.linalg.norm(scale @ columns) < 1e-3 * alone, f'seed {SEED}'
