"""Messages of results: modes of the structure first, lines of machines after them."""

import numpy as np
import pytest

pytest.importorskip('rclpy')
pytest.importorskip('oma_msgs')

from autonomous_modal_analysis.identified.results import mode_json
from autonomous_modal_analysis.views.message_view_node import message_mode_json
from modal_core.channel import Channel
from modal_core.mode import Mode, MODE_KEYS
from modal_core.quality import ChannelQuality, DataQuality
from modal_core.samples import Samples
from oma_identifier.identify import identify_samples
from oma_identifier.node.ros_messages import modal_parameters, mode_message, quality_message
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


def test_deviations_of_shapes_are_sent_and_empty_where_there_are_none():
    shape, std = np.array([1.0, 0.5 - 0.1j]), np.array([0.0, 0.02 + 0.03j])
    sent = mode_message(Mode(9.0, 0.02, shape, shape_std=std, mac_loss=1e-3, mac_loss_std=5e-4))
    assert list(sent.shape_std_real) == [0.0, 0.02] and list(sent.shape_std_imag) == [0.0, 0.03]
    assert (sent.mac_loss, sent.mac_loss_std) == (1e-3, 5e-4)
    without = mode_message(Mode(9.0, 0.02, shape))
    assert len(without.shape_std_real) == len(without.shape_std_imag) == 0
    assert np.isnan(without.mac_loss) and np.isnan(without.mac_loss_std)


def test_kurtosis_and_noise_of_channels_are_sent():
    known = ChannelQuality('a', kurtosis=2.9, noise_rms=0.01)
    sent = quality_message(DataQuality(channels=(known, ChannelQuality('b'))), 0).channels
    assert (sent[0].kurtosis, sent[0].noise_rms) == (2.9, 0.01)
    assert np.isnan(sent[1].kurtosis) and np.isnan(sent[1].noise_rms)


def test_a_mode_and_its_message_have_the_same_fields_in_the_same_order():
    line = Mode(24.0, 0.0, np.array([0.3j, 1.0]), id=3, harmonic=True)
    known = Mode(9, 0.02, np.ones(2), shape_std=np.array([0.0, 0.1j]))
    assert list(MODE_KEYS) == list(mode_message(line).get_fields_and_field_types())
    for mode in (line, known):
        assert message_mode_json(mode_message(mode)) == mode_json(mode)
