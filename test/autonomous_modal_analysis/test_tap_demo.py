"""`ama demo --impact`: the emulated arm tapped, recordings and results left."""

import pytest

from autonomous_modal_analysis.demos.tap_demo import tap_demo
from impact_testing import Fault


@pytest.mark.slow
def test_the_demonstration_finds_the_modes_of_the_arm_and_its_double_hit(tmp_path):
    demo = tap_demo(tmp_path, 'irb6660_205_190', 'P1', 1)
    assert demo.missed_hz == []
    first = demo.result.found.points[0].taps
    assert [{f for f, _ in each.faults} for each in first][1] == {Fault.DOUBLE_HIT}
    names = {path.name for path in tmp_path.iterdir()}
    assert {'modes.json', 'modes.csv', 'frf.uff', 'report.html', 'taps_spindle.x.csv'} <= names
