"""Rates of verdicts, counted from campaigns whose answer is known."""

import json

import numpy as np
import pytest

from benchmarks.gap.counts import counted, interval, OUTSIDE, right_place, wrong_and_sure
from benchmarks.gap.multibody.hidden import draw, KINDS, plain
from model_gap.effects import CATALOGUE

PLAY = {'type': 'backlash', 'place': 'joint_1', 'half': 5e-5}
GAIN = {'type': 'sensor_gain', 'place': 'elbow', 'gain': 1.2}


def found(kind, location, **numbers):
    parameters = {
        name: {'value': value, 'sigma': sigma, 'unit': '1'}
        for name, (value, sigma) in numbers.items()
    }
    return {'type': kind, 'location': location, 'parameters': parameters}


def row(kind, truth, verdict, *effects):
    return {'kind': kind, 'seed': 0, 'truth': truth, 'verdict': verdict, 'found': list(effects)}


def test_almost_all_of_the_catalogue_is_hidden():
    """A sensor is not seen below the mass of a tool; a slow drift is of whole campaigns."""
    names = {effect.type for effect in CATALOGUE}
    assert names - set(KINDS) <= {'sensor_mass', 'stiffness_drift'}
    assert {'clipping', 'knocks', 'lopsided_spring'} <= set(OUTSIDE)


@pytest.mark.parametrize('kind', sorted(KINDS))
def test_a_case_is_kept_as_it_was_drawn(kind):
    """Also those with places and directions (seeds 0 to 4)."""
    for seed in range(5):
        case = draw(kind, np.random.default_rng(seed), ('frame', 'elbow'))
        assert json.loads(json.dumps(plain(case)))['type'] == kind


def test_place_of_a_sensor_is_its_name():
    right = row('sensor_gain', [GAIN], 'named', found('sensor_gain', 'sensor:elbow'))
    wrong = row('sensor_gain', [GAIN], 'named', found('sensor_gain', 'sensor:frame'))
    assert right_place(right) and not wrong_and_sure(right)
    assert not right_place(wrong) and wrong_and_sure(wrong)


def test_doubt_is_not_wrong_and_sure():
    assert not wrong_and_sure(row('backlash', [PLAY], 'ambiguous', found('payload', 'flange')))
    assert wrong_and_sure(row('backlash', [PLAY], 'named', found('payload', 'flange')))
    more = found('sensor_rotation', 'sensor:elbow')
    beside = row('backlash', [PLAY], 'named', found('backlash', 'joint_1'), more)
    assert wrong_and_sure(beside)


def test_table_counts_every_kind_in_its_row():
    known, far = found('backlash', 'joint_1', half_gap=(5.1e-5, 1e-6)), (1.3, 0.01)
    rows = [
        row('backlash', [PLAY], 'named', known),
        row('backlash', [PLAY], 'unexplained'),
        row('healthy', [], 'none'),
        row('healthy', [], 'named', found('sensor_rotation', 'sensor:elbow')),
        row('clipping', [{'type': 'clipping', 'place': None}], 'unexplained'),
        row('pair', [PLAY, GAIN], 'ambiguous', found('sensor_gain', 'sensor:elbow', gain=far)),
        row('rough', [PLAY], 'named', known),
    ]
    seen = {line[0]: line[1] for line in counted(rows)}
    assert seen['single effects, right type'] == '1 of 2'
    assert seen['single effects, wrong and sure'] == '0 of 2'
    assert seen['pairs, both found'] == '0 of 1'
    assert seen['pairs, both, or one named and the rest admitted'] == '1 of 1'
    assert next(value for name, value in seen.items() if name.startswith('healthy')) == '1 of 2'
    assert seen['outside the catalogue, not named'] == '1 of 1'
    assert seen['parameter within 2σ'] == '2 of 3'
    assert seen['models ±40 %, one effect: right type'] == '1 of 1'


@pytest.mark.parametrize(
    ('seen', 'count', 'low', 'high'),
    [(0, 10, 0.0, 0.3085), (10, 10, 0.6915, 1.0), (1, 2, 0.0126, 0.9874)],
)
def test_intervals_are_those_of_the_tables(seen, count, low, high):
    """Clopper and Pearson (1934): by hand, 1 - 0.025^(1/n) and its mirror."""
    assert interval(seen, count) == pytest.approx((low, high), abs=1e-4)
