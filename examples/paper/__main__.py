"""Run every finding, print all tables and draw all pictures."""

import time

from examples.paper import (
    all_joints,
    optimised_pulses,
    pulse_spectrum,
    self_excitation,
    sensitivity,
    wide_range,
)
from examples.paper.output import say

FINDINGS = (
    pulse_spectrum,
    sensitivity,
    self_excitation,
    all_joints,
    wide_range,
    optimised_pulses,
)

for finding in FINDINGS:
    began_s = time.process_time()
    finding.main()
    name = finding.__name__.rsplit('.', 1)[-1]
    say(f'[dim]{name}: {time.process_time() - began_s:.0f} s of CPU time[/dim]\n')
