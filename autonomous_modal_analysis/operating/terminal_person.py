"""The person at this terminal."""

import sys

from rich.markup import escape

from autonomous_modal_analysis.console.terminal import MESSAGES
from autonomous_modal_analysis.views.plan_view import show_plan
from excitation_planner.plan import ExcitationPlan
from modal_core.errors import ModelError
from modal_core.words.printable import printable
from structural_model.robot_files import load_robot

CLEAR = '\r\x1b[K'
LEAVE = 'q'


class TerminalPerson:
    """Is told on the error channel, asked on standard input.

    Parameters
    ----------
    robot : str or None
        Folder of the robot; None: that of the plan's name.
    """

    def __init__(self, robot: str | None) -> None:
        self._robot = robot
        self._shown = False

    def tell(self, line: str) -> None:
        """Say something that stays."""
        self.show('')
        MESSAGES.print(escape(line), soft_wrap=True)

    def show(self, line: str) -> None:
        """Say how it goes, over what was shown before."""
        if not MESSAGES.is_terminal or (not line and not self._shown):
            return
        self._shown = bool(line)
        sys.stderr.write(f'{CLEAR}{printable(line)[: MESSAGES.width - 1]}')
        sys.stderr.flush()

    def ask(self, question: str) -> str:
        """Ask for a line; the end of the input leaves."""
        self.show('')
        sys.stderr.write(question)
        sys.stderr.flush()
        line = sys.stdin.readline()
        return line.strip() if line else LEAVE

    def preview(self, plan: ExcitationPlan) -> None:
        """Show what a plan does before it is released.

        Raises
        ------
        ModelError
            The robot is not known here, or is another one.
        """
        model = load_robot(self._robot or plan.robot_name)
        if model.robot_name != plan.robot_name:
            raise ModelError(
                'the plan is for another robot',
                found=plan.robot_name,
                expected=model.robot_name,
                advice='name its folder by --robot',
            )
        self.show('')
        show_plan(plan, model)
