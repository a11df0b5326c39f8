"""Measured modes as linear rows of what the arm may have, close modes as one subspace.

In come modes expected at a pose and modes measured there; out go derivatives, residuals and their
standard deviations.
"""

from workspace_map.rows.linearised import (
    Block,
    damping_block,
    damping_structure,
    Pairs,
    stacked,
    stacked_slopes,
    structure_block,
)
from workspace_map.rows.principal_rows import flat, principal_rows, PrincipalRows, ROWS
from workspace_map.rows.subspace import Aligned, aligned, nearest_rotation, subspaces

__all__ = [
    'ROWS',
    'Aligned',
    'Block',
    'Pairs',
    'PrincipalRows',
    'aligned',
    'damping_block',
    'damping_structure',
    'flat',
    'nearest_rotation',
    'principal_rows',
    'stacked',
    'stacked_slopes',
    'structure_block',
    'subspaces',
]
