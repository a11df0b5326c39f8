"""What was found, said in plain sentences."""

import pytest

from model_gap.report.words import sentence
from structural_model.description import KnownEffect, KnownNumber


@pytest.mark.parametrize(
    ('kind', 'name', 'value', 'said'),
    [
        ('sensor_gain', 'gain', 0.7, 'Sensor elbow reads 0.7 times what is there'),
        ('sensor_gain', 'gain', 1.3, 'Sensor elbow reads 1.3 times what is there'),
        ('sensor_delay', 'delay', -2.85e-3, 'Sensor elbow is 2.85 ms early'),
        ('sensor_delay', 'delay', 2.85e-3, 'Sensor elbow is 2.85 ms late'),
        ('command_delay', 'delay', -4.3e-3, 'All sensors show the recorded motion 4.3 ms early'),
        (
            'clock_drift',
            'rate',
            3.3e-5,
            "The sensors' clock loses 33 µs a second on that of the joint states",
        ),
        (
            'clock_drift',
            'rate',
            -2e-4,
            "The sensors' clock gains 200 µs a second on that of the joint states",
        ),
    ],
)
def test_numbers_to_either_side_are_said_right(kind, name, value, said):
    number = KnownNumber(name, value, 0.1 * abs(value), '1')
    assert sentence(KnownEffect(kind, 'sensor:elbow', '', 'layout', (number,))) == said


def test_all_places_that_explain_as_well_are_said():
    number = KnownNumber('mass', 2.04, 0.12, 'kg')
    one, two = (
        KnownEffect('payload', link, '', 'effects', (number,)) for link in ('wrist_2', 'wrist_3')
    )
    assert sentence(one, others=[two]) == (
        'Wrist 2 or wrist 3 carries +2.04 kg that the model does not have'
    )
