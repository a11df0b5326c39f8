"""Whether a mode has changed, beyond chance, pose, load and temperature.

In come the trends of a robot's modes; out go changes with their size, their begin and their
deviation and the part of the robot they go back to, false ones at a rate that is stated.
"""

from modal_history.alarm.baseline import Baseline, BaselineSettings, learn
from modal_history.alarm.check import AlarmCheck, Checked
from modal_history.alarm.latched import acknowledge, Alarm, alarms_of, keep_alarms
from modal_history.alarm.missing import Presence, presence_of
from modal_history.alarm.part import Part, Suspect
from modal_history.alarm.robot_parts import RobotParts
from modal_history.alarm.watch import Change, lost, needed_since, watch, Watched, WatchSettings

__all__ = [
    'Alarm',
    'AlarmCheck',
    'Baseline',
    'BaselineSettings',
    'Change',
    'Checked',
    'Part',
    'Presence',
    'RobotParts',
    'Suspect',
    'WatchSettings',
    'Watched',
    'acknowledge',
    'alarms_of',
    'keep_alarms',
    'learn',
    'lost',
    'needed_since',
    'presence_of',
    'watch',
]
