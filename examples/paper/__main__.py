"""Run every finding: print and keep all tables, draw all pictures; or check what is kept.

With ``--check`` nothing is written: what is computed is held against the kept tables, and what
differs by more than machines do fails.
"""

import time

import typer

from examples.paper import (
    all_joints,
    batches,
    frequency_responses,
    optimised_pulses,
    pulse_spectrum,
    self_excitation,
    sensitivity,
    wide_range,
)
from examples.paper.output import KEEPER, say

FINDINGS = (
    pulse_spectrum,
    frequency_responses,
    sensitivity,
    batches,
    self_excitation,
    all_joints,
    wide_range,
    optimised_pulses,
)


def main(*, check: bool = False) -> None:
    KEEPER.checks = check
    for finding in FINDINGS:
        began_s = time.process_time()
        finding.main()
        name = finding.__name__.rsplit('.', 1)[-1]
        say(f'[dim]{name}: {time.process_time() - began_s:.0f} s of CPU time[/dim]\n')
    for difference in KEEPER.differences:
        say(f'[bold]stale[/bold] {difference}')
    if KEEPER.differences:
        say('What is kept is not what is computed today: run `make reproduce`.')
        raise typer.Exit(1)


if __name__ == '__main__':
    typer.run(main)
