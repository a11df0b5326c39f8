"""Progress of long work where there is no terminal."""

import time

from autonomous_modal_analysis.console import terminal
from autonomous_modal_analysis.console.terminal import progress_bar, stages_bar


def test_without_a_terminal_lines_say_now_and_then_how_far_it_is(monkeypatch, capsys):
    monkeypatch.setattr(terminal, 'LINE_EVERY_S', 0.2)
    with progress_bar('reading [a file]') as progress:
        for step in range(10):
            progress(step / 10.0)
            time.sleep(0.05)
    lines = capsys.readouterr().err.splitlines()
    assert 1 <= len(lines) <= 3
    assert all(line.startswith('reading [a file]: ') and ' % after ' in line for line in lines)
    assert 'left' in lines[-1]


def test_quick_work_says_nothing(capsys):
    with progress_bar('reading') as progress:
        progress(1.0)
    assert capsys.readouterr().err == ''


def test_each_stage_is_said_by_name_and_how_much_of_all_is_done(capsys):
    with stages_bar('milling') as progress:
        for part, stage in ((0.0, 'cutting'), (0.1, 'cutting'), (0.5, 'plscf, 1 of 2')):
            progress(part, stage)
    first, second = capsys.readouterr().err.splitlines()
    assert first.startswith('milling, cutting: 0 % after 0 s')
    assert second.startswith('milling, plscf, 1 of 2: 50 % after 0 s, about')


def test_work_that_tells_nothing_for_long_is_seen_to_go_on(monkeypatch, capsys):
    monkeypatch.setattr(terminal, 'LINE_EVERY_S', 0.1)
    with stages_bar('milling') as progress:
        progress(0.4, 'vmd')
        time.sleep(0.5)
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) >= 3 and all('milling, vmd: 40 % after' in line for line in lines)
