"""Messages of results: modes of the structure first, lines of machines after them."""

import numpy as np
import pytest

pytest.importorskip('rclpy')
pytest.importorskip('oma_msgs')

from modal_core.channel import Channel
from modal_core.samples import Samples
from oma_identifier.identify import identify_samples
from oma_identifier.ros_messages import modal_parameters
from oma_identifier.settings import IdentificationSettings

SEED = 5


def test_lines_follow_the_modes_and_are_marked(structure):
    made = structure([9.0, 17.0, 30.0], [0.02, 0.02, 0.02], 4, SEED)
    samples = made.simulate(np.random.default_rng(SEED), 120.0, 128.0)
    time = np.arange(len(samples.acceleration)) / 128.0
    line = np.outer(np.sin(2 * np.pi * 24.0 * time), [1.0, -0.5, 0.7, 0.2])
    channels = tuple(Channel(name) for name in 'abcd')
    result = identify_samples(
        Samples(samples.acceleration + 0.5 * line, 128.0, channels),
        IdentificationSettings(window_s=120.0),
    )
    message = modal_parameters(result, 'base', 0)
    frequencies = [mode.frequency_hz for mode in message.modes]
    assert frequencies == pytest.approx([9.0, 17.0, 30.0, 24.0], rel=0.01), f'seed {SEED}'
    assert [mode.harmonic for mode in message.modes] == [False, False, False, True]
    assert message.modes[3].damping_ratio == 0.0 and message.modes[3].id == 0
