"""Modes of several recordings held against each other, or joined.

In come modes of two recordings or of several set-ups with shared references; out go changes
beyond chance, or one set of shapes over all points (PoSER; Reynders, Magalhaes, De
Roeck and Cunha 2009, IOMAC), set-ups that missed a mode included where their covariances
tell of it (PreGER).
"""

from oma_identifier.compare.comparison import compare_modes, ModeChange, ModeComparison
from oma_identifier.compare.merging import merge_modes, shared_channels
from oma_identifier.compare.reference_check import check_references

__all__ = [
    'ModeChange',
    'ModeComparison',
    'check_references',
    'compare_modes',
    'merge_modes',
    'shared_channels',
]
