"""Gravity tells a wrong unit or gain; sensors without a constant part are left in peace."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from modal_core.measurements import StampedSamples
from oma_identifier.intake.sample_buffer import SampleBuffer
from oma_identifier.settings import IdentificationSettings

START = 1_700_000_000_000_000_000


def flags_of(constant, seed):
    rng = np.random.default_rng(seed)
    turned = Rotation.random(random_state=seed).apply(constant)
    data = turned + 0.2 * rng.standard_normal((2000, 3))
    stamps = START + np.arange(2000, dtype=np.int64) * 10_000_000
    buffer = SampleBuffer(IdentificationSettings(window_s=10.0))
    buffer.add(StampedSamples('/imu/elbow', 'link_3', stamps, data))
    window = next(iter([*buffer.windows(), *buffer.finish()]))
    assert window.quality.identifiable and not any(c.excluded for c in window.quality.channels)
    return [set(channel.flags) for channel in window.quality.channels]


@pytest.mark.parametrize('seed', range(5))
@pytest.mark.parametrize(
    ('length', 'flag'),
    [
        (9.81, None),
        (9.6, None),
        (0.0, None),
        # The offset of an amplifier, or of a plain sensor.
        (0.5, None),
        (2.0, None),
        (7.8, None),
        (12.0, None),
        (1.0, 'unit_g_suspicion'),
        (19.6, 'gravity_suspicion'),
        (4.9, 'gravity_suspicion'),
    ],
)
def test_gravity_of_any_direction(length, flag, seed):
    for found in flags_of([0.0, 0.0, length], seed):
        suspicions = {item for item in found if item.endswith('suspicion')}
        assert suspicions == ({flag} if flag else set()), f'seed {seed}'
