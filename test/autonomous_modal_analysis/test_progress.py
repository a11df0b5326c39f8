"""Progress of long work where there is no terminal."""

import time

from autonomous_modal_analysis import terminal
from autonomous_modal_analysis.terminal import progress_bar


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
