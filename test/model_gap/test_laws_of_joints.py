"""A joint that slips or runs into a stop is told from friction, play and a hard spring."""

import pytest

from model_gap.campaign.read_campaign import read_campaign
from model_gap.decide.decide import Verdict
from model_gap.effects.backlash import Backlash
from model_gap.effects.coulomb_friction import CoulombFriction
from model_gap.effects.cubic_damping import CubicDamping
from model_gap.effects.cubic_stiffness import CubicStiffness
from model_gap.effects.end_stop import EndStop
from model_gap.effects.hysteresis import Hysteresis
from model_gap.effects.joint_damping import JointDamping
from model_gap.effects.joint_stiffness import JointStiffness
from model_gap.find_gap import find_gap
from model_gap.gap_json import accepted_effects
from model_gap.search.search import SearchSettings
from test.model_gap.conftest import ROBOT
from test.support.cell_campaign import cell_campaign
from test.support.hidden_campaign import SENSORS
from test.support.write_campaign import write_campaign

SEED = 507
LAWS = (
    JointStiffness, JointDamping, CoulombFriction, Backlash, CubicStiffness, Hysteresis, EndStop,
    CubicDamping,
)  # fmt: skip
HIDDEN = {
    'hysteresis': ({'share': 0.35, 'limit': 5e-5}, 'share', 0.35),
    'end_stop': ({'gap': 1e-4, 'k': 8e6}, 'gap', 1e-4),
}


@pytest.mark.slow
@pytest.mark.parametrize('kind', HIDDEN)
def test_a_law_is_named_with_its_numbers(kind, robot, tmp_path):
    numbers, name, true = HIDDEN[kind]
    hidden = {'type': kind, 'joint': 'joint_1', **numbers}
    records = cell_campaign(ROBOT, SEED, effects=[hidden], n_fit=2, n_held=1, duration=8.0)
    write_campaign(tmp_path, records, robot.joint_names, SENSORS)
    settings = SearchSettings(catalogue=LAWS, most_effects=1)
    result = find_gap(robot, read_campaign(tmp_path, robot), settings)
    assert result.decision.verdict is Verdict.NAMED, f'seed {SEED}: {result.decision}'
    (effect,) = accepted_effects(result)
    assert (effect.type, effect.location) == (kind, 'joint_1'), f'seed {SEED}'
    found = next(item for item in effect.parameters if item.name == name)
    assert abs(found.value - true) < 4.0 * found.sigma, f'seed {SEED}: {found}'
