"""Tables of a history file and their version."""

from modal_core.mode import MODE_FIELDS

APPLICATION_ID = 0x616D6168
"""Of every history: ``amah``."""
VERSION = 3
"""Counts up when a program that reads the file must be changed."""
PAGE_BYTES = 16384
"""A result of 42 channels and 10 modes takes a sixth of it; of 4096 half would stay empty."""
SCALARS = tuple(item for item in MODE_FIELDS if item.kind is not complex and item.name != 'id')
"""What a mode has beside its id and its shape: a new field becomes a column of old files too."""

TABLES = """
CREATE TABLE run (
    id INTEGER PRIMARY KEY, key TEXT NOT NULL UNIQUE, robot TEXT NOT NULL, tool TEXT NOT NULL,
    software TEXT NOT NULL, settings_hash TEXT NOT NULL, recording TEXT NOT NULL,
    recording_hash TEXT NOT NULL);
CREATE TABLE settings (hash TEXT PRIMARY KEY, text TEXT NOT NULL) WITHOUT ROWID;
CREATE TABLE layout (
    id INTEGER PRIMARY KEY, method TEXT NOT NULL, channels TEXT NOT NULL, joints TEXT NOT NULL,
    UNIQUE (method, channels, joints));
CREATE TABLE window (
    id INTEGER PRIMARY KEY, run INTEGER NOT NULL REFERENCES run, layout INTEGER NOT NULL
    REFERENCES layout, number INTEGER NOT NULL, start_ns INTEGER NOT NULL,
    end_ns INTEGER NOT NULL, position BLOB, position_range BLOB, temperature_c REAL,
    load_kg REAL, identifiable INTEGER NOT NULL, reason TEXT NOT NULL, flags TEXT NOT NULL,
    channel_flags TEXT NOT NULL);
CREATE INDEX window_of_run ON window (run, number, start_ns);
CREATE TABLE mode (window INTEGER NOT NULL REFERENCES window, place INTEGER NOT NULL,
    id INTEGER NOT NULL, own_id INTEGER NOT NULL, PRIMARY KEY (window, place)) WITHOUT ROWID;
CREATE INDEX mode_by_id ON mode (id, window);
CREATE TABLE shape (window INTEGER PRIMARY KEY REFERENCES window, shape BLOB NOT NULL,
    shape_std BLOB NOT NULL);
CREATE TABLE tracker (robot TEXT PRIMARY KEY, n INTEGER NOT NULL, state BLOB NOT NULL)
    WITHOUT ROWID;
"""
"""``window.number`` is -1 for a whole recording.  ``mode.id`` lasts over runs, ``own_id`` is that
of the run's identifier; ids are counted robot by robot."""
ALARMS = """
CREATE TABLE alarm (id INTEGER PRIMARY KEY, robot TEXT NOT NULL, mode INTEGER NOT NULL,
    raised_ns INTEGER NOT NULL, since_ns INTEGER NOT NULL, share REAL NOT NULL,
    share_std REAL NOT NULL, surprise REAL NOT NULL, bound REAL NOT NULL, acknowledged_ns INTEGER);
"""
PARTS = """
ALTER TABLE alarm RENAME TO alarm_of_before;
CREATE TABLE alarm (id INTEGER PRIMARY KEY, robot TEXT NOT NULL, mode INTEGER NOT NULL,
    raised_ns INTEGER NOT NULL, since_ns INTEGER NOT NULL, share REAL, share_std REAL,
    surprise REAL NOT NULL, bound REAL NOT NULL, kind TEXT NOT NULL, part TEXT NOT NULL,
    acknowledged_ns INTEGER);
INSERT INTO alarm SELECT id, robot, mode, raised_ns, since_ns, share, share_std, surprise, bound,
    'moved', '', acknowledged_ns FROM alarm_of_before;
DROP TABLE alarm_of_before;
"""
STEPS = {1: TABLES, 2: ALARMS, 3: PARTS}
"""What each version has added: an older file takes the steps it lacks."""
