"""EGM clients that others wrote, against the emulated controller; skipped where not installed.

abb_robot_client and ABBRobotEGM are the packages themselves.  abb_libegm cannot be installed
here: a client that behaves as its public source does stands for it.
"""

import importlib.util
from pathlib import Path
import subprocess
import sys
import time

import numpy as np
import pytest

from abb_emulator.cell import CellSettings, MotorSide
from abb_emulator.egm import LinkFaults, UdpClient
from abb_emulator.rapid.guidance_program import guidance_program
from benchmarks.faults.guided_arm import CYCLE_S, GUIDANCE

ROOT = Path(__file__).resolve().parents[3]
N_CYCLES = 1000
STEP_DEG = 0.5


class Guided:
    """A client in a process of its own, and the controller it guides."""

    def __init__(self, model, start_deg, port, client):
        self.run = subprocess.Popen(
            [sys.executable, '-m', f'test.support.egm_clients.{client}',
             str(port), str(N_CYCLES - 50), str(STEP_DEG)],
            stdout=subprocess.PIPE, text=True, cwd=ROOT,
        )  # fmt: skip
        self.udp = UdpClient(
            ('127.0.0.1', port), LinkFaults(np.random.default_rng(1)), '127.0.0.1'
        )
        self.motors = MotorSide(model, start_deg, self.udp, CellSettings())
        self.controller = self.motors.controller
        self.n_cycles = 0
        self.planned_deg = []
        self.start()

    def start(self):
        """Start the program that lets the sensor guide."""
        assert self.controller.start(guidance_program(self.controller, GUIDANCE, True))

    def go_on(self, cycles=1_000_000):
        """Run cycles no faster than the controller's own, at most as long as the client lives."""
        for _ in range(cycles):
            if self.run.poll() is not None:
                return
            due_s = time.monotonic() + CYCLE_S
            self.motors.cycle()
            self.planned_deg.append(self.controller.axes.planned_deg.copy())
            time.sleep(max(due_s - time.monotonic(), 0.0))

    def said(self):
        """Return what the client printed."""
        said = self.run.communicate(timeout=10.0)[0].split()
        self.udp.close()
        assert self.run.returncode == 0
        return [float(word) for word in said]


@pytest.fixture
def guided(model, start_deg, drivers):
    def begin(client, package=None):
        if package is not None and importlib.util.find_spec(package) is None:
            pytest.skip(f'{package} is not installed')
        return Guided(model, start_deg, drivers.free_port(), client)

    return begin


@pytest.mark.parametrize(
    ('client', 'package'),
    [('of_abb_robot_client', 'abb_robot_client'), ('of_abbrobotegm', 'ABBRobotEGM')],
)
def test_clients_of_others_guide_the_emulated_arm(guided, client, package):
    cell = guided(client, package)
    cell.go_on()
    heard, asked, away_deg = cell.said()
    assert heard == asked >= N_CYCLES - 50
    assert away_deg < 0.01


def test_a_client_that_behaves_as_abb_libegm_guides_by_position_and_speed(guided):
    cell = guided('like_abb_libegm')
    cell.go_on()
    heard, asked, away_deg, n_sessions, n_incomplete = cell.said()
    assert heard == asked == N_CYCLES - 50
    assert (n_sessions, n_incomplete) == (1, 0)
    # It is behind by the ramp of the session, then by a few cycles of at most 1.6 deg/s.
    assert away_deg < 0.5 * STEP_DEG


@pytest.mark.parametrize('how', ['restart_session', 'stop', 'emergency_stop', 'motors_off'])
def test_it_begins_anew_after_the_controller_stopped_or_was_restarted(guided, how):
    cell = guided('like_abb_libegm')
    cell.go_on(400)
    getattr(cell.controller, how)()
    if how != 'restart_session':
        cell.go_on(100)
        assert np.ptp(cell.planned_deg[-20:], axis=0).max() == 0.0, 'stands, whatever is sent'
        cell.controller.release_emergency_stop()
        assert cell.controller.switch_motors_on()
        cell.go_on(100)
        assert np.ptp(cell.planned_deg[-100:], axis=0).max() == 0.0, 'nothing resumes by itself'
        cell.start()
    cell.go_on()
    heard, asked, _, n_sessions, n_incomplete = cell.said()
    assert (heard, asked, n_sessions, n_incomplete) == (N_CYCLES - 50, N_CYCLES - 50, 2, 0)
    speed_deg_s = np.diff(cell.planned_deg, axis=0) / CYCLE_S
    assert np.abs(speed_deg_s).max() < 10.0, 'no jump'
