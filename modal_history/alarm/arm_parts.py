"""How the modes of a robot's model move when a part of it changes."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
import math

import numpy as np
from numpy.typing import NDArray

from modal_core.channel import Channel, SensorLayout
from modal_core.mode import Mode
from modal_core.numbers.assignment import cheapest_pairs
from modal_core.numbers.indicators import mac
from modal_history.alarm.suspects import Kind, LOAD_KG
from modal_history.kept import KeptWindow
from structural_model import FlexibleJointModel
from structural_model.description import MassSpec
from structural_model.equations import ModelModes

Array = NDArray[np.float64]
STEP = 1e-3
"""Share of a stiffness that a derivative is taken over; matrices are linear in it."""
ROUGH_FREQUENCY, ROUGH_SHAPE = 0.1, 0.2
"""How far a model may be from the arm: share of a frequency, 1 - MAC (as models before any
updating are; each pair costs the squares of both)."""
FARTHEST_PAIR = 9.0
LOAD_STEP_KG = 0.5
"""Loads nearer than this are one: it moves a sensitivity by less than a hundredth."""
LOAD = 'load_of_the_history'


@dataclass(frozen=True, slots=True)
class ModeTerms:
    """One mode over windows.

    Parameters
    ----------
    time_ns : (n,) array of int [ns]
        Ends of the windows.
    terms : (n, n_parts) array
        Change of the logarithm of its frequency for a unit change of each part.
    """

    time_ns: NDArray[np.int64]
    terms: Array


class ArmParts:
    """The parts of a robot's model that may change.

    Parameters
    ----------
    model : FlexibleJointModel
        The robot.
    layout : SensorLayout or None
        Its sensors: modes are told apart by shape too.
    """

    def __init__(self, model: FlexibleJointModel, layout: SensorLayout | None = None) -> None:
        self.model = model
        self._channels = {c.name: c for c in layout.channels} if layout else {}
        self._loaded: dict[float, FlexibleJointModel] = {0.0: model}

    @cached_property
    def parts(self) -> tuple[Kind, ...]:
        """Drives and bearings of joints, the base, all joints, the load."""
        return (*self._stiffnesses, Kind('load'))

    @cached_property
    def _stiffnesses(self) -> dict[Kind, tuple[str, ...]]:
        """Names of the parameters that each part has."""
        finite = {n for n, v in self.model.parameters().items() if math.isfinite(v) and v > 0.0}
        found: dict[Kind, tuple[str, ...]] = {}
        for joint in self.model.joint_names:
            names = f'joints.{joint}.drive.spring.stiffness'
            tilts = (f'joints.{joint}.tilts.{i}.stiffness' for i in range(2))
            found[Kind('drive', joint)] = (names,)
            found[Kind('bearing', joint)] = tuple(tilts)
        found[Kind('base')] = tuple(f'base.springs.{i}.stiffness' for i in range(6))
        springs = tuple(name for kind, names in found.items() if kind.place for name in names)
        found[Kind('all joints')] = springs
        there = {kind: tuple(n for n in names if n in finite) for kind, names in found.items()}
        return {kind: names for kind, names in there.items() if names}

    @cached_property
    def _derivatives(self) -> Array:
        """Change of K for a unit change of the logarithm of each stiffness; of no pose."""
        values, q = self.model.parameters(), np.zeros(self.model.n_joints)
        usual = self.model.matrices(q).K
        stepped = (
            self.model.with_parameters({n: (1.0 + STEP) * values[n] for n in names}).matrices(q).K
            for names in self._stiffnesses.values()
        )
        return np.array([(each - usual) / STEP for each in stepped])

    def terms(self, windows: Sequence[KeptWindow]) -> dict[int, ModeTerms]:
        """Return how each mode, by id, would move in the windows it was found in."""
        found: dict[int, list[tuple[int, Array]]] = {}
        for window in windows:
            for number, row in self._of_window(window).items():
                found.setdefault(number, []).append((window.end_ns, row))
        return {
            number: ModeTerms(np.array([t for t, _ in rows]), np.array([row for _, row in rows]))
            for number, rows in found.items()
        }

    def _of_window(self, window: KeptWindow) -> dict[int, Array]:
        pose, modes = window.pose, [m for m in window.modes if m.id > 0 and not m.harmonic]
        if pose is None or not modes or not set(self.model.joint_names) <= set(pose.joint_names):
            return {}
        columns = [pose.joint_names.index(name) for name in self.model.joint_names]
        q = np.asarray(pose.position)[columns]
        load_kg = _stepped(window.load_kg)
        model = self._with_load(load_kg)
        names = window.modes.channel_names
        placed = [(row, self._channels[n]) for row, n in enumerate(names) if n in self._channels]
        matrices = model.matrices(q)
        own = model.modes(q, [channel for _, channel in placed])
        heavier = self._with_load(load_kg + STEP * LOAD_KG).matrices(q)
        mass = (heavier.M - matrices.M) / STEP
        omega = 2.0 * np.pi * own.frequency_hz
        soft = np.einsum('im,pij,jm->mp', own.shapes, self._derivatives, own.shapes, optimize=True)
        heavy = np.einsum('im,ij,jm->m', own.shapes, mass, own.shapes, optimize=True)
        rows = 0.5 * np.column_stack([soft / omega[:, None] ** 2, -heavy])
        return {m.id: rows[place] for m, place in _pairs(modes, own, placed)}

    def _with_load(self, load_kg: float) -> FlexibleJointModel:
        """Return the model with a load where its last mass is, or at its last link."""
        if load_kg not in self._loaded:
            spec = self.model.spec
            last = spec.masses[-1] if spec.masses else MassSpec('', self.model.link_names[-1], 0.0)
            load = MassSpec(LOAD, last.link, load_kg, last.position_m)
            self._loaded[load_kg] = self.model.replace(replace(spec, masses=(*spec.masses, load)))
        return self._loaded[load_kg]


def _pairs(
    modes: Sequence[Mode], own: ModelModes, placed: Sequence[tuple[int, Channel]]
) -> list[tuple[Mode, int]]:
    """Return which mode of the model each mode is, where one is near enough."""
    seen = np.array([mode.frequency_hz for mode in modes])
    cost = (np.log(seen[:, None] / own.frequency_hz[None]) / ROUGH_FREQUENCY) ** 2
    shapes = np.array([[mode.shape[row] for row, _ in placed] for mode in modes]).T
    if len(placed) > 1 and np.isfinite(shapes).all():
        alike = np.array(mac(shapes, own.channel_shapes.astype(complex)))
        cost += ((1.0 - alike) / ROUGH_SHAPE) ** 2
    pairs = zip(*cheapest_pairs(np.minimum(cost, 1e6)), strict=True)
    return [(modes[row], int(place)) for row, place in pairs if cost[row, place] < FARTHEST_PAIR]


def _stepped(load_kg: float) -> float:
    """Return a load of which there are not too many; 0 where it is not known."""
    return LOAD_STEP_KG * round(load_kg / LOAD_STEP_KG) if math.isfinite(load_kg) else 0.0
