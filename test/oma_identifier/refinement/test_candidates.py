"""Modes that no pole shows well enough, and that the likelihood finds where poles point."""

import numpy as np
import pytest

from benchmarks.families.drawing import draw
from benchmarks.families.family import FAMILIES
from benchmarks.families.judge import judge
from modal_core.channel import Channel
from modal_core.samples import Samples
from oma_identifier.identify import identify_samples

MISSED_BEFORE = [
    ('short', 340020, 15.6),
    ('short', 340123, 18.88),
    ('short', 340128, 12.12),
    ('heavy', 310024, 21.26),
]
"""Poles that scatter by 0.5 to 0.75 half-widths or by 9 times the least, or look like an edge."""


@pytest.mark.parametrize(('family', 'seed', 'hz'), MISSED_BEFORE)
def test_a_mode_whose_poles_scatter_is_found_by_the_likelihood(family, seed, hz):
    record = draw(FAMILIES[family], seed)
    channels = tuple(Channel(f'ch{i + 1}') for i in range(record.acceleration.shape[1]))
    rows = np.asarray(record.acceleration, dtype=np.float32)
    found = identify_samples(Samples(rows, record.rate_hz, channels))
    near = [mode for mode in found.modes if abs(mode.frequency_hz / hz - 1.0) < 0.05]
    assert any(mode.shape_std is not None for mode in near), found.modes.frequency_hz
    verdict = judge(tuple(found.modes), tuple(found.harmonics), record)
    assert not any(f'missed: {hz}' in note for note in verdict.notes), verdict.notes
    assert verdict.n_false == 0, verdict.notes
