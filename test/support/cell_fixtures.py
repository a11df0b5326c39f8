"""Fixtures of bridge and emulator: a peer, processes of nodes, an operator, a short plan."""

import numpy as np
import pytest

from test.support import strict_peer
from test.support.domains import ros_domain
from test.support.web_controller import WebController

__all__ = [
    'domain',
    'drivers',
    'message',
    'model',
    'operator',
    'peers',
    'plan',
    'plan_of_pulses',
    'processes',
    'pulses',
    'start_deg',
    'web',
]


@pytest.fixture(scope='session')
def peers():
    """Return the module of the independent controller."""
    return strict_peer


@pytest.fixture(scope='session')
def model():
    from structural_model import load_robot

    return load_robot('irb6660_205_190')


@pytest.fixture(scope='session')
def start_deg(model):
    """Return the controller angles of the pose every test starts at, (6,) [deg]."""
    return np.degrees(model.to_controller(model.pose('P1')))


def short_plan(model, signal):
    from excitation_planner.planner import plan_excitation
    from excitation_planner.request import PlanRequest
    from structural_model.robot_files import load_layout

    layout = load_layout('irb6660_205_190', 'sensors')
    start = tuple(model.pose('P1').tolist())
    request = PlanRequest(seed=1, signal=signal, duration_s=6.0, start_position=start)
    return plan_excitation(model, layout, request)


@pytest.fixture(scope='session')
def plan(model):
    """Return a short plan for guidance; seed 1."""
    return short_plan(model, 'band_limited_noise')


@pytest.fixture(scope='session')
def plan_of_pulses(model):
    """Return a short plan of moves; seed 1."""
    return short_plan(model, 'random_pulses')


@pytest.fixture(scope='session')
def pulses(plan_of_pulses, drivers):
    """Return a short plan of moves as the planner publishes it; seed 1."""
    from excitation_planner.ros_messages import plan_to_message

    return plan_to_message(plan_of_pulses)


@pytest.fixture(scope='session')
def drivers():
    """Return the module with the operator and the node processes."""
    pytest.importorskip('rclpy')
    pytest.importorskip('oma_msgs')
    from test.support import operator_driver

    return operator_driver


@pytest.fixture(scope='session')
def message(plan, drivers):
    """Return the plan as the planner publishes it."""
    from excitation_planner.ros_messages import plan_to_message

    return plan_to_message(plan)


@pytest.fixture(scope='module')
def domain(request):
    """Return a ROS domain of this test file in this process."""
    return ros_domain(7 * len(request.module.__name__))


@pytest.fixture(scope='module')
def operator(drivers, domain):
    context = drivers.context_of(domain)
    made = drivers.Operator(context)
    yield made
    made.close()
    context.try_shutdown()


@pytest.fixture(scope='module')
def processes(drivers, domain):
    """Return a function that starts a node as a process; all are stopped at the end."""
    running = []

    def start(name, **parameters):
        running.append(drivers.NodeProcess(name, domain, **parameters))
        return running[-1]

    yield start
    for process in running:
        if process.process.poll() is None:
            process.stop()


@pytest.fixture
def web():
    """Return a function that starts a controller's web services; all are closed at the end."""
    made = []

    def start(**options):
        made.append(WebController(**options))
        return made[-1]

    yield start
    for item in made:
        item.close()
