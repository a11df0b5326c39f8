"""Modes at the tool against the matrices they come from."""

import numpy as np
from scipy.linalg import eigh
from scipy.spatial.transform import Rotation

from modal_core.tool_modes import ToolModes

SEED = 20261123


def modes_of(mass, stiffness, ratio, rng):
    values, shapes = eigh(stiffness, mass)
    n = len(values)
    root = rng.standard_normal((5 * n, 5 * n))
    return ToolModes(np.sqrt(values) / (2 * np.pi), np.full(n, ratio), shapes.T, root @ root.T)


def test_receptance_is_the_inverse_of_the_dynamic_stiffness():
    rng = np.random.default_rng(SEED)
    a, b = rng.standard_normal((2, 3, 3))
    mass, stiffness = a @ a.T + np.eye(3), 1e5 * (b @ b.T + np.eye(3))
    modes = modes_of(mass, stiffness, 0.02, rng)
    phi = modes.shape.T
    own = 2 * np.pi * modes.frequency_hz
    damping = mass @ phi @ np.diag(0.04 * own) @ phi.T @ mass
    for line in (20.0, 63.0):
        w = 2 * np.pi * line
        direct = np.linalg.inv(stiffness - w**2 * mass + 1j * w * damping)
        assert np.allclose(modes.receptance(np.array([line]))[0], direct, rtol=1e-10)


def test_turned_axes_turn_response_and_covariance():
    rng = np.random.default_rng(SEED)
    modes = modes_of(np.eye(3), np.diag([1e4, 4e4, 9e4]), 0.03, rng)
    axes = Rotation.random(random_state=SEED).as_matrix()
    turned, line = modes.turned(axes), np.array([17.0])
    assert np.allclose(turned.receptance(line), axes @ modes.receptance(line) @ axes.T)
    slope = rng.standard_normal(15)
    back = turned.turned(axes.T)
    assert np.allclose(back.covariance, modes.covariance)
    moved = modes.with_parameters(modes.parameters + 1e-3 * slope).turned(axes)
    step = (moved.parameters - turned.parameters) / 1e-3
    # A deviation of the old parameters is the same deviation in the new: quadratic forms agree.
    one = slope @ np.linalg.solve(modes.covariance, slope)
    assert np.isclose(step @ np.linalg.solve(turned.covariance, step), one, rtol=1e-6)
