"""A set of effects with numbers, on an arm with tolerances."""

import dataclasses
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from model_gap.campaign import Complex
from model_gap.cell import CellModel, HeldTorque, Nuisance
from model_gap.effects import Effect, EffectParameter, Scene

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Hypothesis:
    """Effects and where the parameters stand.

    Parameters
    ----------
    scene : Scene
        Nominal arm and sensors.
    tolerances : tuple of Nuisance
        In the order of ``tolerance_values``.
    effects : tuple of Effect
        May be empty.
    tolerance_values : (n_tolerances,) array
        In prior standard deviations.
    inner : (n_parameters,) array
        Parameters of all effects, inner scale.
    held : tuple of HeldTorque
        Instead of the first torque laws, the scene's own and those of earlier effects: their
        torques as they were.
    """

    scene: Scene
    tolerances: tuple[Nuisance, ...]
    effects: tuple[Effect, ...]
    tolerance_values: Array
    inner: Array
    held: tuple[HeldTorque, ...] = ()

    @property
    def parameters(self) -> tuple[EffectParameter, ...]:
        """Parameters of all effects, in the order of ``inner``."""
        return tuple(item for effect in self.effects for item in effect.parameters(self.scene))

    @property
    def prior_scale(self) -> Array:
        """Prior standard deviation of every inner parameter."""
        return np.array([item.scale for item in self.parameters])

    @property
    def range(self) -> tuple[Array, Array]:
        """Least and most plausible inner parameters, (n_parameters,) each."""
        items = self.parameters
        low = [item.inner(item.low) if not item.log or item.low > 0 else -np.inf for item in items]
        return np.array(low), np.array([item.inner(item.high) for item in items])

    @property
    def scaled(self) -> Array:
        """Inner parameters in their prior scales."""
        return self.inner / self.prior_scale if len(self.inner) else np.zeros(0)

    def values(self) -> list[tuple[float, ...]]:
        """Return the physical values, one tuple per effect."""
        found, place = [], 0
        for effect in self.effects:
            items = effect.parameters(self.scene)
            found.append(
                tuple(
                    item.value(inner)
                    for item, inner in zip(
                        items, self.inner[place : place + len(items)], strict=True
                    )
                )
            )
            place += len(items)
        return found

    def with_effect(self, effect: Effect, values: tuple[float, ...]) -> 'Hypothesis':
        """Return a copy with one more effect."""
        items = effect.parameters(self.scene)
        inner = [item.inner(value) for item, value in zip(items, values, strict=True)]
        return dataclasses.replace(
            self, effects=(*self.effects, effect), inner=np.r_[self.inner, inner]
        )

    def without(self, index: int) -> 'Hypothesis':
        """Return a copy without one of its effects."""
        sizes = [len(effect.parameters(self.scene)) for effect in self.effects]
        start = sum(sizes[:index])
        keep = np.r_[self.inner[:start], self.inner[start + sizes[index] :]]
        effects = self.effects[:index] + self.effects[index + 1 :]
        return dataclasses.replace(self, effects=effects, inner=keep)

    def with_details(self) -> 'Hypothesis | None':
        """Return a copy whose last effect has more of its numbers free; None when it has none."""
        effect = self.effects[-1].detailed()
        if effect is None:
            return None
        neutral = [item.neutral for item in effect.parameters(self.scene)]
        last = len(self.effects) - 1
        known = self.values()[last]
        return self.without(last).with_effect(effect, (*known, *neutral[len(known) :]))

    def moved(self, tolerance_values: Array, inner: Array) -> 'Hypothesis':
        """Return a copy with other numbers, inner ones kept in their plausible range.

        Numbers of laws whose torques are held stay: nothing but their prior would pull at them.
        """
        waiting = len(self.held) - len(self.scene.cell.forces)
        stay: list[bool] = []
        for effect in self.effects:
            held = effect.amplitude_dependent and waiting > 0
            waiting -= held
            stay += [held] * len(effect.parameters(self.scene))
        inner = np.where(stay, self.inner, inner) if any(stay) else inner
        inside = np.clip(inner, *self.range)
        return dataclasses.replace(self, tolerance_values=tolerance_values, inner=inside)

    def stepped(self, step: Array) -> 'Hypothesis':
        """Return a copy moved by so many prior standard deviations, tolerances first."""
        size = len(self.tolerances)
        return self.moved(
            self.tolerance_values + step[:size], self.inner + step[size:] * self.prior_scale
        )

    def leaves(self, step: Array) -> NDArray[np.bool_]:
        """Return which numbers are at a bound that a step goes beyond, tolerances first."""
        low, high = self.range
        own = step[len(self.tolerances) :]
        stay = ((self.inner <= low) & (own < 0.0)) | ((self.inner >= high) & (own > 0.0))
        return np.asarray(np.r_[np.zeros(len(self.tolerances), dtype=bool), stay])

    @cached_property
    def tolerant(self) -> CellModel:
        """The cell with tolerances but without effects."""
        numbers = self.tolerance_values
        cell = self.scene.cell
        for item, value in zip(self.tolerances, numbers, strict=True):
            if value and item.kind != 'gain':
                cell = item.apply(cell, float(value))
        sizes = np.array(
            [
                item.sigma * value
                for item, value in zip(self.tolerances, numbers, strict=True)
                if item.kind == 'gain'
            ]
        )
        if sizes.any():
            factor = np.exp(sizes)[:, None]

            def step(omega: Array, spectra: Complex) -> Complex:
                return np.asarray(spectra * factor)

            cell = cell.then_output(step)
        return cell

    def add_effects(self, cell: CellModel) -> CellModel:
        """Return a cell with the effects added."""
        for effect, values in zip(self.effects, self.values(), strict=True):
            cell = effect.apply(cell, values, self.scene)
        if self.held:
            forces = cell.forces[len(self.held) :]
            cell = dataclasses.replace(cell, forces=forces, held=self.held)
        return cell

    def cell(self) -> CellModel:
        """Return the whole cell."""
        return self.add_effects(self.tolerant)
