"""How chip thickness becomes force: the directional matrices, exactly averaged.

Axes: x along the feed, y normal to it in the machined face, z along the cutter from the work to
the spindle.  A tooth at the angle φ from y towards x has the radial direction
e = (sin κ sin φ, sin κ cos φ, −cos κ) at the lead angle κ; the force on the tool by a chip of
thickness h and width b is f h b, of tangential, radial and axial parts.  Moving the tool by u
thickens the chip by e·u.

References
----------
Altintas, Manufacturing Automation (2012), section 4.9; Altintas (2001), doi:10.1299/jsmec.44.717.
"""

from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import NDArray

from machining.cut.coefficients import Coefficients
from machining.cut.cutter import Cutter, Engagement

Real = NDArray[np.float64]
SLICES = 24
"""Of a helical edge over the depth; the force in the middle of a slice stands for it."""


@dataclass(frozen=True, slots=True)
class Cut:
    """A cutter in a material.

    Parameters
    ----------
    cutter : Cutter
    engagement : Engagement
    coefficients : Coefficients
    """

    cutter: Cutter
    engagement: Engagement
    coefficients: Coefficients

    @property
    def mean_directional(self) -> Real:
        """Force per depth and displacement, averaged over a turn, (3, 3) [N/m²]."""
        both = np.array([self.engagement.entry_rad, self.engagement.exit_rad])
        first, last = _primitive(both) @ self._parts.reshape(6, 9)
        own: Real = self.cutter.n_teeth / (2.0 * math.pi) * (last - first)
        return own.reshape(3, 3)

    def directional(self, angle_rad: Real, depth_m: float) -> Real:
        """Return force per depth and displacement, averaged from each angle to the next.

        Parameters
        ----------
        angle_rad : (n_steps + 1,) array [rad]
            Of tooth 0 at the tip, rising.
        depth_m : float [m]
            Axial depth; it matters to a helical edge alone.

        Returns
        -------
        (n_steps, 3, 3) array [N/m²]
            Displacement along the second axis, force along the first.
        """
        cutter = self.cutter
        heights = depth_m * (np.arange(SLICES) + 0.5) / SLICES if cutter.helix_rad else np.zeros(1)
        teeth = cutter.pitch_rad * np.arange(cutter.n_teeth)
        lag = teeth[:, None] - cutter.lag_rad_m * heights
        turned = np.asarray(angle_rad)[:, None, None] + lag
        basis = np.diff(self._up_to(turned).mean(axis=2).sum(axis=1), axis=0)
        own = basis @ self._parts.reshape(6, 9) / np.diff(angle_rad)[:, None]
        return np.asarray(own.reshape(-1, 3, 3))

    def mean_force(self, depth_m: float, feed_m: float) -> Real:
        """Return the mean force on the tool, (3,) [N].

        Parameters
        ----------
        depth_m : float [m]
            Axial depth.
        feed_m : float [m]
            Feed per tooth.
        """
        cutter = self.cutter
        both = np.array([self.engagement.entry_rad, self.engagement.exit_rad])
        first, last = _primitive(both) @ self._edge_parts
        edge = cutter.n_teeth / (2.0 * math.pi) * (last - first)
        return np.asarray(depth_m * (feed_m * self.mean_directional[:, 0] + edge))

    @property
    def _parts(self) -> Real:
        """Weights of sin², sin cos, cos², sin, cos and 1 in f eᵀ per depth, (6, 3, 3)."""
        k, m = math.sin(self.cutter.lead_rad), _cosine(self.cutter.lead_rad)
        f_sin, f_cos, f_one = self._force_parts(self.coefficients.cutting_pa)
        e_sin, e_cos, e_one = np.diag([k, k, -m])
        both = np.outer(f_sin, e_cos) + np.outer(f_cos, e_sin)
        return np.array(
            [
                np.outer(f_sin, e_sin),
                both,
                np.outer(f_cos, e_cos),
                np.outer(f_sin, e_one) + np.outer(f_one, e_sin),
                np.outer(f_cos, e_one) + np.outer(f_one, e_cos),
                np.outer(f_one, e_one),
            ]
        )

    @property
    def _edge_parts(self) -> Real:
        """Weights of the same six in the force of the edges per depth, (6, 3)."""
        return np.vstack([np.zeros((3, 3)), self._force_parts(self.coefficients.edge_n_m)])

    def _force_parts(self, of: tuple[float, float, float]) -> Real:
        """Weights of sin, cos and 1 in the force per depth, (3, 3), by coefficients."""
        k, m = math.sin(self.cutter.lead_rad), _cosine(self.cutter.lead_rad)
        tangential, radial, axial = of
        inward = k * radial + m * axial
        parts = [
            [-inward, tangential, 0.0],
            [-tangential, -inward, 0.0],
            [0.0, 0.0, m * radial - k * axial],
        ]
        return np.array(parts) / k

    def _up_to(self, angle: Real) -> Real:
        """Return the integral of the six over what was in the cut up to an angle, (..., 6)."""
        entry, leave = self.engagement.entry_rad, self.engagement.exit_rad
        turns, rest = np.divmod(angle, 2.0 * math.pi)
        begin, end = _primitive(np.array([entry, leave]))
        now = _primitive(np.clip(rest, entry, leave))
        return np.asarray(turns[..., None] * (end - begin) + now - begin)


def _primitive(angle: Real) -> Real:
    """Return the integrals of sin², sin cos, cos², sin, cos and 1, (..., 6)."""
    sine, cosine = np.sin(angle), np.cos(angle)
    both = sine * cosine
    own = [0.5 * (angle - both), 0.5 * sine**2, 0.5 * (angle + both), -cosine, sine, angle]
    return np.stack(own, axis=-1)


def _cosine(lead_rad: float) -> float:
    """Return the cosine, exactly 0 at a right angle: an end mill's z displacement cuts nothing."""
    own = math.cos(lead_rad)
    return own if own > 1e-12 else 0.0
