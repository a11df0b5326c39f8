"""Beams and joints against closed forms, published conventions and one another."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq

from machining.joining import (
    joined_tip,
    Material,
    Segment,
    tool_receptance,
    with_joint,
    with_rotations,
)
from modal_core.errors import SettingsError

STEEL = Material(207e9, 7800.0, 0.3, 0.003)
ROD = [Segment(0.1, 0.02)]


def test_a_rod_has_the_receptances_of_timoshenko():
    found = tool_receptance(ROD, np.array([1000.0]), STEEL)[0]
    assert found[0, 0] == pytest.approx(-3.9796608e-7 - 1.9684e-11j, rel=1e-4)
    assert found[0, 1] == pytest.approx(5.694629e-6 + 9.914e-10j, rel=1e-4)
    assert found[1, 1] == pytest.approx(-9.699335e-5 - 7.0796e-8j, rel=1e-4)
    assert found == pytest.approx(found.T, rel=1e-9)
    assert found[0, 2] == found[0, 3] == found[0, 4] == 0.0


@pytest.mark.parametrize(('low', 'high', 'expected'), [(7e3, 9e3, 8355.27), (19e3, 21e3, 20182.3)])
def test_natural_frequencies_of_a_free_rod(low, high, expected):
    """Where the inverse of the receptance is singular; bending modes of Timoshenko's beam."""
    still = Material(207e9, 7800.0, 0.3, 1e-8)

    def turned(hz):
        return 1.0 / tool_receptance(ROD, np.array([hz]), still)[0, 0, 0].real

    assert brentq(turned, low, high) == pytest.approx(expected, rel=1e-5)


def test_two_halves_joined_are_the_whole():
    lines = np.array([300.0, 1000.0, 7000.0, 15000.0])
    half = tool_receptance([Segment(0.05, 0.02)], lines, STEEL)
    whole = tool_receptance(ROD, lines, STEEL)
    # The upper half as a machine: its lower end.
    joined = joined_tip(half, half[:, :5, :5])
    bending = [0, 1, 2, 3]
    for row in bending:
        assert joined[:, row, bending] == pytest.approx(whole[:, row, bending], rel=1e-9)
    assert joined[:, 4, 4] == pytest.approx(whole[:, 4, 4], rel=1e-9)


def soft_machine(lines, mass=20.0, hz=40.0):
    omega = 2 * np.pi * lines
    own = 1.0 / (mass * ((2 * np.pi * hz) ** 2 - omega**2 + 2j * 0.02 * 2 * np.pi * hz * omega))
    found = np.zeros((len(lines), 5, 5), complex)
    found[:, 0, 0] = found[:, 2, 2] = found[:, 4, 4] = own
    found[:, 1, 1] = found[:, 3, 3] = 1e-9
    return found


def drawn_structure(n_dof, rng):
    """Return mass, damping and stiffness of a structure with cross terms everywhere."""
    mass, stiffness = (
        size * (root @ root.T + n_dof * np.eye(n_dof))
        for size, root in ((0.1, rng.standard_normal((n_dof, n_dof))),
                           (1e4, rng.standard_normal((n_dof, n_dof))))
    )  # fmt: skip
    return mass, 1e-4 * stiffness, stiffness


def dynamic_stiffness(parts, hz):
    mass, damping, stiffness = parts
    omega = 2 * np.pi * hz
    return stiffness + 1j * omega * damping - omega**2 * mass


