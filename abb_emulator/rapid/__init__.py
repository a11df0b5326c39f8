"""RAPID: modules read, checked and run as the controller would.

In comes the text of a module; out go moves of the controller, or the error a controller
reports.
"""

from abb_emulator.rapid.program_task import CYCLES, LARGEST_BYTES, ProgramTask

__all__ = ['CYCLES', 'LARGEST_BYTES', 'ProgramTask']
