"""How far the arm still goes when a link is lost, for each way of moving it, in its own time."""

from dataclasses import replace
import math
import threading

import numpy as np
import pytest

from abb_emulator.cell import CellSettings, MotorSide
from abb_emulator.egm.guidance_law import GuidanceSettings
from abb_emulator.rapid.program_task import ProgramTask
from abb_emulator.rws.rws_server import RwsServer
from abb_emulator.rws.rws_station import Station
from benchmarks.faults.guided_arm import GUIDANCE
from excitation_planner.planner import plan_excitation
from excitation_planner.rapid.rapid import module_name, rapid_module
from excitation_planner.request import PlanRequest
from excitation_planner.signals import RANDOM_PULSES
from robot_bridge.egm.egm_command import decode_sensor
from robot_bridge.operator import FlowSettings, FlowState
from robot_bridge.rws.released_program import ReleasedProgram
from robot_bridge.rws.rws_client import RwsClient
from robot_bridge.rws.web_services import RwsAccess
from structural_model.robot_files import load_layout
from test.support.egm_loop import Loop, sine

CYCLE_S = 0.004032
HZ, AMPLITUDE_DEG = 10.0, 0.1
STILL_DEG_S = 0.05
PEAK_DEG_S = AMPLITUDE_DEG * 2.0 * math.pi * HZ


def acting(loop):
    """Return the reply the controller acts on: the newest one still waits for its next cycle."""
    return decode_sensor([packet for packet in loop.packets if packet.sent][-2].data)


@pytest.fixture
def moving():
    """Return a function that gives a guided arm at the peak of its speed reference."""
    made = []

    def start(**guidance):
        loop = Loop(replace(GUIDANCE, **guidance))
        made.append(loop)
        loop.run(20).go(sine(loop, HZ, AMPLITUDE_DEG)).run(350)
        for _ in range(200):
            if acting(loop).speed_deg_s[0] > 0.98 * PEAK_DEG_S:
                return loop
            loop.run(1)
        return pytest.fail('the peak of the speed reference never came')

    yield start
    for loop in made:
        loop.close()


def residual(planned, at):
    """Return the farthest way from a cycle on [deg] and the time to standstill [s]."""
    way = np.abs(planned[at:] - planned[at - 1]).max(axis=1)
    speed = np.abs(np.diff(planned[at - 1 :], axis=0)).max(axis=1) / CYCLE_S
    return way.max(), (np.flatnonzero(speed > STILL_DEG_S)[-1] + 1) * CYCLE_S


@pytest.mark.parametrize('comm_timeout_s', [1.0, 0.1, 0.05])
def test_a_guided_arm_runs_on_as_the_law_says_until_the_time_out(
    moving, comm_timeout_s, record_property
):
    loop = moving(comm_timeout_s=comm_timeout_s)
    loop.faults.sensor.drop = 1.0
    lost, last, place_deg = len(loop.planned), acting(loop), loop.planned[-1][0]
    loop.run(round((comm_timeout_s + 0.3) / CYCLE_S))
    found_deg, took_s = residual(np.array(loop.planned), lost)
    record_property('residual_motion_deg', round(found_deg, 3))
    record_property('standstill_after_ms', round(1e3 * took_s))
    # q' = k (p - q) + v with p and v of the last reply, then the controller's own stop.
    gain, stop_s = GUIDANCE.gain_1_s, loop.motors.controller.settings.stop_s
    speed = last.speed_deg_s[0] + gain * (last.position_deg[0] - place_deg)
    left = math.exp(-gain * comm_timeout_s)
    way_deg = speed / gain * (1.0 - left) + speed * left * stop_s / 2.0
    # The session ends within two cycles of its time.
    assert abs(found_deg - way_deg) < 2.0 * CYCLE_S * PEAK_DEG_S, (found_deg, way_deg)
    assert took_s < comm_timeout_s + stop_s + 5.0 * CYCLE_S


def test_an_abort_brings_a_guided_arm_to_rest_in_the_stop_ramp(moving, record_property):
    loop = moving()
    begun = len(loop.planned)
    loop.flow.abort('aborted by the operator')
    loop.run(120)
    found_deg, took_s = residual(np.array(loop.planned), begun)
    record_property('residual_motion_deg', round(found_deg, 3))
    record_property('standstill_after_ms', round(1e3 * took_s))
    ramp_s = loop.flow.settings.player.stop_ramp_s
    assert loop.flow.state == FlowState.ABORTED
    # Never more than at full speed for the ramp and two cycles on the way.
    assert found_deg < PEAK_DEG_S * (ramp_s + 3.0 * CYCLE_S)
    still = np.array(loop.planned)[-30:]
    assert np.ptp(still, axis=0).max() < 2e-3


def test_a_program_stopped_by_web_services_comes_to_rest_in_its_own_stop(
    model, start_deg, record_property
):
    start = tuple(model.pose('P1').tolist())
    request = PlanRequest(seed=1, signal=RANDOM_PULSES, duration_s=6.0, start_position=start)
    plan = plan_excitation(model, load_layout('irb6660_205_190', 'sensors'), request)
    motors = MotorSide(model, start_deg, None, CellSettings(), 0.0)
    controller = motors.controller
    task = ProgramTask(controller, GuidanceSettings(), np.random.default_rng(1))
    server = RwsServer(
        Station(controller, task, threading.Lock()), '127.0.0.1', 0, 'Default User', 'robotics'
    )
    try:
        client = RwsClient(RwsAccess(f'127.0.0.1:{server.port}', 'Default User', 'robotics'))
        program = ReleasedProgram(
            module_name(plan), rapid_module(plan, model), tuple(start_deg), 0.05
        )
        client.load(program)
        client.run(program)
        planned = [controller.axes.planned_deg.copy()]
        fastest = np.degrees(np.abs(plan.velocity).max())
        while len(planned) < 5000:
            motors.cycle()
            planned.append(controller.axes.planned_deg.copy())
            if np.abs(planned[-1] - planned[-2]).max() / CYCLE_S > 0.5 * fastest:
                break
        client.stop()
        asked = len(planned)
        for _ in range(200):
            motors.cycle()
            planned.append(controller.axes.planned_deg.copy())
    finally:
        server.close()
    found_deg, took_s = residual(np.array(planned), asked)
    record_property('residual_motion_deg', round(found_deg, 3))
    record_property('standstill_after_ms', round(1e3 * took_s))
    # On top of it: the time-out of what was lost, and the request on the network.
    record_property(
        'after_a_lost_heartbeat_ms', round(1e3 * (took_s + FlowSettings().heartbeat_timeout_s))
    )
    assert found_deg < 1.3 * fastest * 0.1 and took_s < 0.1 + 3.0 * CYCLE_S
    assert not controller.running