@pytest.mark.parametrize('soft', [False, True])
def test_joined_receptances_are_those_of_the_assembled_structure(soft):
    """Primal assembly of mass, damping and stiffness, then solved, knows nothing of coupling.

    A tool of 10 and a machine of 9 coordinates, 5 of which meet; x, y and slopes hang together in
    both.  Also against the textbook form with all interface coordinates side by side and a signed
    Boolean matrix (de Klerk, Rixen and Voormeeren 2008, equation 26); seed 8.
    """
    rng, lines = np.random.default_rng(8), np.array([7.0, 31.0, 55.0])
    tool, machine = drawn_structure(10, rng), drawn_structure(9, rng)
    spring = np.array([2e5, 3e4, 1e5, 5e4, 4e5])
    joint = with_joint(lines, spring, np.zeros(5)) if soft else None
    inverse = np.linalg.inv
    free = np.array([inverse(dynamic_stiffness(tool, hz)) for hz in lines])
    holder = np.array([inverse(dynamic_stiffness(machine, hz)) for hz in lines])
    found = joined_tip(free, holder[:, :5, :5], joint)
    boolean = np.hstack([np.zeros((5, 5)), np.eye(5), -np.eye(5), np.zeros((5, 4))])
    for number, hz in enumerate(lines):
        whole = np.zeros((19, 19), complex)
        whole[:10, :10] = dynamic_stiffness(tool, hz)
        whole[10:, 10:] = dynamic_stiffness(machine, hz)
        apart = inverse(whole)
        give = np.diag(1.0 / spring) if soft else 0.0
        push = inverse(boolean @ apart @ boolean.T + give) @ boolean @ apart
        textbook = apart - apart @ boolean.T @ push
        assert found[number] == pytest.approx(textbook[:5, :5], rel=1e-8)
        if soft:
            assembled = inverse(whole + boolean.T @ np.diag(spring) @ boolean)
        else:
            both = np.zeros((19, 14))
            both[:10, :10] = np.eye(10)
            both[10:15, 5:10] = np.eye(5)
            both[15:, 10:] = np.eye(4)
            assembled = inverse(both.T @ whole @ both)
        assert found[number] == pytest.approx(assembled[:5, :5], rel=1e-8)


def test_far_below_its_modes_a_tool_is_a_mass():
    lines = np.array([20.0, 35.0, 45.0])
    machine = soft_machine(lines)
    tip = joined_tip(tool_receptance([Segment(0.03, 0.05)], lines, STEEL), machine)
    mass = 7800.0 * math.pi / 4 * 0.05**2 * 0.03
    expected = 1.0 / (1.0 / machine[:, 0, 0] - mass * (2 * np.pi * lines) ** 2)
    assert tip[:, 0, 0] == pytest.approx(expected, rel=3e-3)
    assert tip[:, 4, 4] == pytest.approx(expected, rel=1e-9)


def test_a_rigid_machine_leaves_a_clamped_rod():
    still = Material(207e9, 7800.0, 0.3, 0.0)

    def stiffness(hz):
        lines = np.array([hz])
        tip = joined_tip(tool_receptance(ROD, lines, still), np.zeros((1, 5, 5), complex))
        return 1.0 / tip[0, 0, 0].real

    assert brentq(stiffness, 1200.0, 1600.0) == pytest.approx(1409.73, rel=1e-5)


def test_a_soft_joint_is_a_spring_in_series():
    lines = np.array([5.0])
    joint = with_joint(lines, np.array([1e6, np.inf, 1e6, np.inf, np.inf]), np.zeros(5))
    tool = tool_receptance(ROD, lines, STEEL)
    soft, rigid = (
        joined_tip(tool, np.zeros((1, 5, 5), complex), each)[0, 0, 0] for each in (joint, None)
    )
    assert soft.real == pytest.approx(rigid.real + 1e-6, rel=1e-3)


def test_rotations_out_of_two_points():
    """A rigid rod's two ends give the slopes of the rod itself."""
    lines = np.array([50.0, 90.0])
    rod = tool_receptance([Segment(0.03, 0.05)], lines, STEEL)
    spots = np.array([0, 2, 4])
    near, far = rod[:, spots[:, None], spots], rod[:, (5 + spots)[:, None], 5 + spots]
    cross = rod[:, spots[:, None], 5 + spots]
    found = with_rotations(near, cross, far, 0.03)
    assert found[:, :4, :4] == pytest.approx(rod[:, :4, :4], rel=1e-3)
    with pytest.raises(SettingsError):
        with_rotations(near, cross, far, 0.0)
