"""A tool is not a ball: it turns harder about one axis than about another."""

import numpy as np
import pytest

from model_gap.campaign.explicit_damping import explicit_damping
from model_gap.cell.cell_model import CellModel
from model_gap.effects import Scene
from model_gap.effects.payload import Payload
from model_gap.effects.tuned_mass import TunedMass
from model_gap.fit import fit
from model_gap.search.search import Search, SearchSettings

SEED = 799530
CENTRE = (0.2, -0.07, 0.0)
POSE = np.array([0.4, 0.3, -0.2, 0.5, -0.7, 0.1])
TOOL = {
    'type': 'payload', 'link': 'flange', 'mass': 40.0, 'com': CENTRE,
    'gyration': (0.13, 0.06, 0.1),
}  # fmt: skip


@pytest.mark.slow
def test_a_centre_of_mass_does_not_move_to_make_up_for_inertia(robot, campaign_of):
    """With one radius for all axes it is over three deviations off, with three below 2.5."""
    campaign = campaign_of([TOOL], SEED, n_fit=3, n_held=0, duration=16.0)
    search = Search.begin(robot, campaign, SearchSettings(), simulated=True)
    start = search.nominal.with_effect(Payload('flange'), (40.0, *CENTRE, 0.1))
    ball = fit(start, search.data.fitting, relinearise=2)
    tool = fit(ball.hypothesis.with_details(), search.data.fitting, relinearise=2)
    off = [
        np.abs(np.subtract(it.hypothesis.values()[0][1:4], CENTRE))
        / np.sqrt(np.diag(it.covariance)[1:4])
        for it in (ball, tool)
    ]
    assert max(off[0]) > 3.0, f'seed {SEED}: {off[0]}'
    assert max(off[1]) < 2.5, f'seed {SEED}: {off[1]}'
    assert tool.log_evidence > ball.log_evidence, f'seed {SEED}'


@pytest.mark.parametrize('link', ['link_4', 'link_6'])
def test_what_swings_fast_is_what_is_fixed_there(link, robot, layout):
    """The simpler effect is the limit of a swinging mass, wherever a body has its name from."""
    cell = CellModel(explicit_damping(robot.spec), layout.channels)
    scene = Scene(robot, tuple(sensor.name for sensor in layout), cell)
    values = (20.0, 5e3, 0.05, 0.1, 0.07, -0.03, 0.2, 0.1)
    swinging = TunedMass(link, 'x', details=True)
    fixed, (mass, x, y, z, _, *rest) = swinging.simpler(values, scene)
    assert fixed.location == ('flange' if link == 'link_6' else link)
    point = fixed.apply(cell, (mass, x, y, z, 0.0, *rest), scene)
    count = 8
    one, two, bare = (
        robot.replace(item.spec).modes(POSE).frequency_hz[:count]
        for item in (swinging.apply(cell, values, scene), point, cell)
    )
    assert np.abs(two - bare).max() > 0.1
    np.testing.assert_allclose(one, two, rtol=1e-5)
