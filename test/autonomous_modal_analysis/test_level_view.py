"""What is said of modes over levels whose damping the width does not tell."""

from dataclasses import replace
import math

import numpy as np
import pytest

from autonomous_modal_analysis.compared.mode_levels import ModeLevels
from autonomous_modal_analysis.views.level_view import added_at_largest, level_notes
from modal_core.mode import Mode
from oma_identifier.levels import CubicMode, Law, LawFit, LevelLaw, ModalMotion, QuantityLaw

MODE = Mode(10.0, 0.01, np.ones(1, dtype=complex))
FIT = LawFit(Law.CUBIC, 1.0, 0.1, 0.5, 0.04, 1.0, 2, 0.0, np.ones_like)
CUBIC = QuantityLaw((Law.CUBIC,), 1.0, 0.1, FIT)
UNKNOWN, CONSTANT = (replace(CUBIC, laws=(law,)) for law in (Law.UNKNOWN, Law.CONSTANT))
OPEN = replace(CUBIC, laws=(Law.CUBIC, Law.PLAY))
MOTION = ModalMotion(1e-3, 0.06, 3e-6, 0.01, 0.1, 4e3, 10.0, 0.0, (), 1.0, 10.0, 0.0)
LAW = LevelLaw(CubicMode(10.0, 0.01, 1e8, 10.0), 0.01, 1e-4, 1e7, 1.0, CUBIC, CUBIC)


def over(law, levels=4):
    return ModeLevels('x', MODE, ((0, MODE, MOTION),) * levels, law)


def test_a_law_with_a_deviation_has_its_number_and_needs_no_word():
    assert all('±' in each for each in added_at_largest(over(LAW), LAW))
    assert level_notes([over(LAW)]) == ()


@pytest.mark.parametrize(
    ('change', 'words'),
    [
        (
            {'damping': UNKNOWN, 'cubic_damping_std': math.nan},
            'not told',
        ),
        (
            {'damping': CONSTANT, 'by_amplitude': True},
            'by the amplitude',
        ),
    ],
)
def test_what_the_width_does_not_tell_is_said_with_the_reason(change, words):
    law = replace(LAW, **change)
    (said,) = level_notes([over(law)])
    assert said.startswith('10 Hz: damping') and words in said and 'other modes' in said
    damping = added_at_largest(over(law), law)[1]
    assert damping == '-' if 'cubic_damping_std' in change else '±' in damping


@pytest.mark.parametrize(
    ('another_level', 'words'),
    [(0.5e-3, 'one of 0.5 mm rms would'), (math.nan, 'longer recordings would')],
)
def test_what_would_tell_two_laws_apart_is_said(another_level, words):
    law = replace(LAW, stiffness=replace(OPEN, another_level=another_level))
    (said,) = level_notes([over(law)])
    assert said == f'10 Hz: the levels do not tell which law stiffness has; {words}'
    assert '±' in added_at_largest(over(law), law)[0]


def test_a_law_through_three_levels_is_assumed():
    (said,) = level_notes([over(LAW, levels=3)])
    assert 'that stiffness is cubic is assumed' in said


def test_a_cubic_term_that_the_levels_exclude_has_no_number():
    law = replace(LAW, stiffness=replace(CUBIC, laws=(Law.PLAY,)), cubic_stiffness_std=math.nan)
    assert added_at_largest(over(law), law)[0] == '-'
