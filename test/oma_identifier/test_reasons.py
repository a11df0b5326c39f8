"""What is turned down says so in one line each, with the value that decided: `ama -v`."""

import logging
import re

import numpy as np

from modal_core.channel import Channel
from modal_core.poles import PoleStatus
from modal_core.samples import Samples
from oma_identifier.identify import identify_samples

PLACE = re.compile(r'^([0-9.e+]+) Hz: (.+)$')


def of_building(rows):
    return Samples(rows, 100.0, tuple(Channel(f'ch{column}') for column in range(rows.shape[1])))


def test_every_pole_of_a_building_that_is_turned_down_is_told_with_its_value(data_path, caplog):
    rows = np.load(data_path('palisaden_clt_building', 'Palisaden_dataset.npy'))[:20_000]
    with caplog.at_level(logging.DEBUG, logger='oma_identifier'):
        result = identify_samples(of_building(rows))
    assert len(result.modes)
    told = [match.groups() for line in caplog.messages if (match := PLACE.match(line))]
    places = np.array([float(place) for place, _ in told])
    status = result.poles.status
    turned_down = np.isin(
        status, [PoleStatus.UNCERTAIN, PoleStatus.SMALL_CLUSTER, PoleStatus.COMPLEX_SHAPE]
    )
    assert turned_down.any()
    for frequency_hz in result.poles.frequency_hz[turned_down]:
        assert np.min(np.abs(places / frequency_hz - 1.0)) < 0.1, frequency_hz
    # Each says by how much, or what it is instead.
    by_selection = [why for _, why in told if 'model orders' in why]
    assert by_selection and all(re.search(r'\d', why) for why in by_selection)


def test_nothing_is_told_unless_asked(data_path, caplog):
    rows = np.load(data_path('palisaden_clt_building', 'Palisaden_dataset.npy'))[:4_000]
    with caplog.at_level(logging.INFO):
        identify_samples(of_building(rows))
    assert not caplog.messages
