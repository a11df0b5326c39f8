"""Parameters of the replay node: name, default, meaning."""

from typing import Any

PARAMETERS: tuple[tuple[str, Any, str], ...] = (
    ('recording', '', 'rosbag2 folder, .mcap, .db3, .bag, .npy or .csv'),
    ('topics', [''], 'play only these topics; empty: every usable one'),
    ('remap', [''], 'old:=new, one entry per topic'),
    ('rate', 1.0, '1: as recorded'),
    ('start_offset_s', 0.0, 'skipped at the beginning [s]'),
    ('loop', False, 'begin again at the end'),
    ('publish_clock', False, 'publish /clock in recorded time'),
    ('start_paused', False, 'wait for ~/pause false or ~/step'),
    ('wait_for_subscribers_s', 10.0, 'longest wait until every topic is listened to'),
    ('exit_at_end', True, 'end the process when everything is played'),
    ('sample_rate_hz', 0.0, 'plain arrays: rate [Hz]; 0: from the sidecar file'),
    ('unit', '', 'plain arrays: unit; empty: from the sidecar file'),
    ('channels', [''], 'plain arrays: names of the columns; empty: from the sidecar file'),
)
