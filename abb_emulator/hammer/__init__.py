"""A person with an instrumented hammer beside the arm at rest.

In come the model of the arm, a pose, sensors and where to tap; out go force and accelerations as
one converter records them, with whatever the person does wrong.
"""

from abb_emulator.hammer.taps import HammerRecord, HammerTaps, tap

__all__ = ['HammerRecord', 'HammerTaps', 'tap']
