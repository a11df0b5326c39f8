"""Beats while somebody holds, none after; late ones are counted."""

import pytest

from autonomous_modal_analysis.operating.beats import BeatReport, Beats


def test_beats_end_at_the_stated_time_even_if_nothing_more_is_heard():
    beats = Beats()
    assert beats.due(0.0) == ''
    beats.hear('one 1.0\none 1.3')
    assert beats.due(0.9) == 'one'
    assert beats.due(1.1) == ''  # half a line is not believed
    beats.hear('\n')
    assert beats.due(1.2) == 'one'
    assert beats.due(1.31) == ''


def test_late_beats_are_counted_for_each_holder():
    beats = Beats()
    beats.hear('one 10.0\n')
    for now_s in (0.0, 0.02, 0.04, 0.3, 0.32):
        beats.due(now_s)
    report = beats.report(1)
    assert (report.n_beats, report.n_late, report.n_listeners) == (5, 1, 1)
    assert report.longest_s == pytest.approx(0.26)
    assert BeatReport.from_line(report.line()) == report
    beats.hear('two 20.0\n')
    beats.due(15.0)
    assert beats.report(1) == BeatReport(1, 0, 0.0, 1)
