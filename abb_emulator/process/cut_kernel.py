"""The cutting force of teeth that cut what the teeth before them left, step by step.

A tooth at the angle φ from the normal of the feed takes the chip

    h = max(0, min over m of (m c sin φ + r_j - r_{j+m} + (u(t) - u(t - T_m))·e))

with e = (sin φ, cos φ), the feed per tooth c, the tooth's own radius r_j and the tool's
displacement u now and when the m-th tooth before it passed here: m above 1 where a tooth was out
of the cut.

References
----------
Tlusty and Ismail (1981), doi:10.1016/S0007-8506(07)60943-3 (basic nonlinearity of chatter: the
tool leaves the cut, and an earlier wave is left to cut).
"""

import numpy as np
from numpy.typing import NDArray

from modal_core.work.compiled import compiled

Real = NDArray[np.float64]
FURTHEST = 12
"""Teeth back whose waves may still stand: a cycle of a robot's slow mode, in which the tool is out
of the cut for half the time; with fewer remembered its chatter would not come to an end."""


@compiled
def step_force(
    times_s: Real,
    angles: Real,
    ago_s: Real,
    begin: Real,
    end: Real,
    history: Real,
    newest: int,
    newest_s: float,
    step_s: float,
    radii: Real,
    engagement: Real,
    feed_m: float,
    cutting: Real,
    edge: Real,
    depth_m: float,
) -> Real:
    """Return the force on the tool along feed and normal, mean of some moments, (2,) [N].

    Parameters
    ----------
    times_s, angles : (n,) array [s], [rad]
        Moments and the spindle's angle then.
    ago_s : (n, FURTHEST) array [s]
        When the spindle stood one, two, ... pitches back.
    begin, end : (2,) array [m]
        Displacement at both ends of a step, a straight line through both.
    history : (n_kept, 2) array [m]
        Displacement at the samples before, a ring.
    newest : int
        Row of the newest sample, which is ``begin``; its time is ``newest_s``.
    newest_s, step_s : float [s]
    radii : (n_teeth,) array [m]
    engagement : (2,) array [rad]
    feed_m : float [m]
        Per tooth.
    cutting, edge : (2,) array [N/m²], [N/m]
        Tangential and radial.
    depth_m : float [m]
    """
    force = np.zeros(2)
    n_teeth, n_kept = len(radii), len(history)
    pitch = 2.0 * np.pi / n_teeth
    for at in range(len(times_s)):
        share = (times_s[at] - newest_s) / step_s
        now = begin + share * (end - begin)
        for tooth in range(n_teeth):
            angle = (angles[at] + tooth * pitch) % (2.0 * np.pi)
            if angle < engagement[0] or angle > engagement[1]:
                continue
            sine, cosine = np.sin(angle), np.cos(angle)
            chip = 1e30
            for back in range(1, FURTHEST + 1):
                before = (newest_s - ago_s[at, back - 1]) / step_s
                if before < 0.0:
                    past = begin - before * (end - begin)
                else:
                    whole = min(int(before), n_kept - 2)
                    part = before - whole
                    late = history[(newest - whole) % n_kept]
                    early = history[(newest - whole - 1) % n_kept]
                    past = late + part * (early - late)
                off = (now[0] - past[0]) * sine + (now[1] - past[1]) * cosine
                step = radii[tooth] - radii[(tooth + back) % n_teeth]
                chip = min(chip, back * feed_m * sine + step + off)
            if chip <= 0.0:
                continue
            tangential = depth_m * (cutting[0] * chip + edge[0])
            radial = depth_m * (cutting[1] * chip + edge[1])
            force[0] += -tangential * cosine - radial * sine
            force[1] += tangential * sine - radial * cosine
    return force / len(times_s)
