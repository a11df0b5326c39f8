"""What a plan says of itself is what a person releases: it does no more than that."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from excitation_planner.plan import sealed
from excitation_planner.planner import plan_excitation
from excitation_planner.request import PlanRequest
from modal_core.errors import PlanError
from robot_bridge.bridge import Bridge
from robot_bridge.bridge_settings import PARAMETERS, settings_from
from robot_bridge.operator import FlowState
from structural_model.robot_files import load_layout


@pytest.fixture
def bridge(model, drivers, tmp_path):
    values = {item.name: item.default for item in PARAMETERS}
    values |= {'port': drivers.free_port(), 'rapid_file': str(tmp_path / 'plan.mod')}

    made = []

    def make(**changes):
        settings = settings_from({**values, **changes}, tmp_path / 'log.mcap')
        made.append(Bridge(settings, model, lambda *_: None, lambda *_: None))
        return made[-1]

    yield make
    for item in made:
        item.close()


@pytest.mark.parametrize(
    'name', ['peak_point_speed', 'peak_velocity', 'peak_acceleration', 'position_range']
)
def test_a_plan_that_does_more_than_it_states_is_refused(bridge, plan, name):
    made = bridge()
    for factor in (0.5, 0.99):
        stated = getattr(plan, name) * factor
        false = sealed(replace(plan, **{name: stated}))
        with pytest.raises(PlanError, match=f'{name}: plan goes beyond what it states'):
            made.take(false)
        assert made.flow.path is None and made.flow.state == FlowState.DISCONNECTED
    assert 'checked' in made.take(plan)


@pytest.mark.parametrize('seed', range(3))
def test_plans_of_moves_are_taken_as_they_are_stated(bridge, model, seed):
    start = tuple(model.pose('P1').tolist())
    pulses = PlanRequest(
        seed=seed,
        signal='random_pulses',
        duration_s=4.0,
        start_position=start,
        require_full_rank=False,
    )
    there = model.to_serial(np.radians([8.0, 45, -10, 90, -90, 20.0 + seed]))
    approach = PlanRequest(
        signal='approach', approach_from=tuple(there.tolist()), start_position=start
    )
    made = bridge(method='rapid')
    for request in (pulses, approach):
        layout = load_layout('irb6660_205_190', 'sensors') if request is pulses else None
        assert 'written' in made.take(plan_excitation(model, layout, request))
    assert Path(made.settings.backend.rapid_file).exists()
