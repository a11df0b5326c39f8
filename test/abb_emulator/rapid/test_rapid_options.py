"""Every kind of exported module on every kind of controller: it runs, or a line is refused."""

from itertools import product

import numpy as np
import pytest

from abb_emulator.controller_settings import ControllerSettings, NOT_CONNECTED
from excitation_planner.planner import plan_excitation
from excitation_planner.rapid.rapid import rapid_module
from excitation_planner.rapid_options import RapidOptions
from excitation_planner.request import PlanRequest
from modal_core.errors import BridgeError
from test.support.rapid_bench import Bench

NAMES = {'tool': 'tShaker', 'load': 'lShaker', 'work_object': 'wobjCell',
         'mechanical_unit': 'ROB_7'}  # fmt: skip
CONFIGURED = {'system_data': 'tShaker,lShaker,wobjCell', 'unit': 'ROB_7', 'device': 'EgmPort'}
CHOICES = tuple(product([True, False], repeat=4))


@pytest.fixture(scope='module')
def plans(model):
    start = tuple(model.pose('P1').tolist())
    short = {'seed': 3, 'duration_s': 3.0, 'start_position': start}
    return {
        'pulses': plan_excitation(model, None, PlanRequest(signal='random_pulses', **short)),
        'noise': plan_excitation(model, None, PlanRequest(**short)),
    }


def options(stream, supervised, named, marked):
    names = {**NAMES, 'udp_device': 'EgmPort'} if named else {}
    return RapidOptions(
        stream=stream, collision_detection=supervised,
        digital_output='doAmaRun' if marked else '', **names,
    )  # fmt: skip


def bench_of(model, start_deg, **settings):
    return Bench(model, start_deg, controller=ControllerSettings(**settings))


@pytest.mark.parametrize(('stream', 'supervised', 'named', 'marked'), CHOICES)
def test_a_module_of_moves_runs_where_its_options_are(
    model, start_deg, plans, stream, supervised, named, marked
):
    text = rapid_module(plans['pulses'], model, options(stream, supervised, named, marked))
    names = CONFIGURED if named else {}
    # No more than it needs.
    bench = bench_of(
        model, start_deg, guided_motion=stream, collision_detection=supervised,
        signals='doAmaRun' if marked else '', **names,
    )  # fmt: skip
    bench.task.load(text)
    assert bench.task.start()
    marks = []
    while bench.task.running:
        bench.cycles(1)
        marks.append(bench.controller.signals.get('doAmaRun', 0.0))
    assert bench.controller.events[-1] == 'program at its end'
    moved = np.any(np.diff(bench.planned, axis=0) != 0.0, axis=1)
    assert np.count_nonzero(moved) > 50
    if marked:
        up = np.flatnonzero(np.diff([0.0, *marks]) > 0.0)
        down = np.flatnonzero(np.diff([0.0, *marks]) < 0.0)
        assert len(up) == len(down) == 1
        first, last = np.flatnonzero(moved)[[0, -1]]
        # Within a cycle before the first move; after the last until its fine point and pause.
        assert 0 <= first - up[0] <= 2
        assert last < down[0]
    missing = {
        'guided_motion': stream, 'collision_detection': supervised, 'signals': marked,
        'system_data': named, 'unit': named and stream,
    }  # fmt: skip
    has = {
        'guided_motion': stream, 'collision_detection': supervised,
        'signals': 'doAmaRun' if marked else '', **names,
    }  # fmt: skip
    without = {'guided_motion': False, 'collision_detection': False, 'signals': '',
               'system_data': 'tool0', 'unit': 'ROB_1'}  # fmt: skip
    for what, needed in missing.items():
        other = bench_of(model, start_deg, **{**has, what: without[what]})
        if not needed:
            other.task.load(text)
            continue
        with pytest.raises(BridgeError, match='line') as caught:
            other.task.load(text)
        assert len(str(caught.value).splitlines()) == 1
        assert other.task.module is None, 'nothing is loaded'


def test_guidance_without_the_option_is_refused_by_its_line(model, start_deg, plans):
    text = rapid_module(plans['noise'], model)
    for settings in ({'guided_motion': False}, {'collision_detection': False}):
        with pytest.raises(BridgeError, match='line') as caught:
            bench_of(model, start_deg, **settings).task.load(text)
        line = int(str(caught.value).split('line ')[1].split(':')[0].split()[0])
        found = text.splitlines()[line - 1].lower()
        assert 'egm' in found or 'motionsup' in found


def test_an_unknown_device_ends_the_program_by_its_handler(model, start_deg, plans):
    text = rapid_module(plans['pulses'], model, RapidOptions(udp_device='Elsewhere'))
    bench = bench_of(model, start_deg)
    bench.task.load(text)
    bench.task.start()
    bench.to_the_end()
    assert any('Self-excitation stopped' in event for event in bench.controller.events)
    assert np.all(np.array(bench.planned) == bench.planned[0])


TRACK = (1200.0, *(NOT_CONNECTED,) * 5)


@pytest.mark.parametrize('place', [0.0, 1200.0, -37.5])
def test_external_axes_keep_their_places(model, start_deg, plans, place):
    bench = bench_of(model, start_deg, external=(place, 45.0, *(NOT_CONNECTED,) * 4))
    bench.task.load(rapid_module(plans['pulses'], model))
    bench.task.start()
    bench.to_the_end()
    assert bench.controller.events[-1] == 'program at its end'
    moved = np.any(np.diff(bench.planned, axis=0) != 0.0, axis=1)
    assert np.count_nonzero(moved) > 50


def test_a_track_that_was_jogged_meanwhile_stops_the_program(model, start_deg, plans):
    bench = bench_of(model, start_deg, external=TRACK)
    bench.task.load(rapid_module(plans['pulses'], model))
    bench.task.start()
    bench.cycles(600)
    bench.task.stop()
    bench.cycles(100)
    bench.controller.external = (1300.0, *TRACK[1:])
    bench.task.start()
    bench.to_the_end()
    assert any('nothing moves' in event for event in bench.controller.events)


def test_a_target_without_a_place_for_a_track_is_an_error_of_the_controller(model, start_deg):
    from test.support.rapid_bench import FRAME

    bench = bench_of(model, start_deg, external=TRACK)
    bench.task.load(FRAME.format('MoveAbsJ jA\\NoEOffs,v50,fine,tool0;'))
    bench.task.start()
    bench.cycles(5)
    assert any('external axis' in event for event in bench.controller.events)
    assert np.all(np.array(bench.planned) == bench.planned[0])
