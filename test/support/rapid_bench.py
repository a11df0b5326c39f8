"""A controller without any link that runs RAPID programs."""

import numpy as np

from abb_emulator.cell import CellSettings, MotorSide
from abb_emulator.egm.guidance_law import GuidanceSettings
from abb_emulator.rapid.program_task import ProgramTask

CYCLE_S = 0.004032
SEED = 5
FRAME = """MODULE Small
  CONST jointtarget jA:=[[1,45,-10,90,-90,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  VAR speeddata v:=[100,50,5000,1000];
  VAR egmident e;
  PROC main()
    {}
  ENDPROC
ENDMODULE
"""


class Bench:
    """A controller without any link, and its task."""

    def __init__(self, model, start_deg, **settings):
        self.motors = MotorSide(model, start_deg, None, CellSettings(**settings), 0.0)
        self.controller = self.motors.controller
        self.task = ProgramTask(self.controller, GuidanceSettings(), np.random.default_rng(SEED))
        self.planned = [np.array(start_deg)]

    def cycles(self, n):
        for _ in range(n):
            self.motors.cycle()
            self.planned.append(self.controller.axes.planned_deg.copy())
        return self

    def to_the_end(self, most_s=60.0):
        for _ in range(int(most_s / CYCLE_S)):
            if not self.task.running:
                return self
            self.cycles(1)
        raise AssertionError('program does not end')
