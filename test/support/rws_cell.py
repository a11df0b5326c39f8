"""Web services of an emulated controller whose cycles run while the test looks on."""

import threading
import time

import numpy as np

from abb_emulator.cell import CellSettings, MotorSide
from abb_emulator.egm.guidance_law import GuidanceSettings
from abb_emulator.rapid.program_task import ProgramTask
from abb_emulator.rws.rws_server import RwsServer
from abb_emulator.rws.rws_station import Station

USER, PASSWORD = 'Default User', 'robotics'
MODULE = """MODULE Small
  PERS num nCount:=3;
  CONST jointtarget jA:=[[0.5,45,-10,90,-90,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  PROC main()
    MoveAbsJ jA\\NoEOffs,v50,fine,tool0;
    WaitTime 0.5;
  ENDPROC
ENDMODULE
"""


class RwsCell:
    """An emulated controller; ``servers`` by version, one account."""

    def __init__(self, model, start_deg, versions=(1,), password=PASSWORD):
        self.motors = MotorSide(model, start_deg, None, CellSettings(), 0.0)
        self.controller = self.motors.controller
        self.lock = threading.Lock()
        self.task = ProgramTask(self.controller, GuidanceSettings(), np.random.default_rng(1))
        self.station = Station(self.controller, self.task, self.lock)
        self.servers = {
            version: RwsServer(self.station, '127.0.0.1', 0, USER, password, version)
            for version in versions
        }
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)

    def address(self, version=1):
        return f'127.0.0.1:{self.servers[version].port}'

    def run(self):
        """Let the cycles run from now on, about in real time."""
        self._thread.start()
        return self

    def _run(self):
        while not self._closing.is_set():
            with self.lock:
                self.motors.cycle()
            time.sleep(0.004)

    def close(self):
        self._closing.set()
        for server in self.servers.values():
            server.close()
