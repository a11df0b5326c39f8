"""Plays plans on the emulated arm, as fast as it goes."""

from dataclasses import replace
from pathlib import Path

from abb_emulator.run_plan import ArmOptions, run_plan, START_NS
from autonomous_modal_analysis.identified.plan_record import plan_message
from excitation_planner.plan import ExcitationPlan
from modal_core.work.progress import Progress


class EmulatedPlayer:
    """Every plan is played on the same arm, with noise of its own.

    Parameters
    ----------
    options : ArmOptions
        The cell.
    """

    note = 'recorded on the emulated arm'

    def __init__(self, options: ArmOptions) -> None:
        self.options = options

    def play(self, plan: ExcitationPlan, path: Path, progress: Progress) -> None:
        """Play a plan and leave its recording; see :func:`run_plan`."""
        cell = self.options.cell
        # The plan's hash makes the noise: the same recording again gets the same noise.
        own = replace(cell, seed=cell.seed + int(plan.plan_hash[:12], 16))
        run_plan(
            replace(self.options, cell=own), plan, path, progress, [plan_message(plan, START_NS)]
        )
