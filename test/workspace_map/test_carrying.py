"""Shapes carried through crossings of two modes, whose course is known in closed form.

K = [[k + s, c], [c, k - s]] with M = I: frequencies avoid one another by c/k of their value, and
the shapes turn by 90 degrees over |s| of some c.
"""

from dataclasses import dataclass

import numpy as np
import pytest

from workspace_map import Carried, carried_on
from workspace_map.rows import subspaces

STIFFNESS = (2 * np.pi * 10.0) ** 2
RATIO = 0.02


@dataclass
class Crossing:
    """Modes at one place of it."""

    frequency_hz: np.ndarray
    damping_ratio: np.ndarray
    shapes: np.ndarray


def at(s, gap):
    """Return the modes where the uncoupled frequencies are 2 s apart, relative to their own."""
    matrix = STIFFNESS * np.array([[1.0 + 2.0 * s, gap], [gap, 1.0 - 2.0 * s]])
    squared, shapes = np.linalg.eigh(matrix)
    return Crossing(np.sqrt(squared) / (2 * np.pi), np.full(2, RATIO), shapes)


def carried_through(gap, steps):
    places = np.linspace(-0.2, 0.2, steps)
    carried, ids = Carried.of(at(places[0], gap)), np.arange(2)
    for s in places[1:]:
        came, carried = carried_on(carried, at(s, gap))
        ids = ids[came]
    return ids, carried


@pytest.mark.parametrize('steps', [21, 201, 2001])
@pytest.mark.parametrize('part', [0.1, 0.4, 1.3, 2.0])
def test_a_crossing_nearer_than_the_bands_is_passed_whatever_the_steps(part, steps):
    """Half-power bands of 2 ζ f: nearer than that shapes go through, farther modes do.

    Steps between which a shape turns by more than 45 degrees pass any gap.
    """
    gap = part * 2.0 * RATIO
    ids, carried = carried_through(gap, steps)
    if part < 1.0:
        assert list(ids) == [1, 0]
    elif steps > 21:
        assert list(ids) == [0, 1]
    assert np.linalg.norm(carried.shapes, axis=0) == pytest.approx(1.0)


def test_a_gap_that_decides_neither_way_leaves_no_sure_share():
    """The turn left when the bands part is 45 degrees where the gap is 1/sqrt(2) of them."""
    _, clear = carried_through(0.2 * 2.0 * RATIO, 2001)
    _, doubtful = carried_through(np.sqrt(0.5) * 2.0 * RATIO, 2001)
    assert clear.share.min() > 0.95
    assert doubtful.share.max() < 0.6


def test_within_a_subspace_a_shape_is_carried_without_turning():
    """In the middle of a narrow crossing modes are mixed half and half, the carried are not."""
    gap = 0.1 * 2.0 * RATIO
    carried = Carried.of(at(-0.2, gap))
    for s in np.linspace(-0.2, 0.0, 400)[1:]:
        _, carried = carried_on(carried, at(s, gap))
    assert np.abs(at(0.0, gap).shapes[0]) == pytest.approx(np.sqrt(0.5))
    assert np.max(carried.shapes**2, axis=0) == pytest.approx(1.0, abs=0.01)


def test_modes_whose_bands_touch_are_one_subspace():
    hz, ratio = np.array([10.0, 10.3, 12.0, 13.0, 13.4]), np.full(5, 0.02)
    assert list(subspaces(hz, ratio)) == [0, 0, 1, 2, 2]


def test_a_mode_that_comes_from_beyond_has_no_id_before():
    rng = np.random.default_rng(1)
    shapes = np.linalg.qr(rng.standard_normal((3, 3)))[0]
    before = Carried.of(Crossing(np.array([10.0]), np.array([RATIO]), shapes))
    there = Crossing(np.array([10.0, 20.0]), np.full(2, RATIO), shapes)
    came, after = carried_on(before, there)
    assert list(came) == [0, -1]
    assert after.shapes[:, 1] ** 2 == pytest.approx(shapes[:, 1] ** 2)
