"""`ama demo --milling`: the emulated arm mills, its modes are found, its lines are no modes."""

import re

from mcap.reader import make_reader
import pytest

from autonomous_modal_analysis.demos.milling_demo import milling_demo

SEED = 3


@pytest.mark.slow
def test_all_modes_are_found_and_lines_are_none(tmp_path):
    """Lines 18 to 50 dB above the response; modes with ζ f T > 2 below 60 Hz."""
    print('seed', SEED)
    demo = milling_demo(tmp_path, 'irb6660_205_190', 'P1', SEED, lambda *_: None, every=False)
    assert max(demo.above_db.values()) > 30.0
    assert demo.missed_hz == [] and demo.lines_as_modes_hz == []
    for true in demo.truth:
        assert true.mac > 0.95
        assert abs(true.frequency_error_sigma) < 4.0
    page = (tmp_path / 'report.html').read_text()
    # Above 60 Hz the arm has modes, too: 64.9, 80.8, 94.9 Hz, ...
    assert int(re.search(r'All (\d+) true modes found', page)[1]) > len(demo.truth)
    assert 'tooth passing 2' in page and '52.00 Hz' in page
    with (tmp_path / 'milling.mcap').open('rb') as file:
        topics = {item.topic for item in make_reader(file).get_summary().channels.values()}
    assert '/spindle_speed_rpm' in topics
