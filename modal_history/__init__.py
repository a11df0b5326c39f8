"""Results of robots over months and years, in one file, and what changed in them.

In come the modes of one window after the other with pose, load and temperature; out go trends of
modes whose ids last over runs, tables of other programs, and alarms.
"""
