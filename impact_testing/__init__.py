"""Experimental modal analysis: taps of an instrumented hammer in, modes with their masses out.

In come force and responses; out go judged taps, FRFs with coherence, and natural frequencies,
damping ratios, mass-normalised shapes and modal masses with their standard deviations.
"""

from impact_testing.impact_test import impact_modes, ImpactSettings
from impact_testing.read import read_impact
from impact_testing.record import ImpactRecord
from impact_testing.responses import PointFrf, PointSpectra
from impact_testing.result import frac, ImpactResult, ScaledMode, TestedPoint
from impact_testing.taps import Fault, find_taps, Guidance, judge_taps, JudgedTap, Tap, TapJudge

__all__ = [
    'Fault',
    'Guidance',
    'ImpactRecord',
    'ImpactResult',
    'ImpactSettings',
    'JudgedTap',
    'PointFrf',
    'PointSpectra',
    'ScaledMode',
    'Tap',
    'TapJudge',
    'TestedPoint',
    'find_taps',
    'frac',
    'impact_modes',
    'judge_taps',
    'read_impact',
]
