"""No number in an effect's range is absurd, and no prior pulls far at what is told."""

import numpy as np
import pytest

from model_gap.campaign.explicit_damping import explicit_damping
from model_gap.cell.cell_model import CellModel
from model_gap.effects import CATALOGUE, Scene
from model_gap.fit.fit import objective
from model_gap.hypothesis import Hypothesis
from model_gap.search.search import SearchSettings

# In Hz about one seen line, or about one ripple: the range is where it was looked for.
SEEN = {('tonal_disturbance', 'frequency'), ('transmission_error', 'order')}
# As in a campaign of some minutes, relative.
TOLD_TO = 0.05


@pytest.fixture(scope='module')
def scene(robot, layout):
    cell = CellModel(explicit_damping(robot.spec), layout.channels)
    return Scene(robot, tuple(sensor.name for sensor in layout), cell, lines_hz=(23.0,))


def cost(scene, effect, number, inner):
    """Return what it costs beyond neutral when one number is somewhere."""
    at = [np.zeros(len(effect.parameters(scene))) for _ in range(2)]
    at[0][number] = inner
    here, neutral = (
        objective(1.0, Hypothesis(scene, (), (effect,), np.zeros(0), item)) for item in at
    )
    return here - neutral


def numbers(scene, kind):
    effect = kind.instances(scene)[0]
    while (more := effect.detailed()) is not None:
        effect = more
    for number, item in enumerate(effect.parameters(scene)):
        if (kind.type, item.name) not in SEEN:
            yield effect, number, item


@pytest.mark.parametrize('kind', CATALOGUE, ids=lambda kind: kind.type)
def test_no_plausible_number_costs_what_an_effect_must_gain(kind, scene):
    for effect, number, item in numbers(scene, kind):
        ends = [end for end in (item.low, item.high) if not item.log or end > 0.0]
        for end in ends:
            spent = cost(scene, effect, number, item.inner(end))
            assert spent < SearchSettings().worth_adding, (item.name, end)


@pytest.mark.parametrize('kind', CATALOGUE, ids=lambda kind: kind.type)
def test_no_prior_pulls_far_at_a_number_that_is_told(kind, scene):
    """Anywhere in its range, in deviations of what the recordings tell."""
    for effect, number, item in numbers(scene, kind):
        inside = [item.inner(end) for end in (item.low, item.high) if not item.log or end > 0.0]
        for inner in np.linspace(*inside, 41) if len(inside) == 2 else inside:
            sigma = TOLD_TO * abs(inner)
            step = 1e-3 * item.scale
            slope = [cost(scene, effect, number, inner + way) for way in (-step, step)]
            pull = (slope[1] - slope[0]) / (2.0 * step) * sigma
            assert abs(pull) < 0.2, (item.name, inner)
