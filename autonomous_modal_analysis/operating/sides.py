"""The two sides the panel stands between: the cell, and the person at the terminal."""

from collections.abc import Callable, Sequence
from typing import Protocol

from autonomous_modal_analysis.operating.beats import BeatReport
from autonomous_modal_analysis.operating.situation import Act, Situation
from excitation_planner.plan import ExcitationPlan


class Cell(Protocol):
    """What is asked of a cell; what it refuses it raises as BridgeError."""

    def situation(self) -> Situation | None:
        """Return what the bridge said last; None before."""

    def plan(self) -> ExcitationPlan | None:
        """Return the planner's plan; None before one came."""

    def release(self, plan_hash: str, controller: str) -> str:
        """Release a plan; return the token."""

    def start_later(self, token: str) -> Callable[[], tuple[bool, str] | None]:
        """Ask to start; return a function that gives the answer once it is there."""

    def abort(self) -> None:
        """Ask to stop, without waiting."""

    def help(self, act: Act) -> str:
        """Do what a step asks for, where a program can; return what was answered."""

    def windows(self) -> Sequence[str]:
        """Return a line for each window identified since the last call."""

    def check_beats(self) -> None:
        """Wait until the bridge can hear the beats."""

    def hold(self, token: str, until_s: float) -> None:
        """Beat with a token until a time [s]."""

    def let_go(self, token: str) -> None:
        """Beat no more."""

    def report(self) -> BeatReport:
        """Return how the beats go."""


class Person(Protocol):
    """Who is at the terminal."""

    def tell(self, line: str) -> None:
        """Say something that stays."""

    def show(self, line: str) -> None:
        """Say how it goes, over what was shown before."""

    def ask(self, question: str) -> str:
        """Ask for a line."""

    def preview(self, plan: ExcitationPlan) -> None:
        """Show what a plan does before it is released."""
