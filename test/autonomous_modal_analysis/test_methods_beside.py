"""All methods beside the truth: what was found, what is a line, what is none."""

import numpy as np

from autonomous_modal_analysis.demos.methods_beside import judged, MethodBeside, write_methods
from autonomous_modal_analysis.report import TrueMode
from modal_core.mode import Mode


def mode(hz, zeta=0.02):
    return Mode(hz, zeta, np.ones(3, complex), 0.01, 0.001)


TRUTH = (TrueMode(10.0, 0.02), TrueMode(20.0, 0.01))
ARM_HZ, LINES_HZ = np.array([10.0, 20.0, 70.0]), np.array([13.0, 20.15])


def test_each_mode_found_is_true_or_a_line_or_none():
    found = judged('x', [mode(10.1), mode(13.01), mode(16.0), mode(70.1)], TRUTH, ARM_HZ, LINES_HZ)
    assert found.found[0] is not None and found.found[0].frequency_hz == 10.1
    assert found.found[1] is None
    assert found.on_lines == (13.01,) and found.others == (16.0,)


def test_one_mode_is_not_found_twice():
    twice = (TrueMode(10.0, 0.02), TrueMode(10.1, 0.02))
    found = judged('x', [mode(10.05)], twice, ARM_HZ, LINES_HZ)
    assert sum(each is not None for each in found.found) == 1


def test_the_page_shows_truth_methods_and_refusals(tmp_path):
    methods = (
        judged('good', [mode(10.01)], TRUTH, ARM_HZ, LINES_HZ),
        MethodBeside('poor', (None, None), refused='one loading condition'),
    )
    write_methods(tmp_path / 'methods.html', TRUTH, methods)
    page = (tmp_path / 'methods.html').read_text()
    for said in ('20.000 Hz', 'good', 'missed', 'refused', 'poor: one loading condition'):
        assert said in page
