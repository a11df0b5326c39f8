"""The cutting force over a turn: teeth, helix, engagement, feed and runout.

References
----------
Kline and DeVor (1983), Int. J. Mach. Tool Des. Res. 23, 123-140 (runout); Budak, Altintas and
Armarego (1996), doi:10.1115/1.2831014 (force per area of chip and per length of edge).
"""

import numpy as np
from numpy.typing import NDArray

from machining.cut.directional import Cut, SLICES

Real = NDArray[np.float64]


def cutting_force(cut: Cut, depth_m: float, feed_m: float, angle_rad: Real) -> Real:
    """Return the force on a tool that does not give, (n, 3) [N].

    A tooth cuts what the teeth before it have left, each at its own radius: the chip is the
    least of m feeds more and m teeth back over m, none where that is below zero.

    Parameters
    ----------
    cut : Cut
        Cutter, engagement, material.
    depth_m : float [m]
        Axial depth.
    feed_m : float [m]
        Feed per tooth.
    angle_rad : (n,) array [rad]
        Of tooth 0 at the tip.
    """
    cutter, lead = cut.cutter, cut.cutter.lead_rad
    heights = depth_m * (np.arange(SLICES) + 0.5) / SLICES
    teeth = np.arange(cutter.n_teeth)
    angle = (
        np.asarray(angle_rad, float)[:, None, None]
        + (cutter.pitch_rad * teeth)[:, None]
        - cutter.lag_rad_m * heights
    ) % (2.0 * np.pi)
    sine, cosine = np.sin(angle), np.cos(angle)
    radii = cutter.radii_m
    chip = np.full(angle.shape, np.inf)
    for back in range(1, cutter.n_teeth + 1):
        # The tooth that passed here m pitches ago is the m-th ahead.
        further = (radii - radii[(teeth + back) % cutter.n_teeth])[:, None]
        chip = np.minimum(chip, back * feed_m * sine + further)
    chip = np.maximum(np.sin(lead) * chip, 0.0)
    engaged = (angle >= cut.engagement.entry_rad) & (angle <= cut.engagement.exit_rad)
    cutting = engaged & (chip > 0.0)
    width = depth_m / SLICES / np.sin(lead)
    tangential, radial, axial = (
        width * (area * chip + edge) * cutting
        for area, edge in zip(cut.coefficients.cutting_pa, cut.coefficients.edge_n_m, strict=True)
    )
    inward = np.sin(lead) * radial + np.cos(lead) * axial
    upward = np.cos(lead) * radial - np.sin(lead) * axial
    parts = [-tangential * cosine - inward * sine, tangential * sine - inward * cosine, upward]
    return np.stack([part.sum(axis=(1, 2)) for part in parts], axis=-1)
