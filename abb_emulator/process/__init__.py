"""A spindle at work at the arm's tool: in come its settings and how the tool moves; out go forces.

Unbalance, bearings and the cutting force of milling, each by name with its order of the spindle's
speed.  Its physics are its own: it shares nothing with the room that predicts chatter.
"""

from abb_emulator.process.process_settings import ProcessSettings
from abb_emulator.process.speed_message import speed_message, SPEED_TOPIC
from abb_emulator.process.spindle_process import ProcessLine, SpindleProcess

__all__ = ['SPEED_TOPIC', 'ProcessLine', 'ProcessSettings', 'SpindleProcess', 'speed_message']
