"""A cut in SI units, of what people write."""

import math

import numpy as np
from numpy.typing import NDArray

from machining.cut import Coefficients, Cut, Cutter, Engagement
from machining.cut_settings import CutSettings
from modal_core.errors import SettingsError

Real = NDArray[np.float64]
MM, N_MM2, N_MM = 1e-3, 1e6, 1e3


def cut_of(settings: CutSettings) -> Cut:
    """Return the cut.

    Raises
    ------
    SettingsError
        Engagement and cutter do not fit.
    """
    cutter = Cutter(
        settings.n_teeth,
        settings.diameter_mm * MM,
        math.radians(settings.helix_deg),
        math.radians(settings.lead_deg),
    )
    material = Coefficients(
        settings.tangential_n_mm2 * N_MM2,
        settings.radial_n_mm2 * N_MM2,
        settings.axial_n_mm2 * N_MM2,
        settings.tangential_edge_n_mm * N_MM,
        settings.radial_edge_n_mm * N_MM,
        settings.axial_edge_n_mm * N_MM,
        settings.coefficients_std,
    )
    return Cut(cutter, _engagement(settings), material)


def axes_of(settings: CutSettings, feed_deg: float) -> Real:
    """Return feed, normal and spindle axis as rows, (3, 3), for a direction of feed.

    Raises
    ------
    SettingsError
        The axes are none.
    """
    up, along = np.array(settings.spindle_axis), np.array(settings.feed_axis)
    if not np.isfinite([*up, *along]).all() or not up.any():
        raise SettingsError('no axis', where='spindle_axis', found=settings.spindle_axis)
    up = up / np.linalg.norm(up)
    along = along - (along @ up) * up
    if np.linalg.norm(along) < 1e-6:
        raise SettingsError('feed along the spindle', where='feed_axis', found=settings.feed_axis)
    along = along / np.linalg.norm(along)
    turn, across = math.radians(feed_deg), np.cross(up, along)
    feed = math.cos(turn) * along + math.sin(turn) * across
    return np.array([feed, np.cross(up, feed), up])


def speeds_of(settings: CutSettings) -> Real:
    """Return the spindle speeds looked at, (n_speeds,) [rpm]."""
    return np.linspace(settings.min_speed_rpm, settings.max_speed_rpm, settings.n_speeds)


def _engagement(settings: CutSettings) -> Engagement:
    share = (
        1.0
        if settings.radial_depth_mm is None
        else settings.radial_depth_mm / settings.diameter_mm
    )
    if share > 1.0:
        raise SettingsError(
            'deeper than the cutter is wide',
            where='radial_depth_mm',
            found=settings.radial_depth_mm,
            expected=f'at most {settings.diameter_mm:g} mm',
        )
    if settings.way == 'slot':
        if settings.radial_depth_mm is not None and share < 1.0:
            raise SettingsError(
                'a slot is as wide as the cutter',
                where='radial_depth_mm',
                advice='say way up or down',
            )
        return Engagement.slot()
    return Engagement.up(share) if settings.way == 'up' else Engagement.down(share)
