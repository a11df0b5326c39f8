"""What gravity says of many arms, counted; needs MuJoCo (the ``bench`` environment)."""

import pytest

pytest.importorskip('mujoco')

from benchmarks.gap.at_rest import lines_of
from benchmarks.gap.rates import kinds, order
from model_gap.gravity import Fault, Kind


def encoder(joint, offset=0.03, rival=None):
    return Fault(Kind.ENCODER, joint, (1,), (offset,), 0.004, 50.0, rival)


def test_the_table_counts_who_is_blamed():
    case = {'type': 'encoder_offset', 'place': 'joint_2', 'offset': 0.035}
    unit = {'type': 'sensor_unit', 'place': 'elbow'}
    gain = Fault(Kind.GAIN, 'elbow', (0, 1, 2), (0.1,), 0.01, 50.0)
    rows = [
        ('encoder_offset', [case], (encoder('joint_2'),)),
        ('encoder_offset', [case], (encoder('joint_3', rival=encoder('joint_2')),)),
        ('encoder_offset', [case], (encoder('joint_2', 0.06),)),
        ('encoder_offset', [case], (encoder('joint_5'),)),
        ('encoder_offset', [case], ()),
        ('sensor_unit', [unit], (Fault(Kind.UNIT, 'elbow', (0, 1, 2)),)),
        ('sensor_unit', [unit], (gain,)),
        ('healthy', [], ()),
        ('sensor_gain', [{'type': 'sensor_gain', 'place': 'elbow'}], (gain,)),
        ('payload', [{'type': 'payload', 'place': 'flange'}], (encoder('joint_3'),)),
    ]
    seen = [line[1] for line in lines_of(rows)]
    assert seen == ['3 of 5', '1 of 5', '1 of 2', '1 of 2', '0 of 1', '1 of 3']


def test_a_round_has_every_campaign_once_in_a_drawn_order():
    class Options:
        only, seeds, first_seed = '', 2, 700000

    found = order(Options)
    assert len(found) == len(set(found)) == 2 * len(kinds())
    names = [kind for kind, _ in found]
    assert sorted(names[: len(kinds())]) == sorted(kinds())
    assert names[: len(kinds())] != kinds(), 'stopped early, the first kinds alone were run'
    assert order(Options) == found
