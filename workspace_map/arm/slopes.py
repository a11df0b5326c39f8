"""Derivatives of what is measured with respect to what a model may lack.

With K = WᵀS (I + F) S W every row is of one form: of log f with z = u/2, of a shape's component c
with z = Σ_s φ_cs ω_r ω_s u_s / (ω_r² - ω_s²), its change per spring d is (z_d t_d + t'_d u_d) / 2,
with t = (I + F) u and t' = (I + F) z,
per coupling of d and e it is z_d u_e + z_e u_d, and per change of mass M' it is xᵀ M' φ_r
(Fox and Kapoor 1968, doi:10.2514/3.5008).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from workspace_map.arm.local_modes import LocalModes

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Slopes:
    """Rows of derivatives.

    Parameters
    ----------
    spring : (n_rows, n_dof) array
        Per log factor of a spring.
    coupling : (n_rows, n_pairs) array
        Per coupling of two springs.
    mass : (n_rows, n_masses) array
        Per payload number and link mass.
    """

    spring: Array
    coupling: Array
    mass: Array


def frequency_slopes(modes: LocalModes) -> Slopes:
    """Return the derivatives of log f, a row per mode of interest."""
    z, zt = 0.5 * modes.energy[:, : modes.n], 0.5 * modes.tension[:, : modes.n]
    mode = np.arange(modes.n)
    return _rows(modes, mode, z.T, zt.T, -0.5 * modes.shapes[:, : modes.n].T)


def shape_slopes(modes: LocalModes, of: Array, rows: Array) -> Slopes:
    """Return the derivatives of P_r times the shapes at some channels.

    Parameters
    ----------
    modes : LocalModes
        Where.
    of : (n_modes, n_rows, n_channels) array
        P_r: what of the channels' mass-normalised shape is asked, per mode of interest.
    rows : (n_channels, n_dof) array
        The channels.

    Returns
    -------
    Slopes
        Rows of the first mode, of the second, ...
    """
    n, squared, omega = modes.n, modes.squared, np.sqrt(modes.squared)
    half_power = 2.0 * modes.damping_ratio * squared[:n]
    apart = squared[:n, None] - squared
    # Modes closer than their bandwidth are one subspace: no first order tells them apart.
    inverse = apart / np.maximum(apart**2, half_power[:, None] ** 2)
    inverse[np.arange(n), np.arange(n)] = 0.0
    at = of @ (rows @ modes.shapes)  # (n, n_rows, n_dof)
    stretched = at * inverse[:, None, :]
    weights = stretched * (omega[:n, None] * omega)[:, None, :]
    x = -(stretched * squared[:n, None, None]) @ modes.shapes.T
    own = at[np.arange(n), :, np.arange(n)]
    x -= 0.5 * own[:, :, None] * modes.shapes[:, :n].T[:, None, :]
    size = len(squared)
    return _rows(
        modes,
        np.repeat(np.arange(n), of.shape[1]),
        (weights @ modes.energy.T).reshape(-1, size),
        (weights @ modes.tension.T).reshape(-1, size),
        x.reshape(-1, size),
    )


def damping_slopes(modes: LocalModes) -> Array:
    """Return the derivatives of log ζ per log factor of a damper, (n, n_dof)."""
    shapes = modes.shapes[:, : modes.n]
    whole = np.sum(shapes * (modes.damping @ shapes), axis=0)
    return np.asarray(((modes.dampers @ shapes) ** 2 / whole).T)


def _rows(modes: LocalModes, mode: NDArray[np.intp], z: Array, zt: Array, x: Array) -> Slopes:
    u, ut = modes.energy[:, mode].T, modes.tension[:, mode].T
    first, second = np.triu_indices(u.shape[1], 1)
    heavy = (modes.arm.mass_changes @ modes.shapes[:, : modes.n]).T  # (n, n_dof, n_masses)
    return Slopes(
        spring=0.5 * (z * ut + zt * u),
        coupling=z[:, first] * u[:, second] + z[:, second] * u[:, first],
        mass=(x[:, None, :] @ heavy[mode])[:, 0, :],
    )
