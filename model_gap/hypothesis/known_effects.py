"""Effects a model already has: into its file, and out of it again."""

from collections.abc import Iterable, Sequence
import dataclasses
from itertools import groupby

import numpy as np
from numpy.typing import NDArray

from modal_core.channel import Sensor, SensorLayout
from modal_core.errors import ModelError
from modal_core.settings.near_names import misspelt, near
from model_gap.cell import CellModel
from model_gap.effects import CATALOGUE, delay_step, Effect, Scene
from model_gap.hypothesis.hypothesis import Hypothesis
from structural_model.description import KnownEffect, KnownNumber

DELAY = 'sensor_delay'
OF_SENSORS = ('sensor', 'gain')
# Of a direction: less is rounding.
LEAST_CHANGE = 1e-12
# Of a standard deviation, for derivatives of what is told: of the distance to the end of a cable,
# one over a number, they are 0.1 % off where σ of that number is as large as the number.
TOLD_STEP = 1e-3
Array = NDArray[np.float64]


def known_effects(hypothesis: Hypothesis, covariance: Array) -> tuple[KnownEffect, ...]:
    """Return the effects of a hypothesis as a model file keeps them.

    Parameters
    ----------
    hypothesis : Hypothesis
        Effects at their fitted values.
    covariance : (n_parameters, n_parameters) array
        Of all parameters, in the parameters' own units.
    """
    found, place = [], 0
    for effect, values in zip(hypothesis.effects, hypothesis.values(), strict=True):
        own = slice(place, place + len(values))
        place = own.stop
        told = effect.told(values, hypothesis.scene)
        here = np.array([item.value for item in told])
        sigmas = _deviations(effect, values, here, covariance[own, own], hypothesis.scene)
        numbers = tuple(
            KnownNumber(item.name, item.value, sigma, item.unit)
            for item, sigma in zip(told, sigmas, strict=True)
        )
        kept_in = _kept_in(effect, values, hypothesis.scene)
        found.append(
            KnownEffect(effect.type, effect.location or '', effect.variant, kept_in, numbers)
        )
    return tuple(found)


def _deviations(
    effect: Effect, values: Sequence[float], here: Array, covariance: Array, scene: Scene
) -> list[float]:
    """Return the standard deviations of what is told at some values, to first order."""
    deviation = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    steps = TOLD_STEP * np.where(np.isfinite(deviation) & (deviation > 0.0), deviation, 1.0)
    slope = np.empty((len(here), len(steps)))
    for number, step in enumerate(steps):
        moved = np.array(values, dtype=float)
        moved[number] += step
        there = np.array([item.value for item in effect.told(tuple(moved), scene)])
        slope[:, number] = (there - here) / step
    variance = np.einsum('ij,jk,ik->i', slope, covariance, slope)
    found: list[float] = np.sqrt(np.maximum(variance, 0.0)).tolist()
    return found


def _kept_in(effect: Effect, values: Sequence[float], scene: Scene) -> str:
    if effect.of_layout or effect.type == DELAY:
        return 'layout'
    cell = effect.apply(scene.cell, values, scene)
    only_arm = cell.with_spec(scene.cell.spec) == scene.cell
    return 'model' if only_arm else 'effects'


def corrected_layout(layout: SensorLayout, hypothesis: Hypothesis) -> SensorLayout:
    """Return a layout in which the sensors are what they were found to be.

    Parameters
    ----------
    layout : SensorLayout
        As it was given; sensors and axes that were not recorded may be among its own.
    hypothesis : Hypothesis
        Its effects of sensors that mix, scale or delay readings are taken over, and what it found
        within the tolerances of sensors.
    """
    scene = hypothesis.scene
    cell = CellModel(scene.cell.spec, layout.channels)
    for item, value in zip(hypothesis.tolerances, hypothesis.tolerance_values, strict=True):
        if item.kind in OF_SENSORS and value:
            cell = item.apply(cell, float(value))
    delay_s: dict[str, float] = {}
    for effect, values in zip(hypothesis.effects, hypothesis.values(), strict=True):
        if effect.of_layout:
            cell = effect.apply(cell, values, scene)
        elif effect.type == DELAY:
            name = str(effect.location).removeprefix('sensor:')
            delay_s[name] = delay_s.get(name, 0.0) + values[0]
    # The steps are linear and the same at every frequency: what they make of unit readings.
    count = len(layout.channels)
    mixing = cell.seen(np.zeros(count), np.eye(count, dtype=complex))
    directions = mixing.real @ np.array([channel.direction for channel in cell.channels])
    before = np.array([channel.direction for channel in layout.channels])
    changed = np.abs(directions - before).max(axis=1) > LEAST_CHANGE
    sensors, first = [], 0
    for sensor in layout:
        rows = slice(first, first + len(sensor.axes))
        turned = changed[rows].any()
        sensors.append(
            dataclasses.replace(
                _with_sensitivity(sensor, directions[rows]) if turned else sensor,
                position_m=cell.channels[first].position_m,
                delay_s=sensor.delay_s + delay_s.get(sensor.name, 0.0),
            )
        )
        first = rows.stop
    return SensorLayout(tuple(sensors), layout.name)


def _with_sensitivity(sensor: Sensor, rows: np.ndarray) -> Sensor:
    vectors = tuple((float(x), float(y), float(z)) for x, y, z in rows)
    return dataclasses.replace(
        sensor, sensitivity=vectors, rotation_quaternion=(0.0, 0.0, 0.0, 1.0)
    )


def with_known_effects(scene: Scene, catalogue: Iterable[type[Effect]] = CATALOGUE) -> CellModel:
    """Return the cell of a scene with what its model file keeps only as effects.

    Parameters
    ----------
    scene : Scene
        Of the model.
    catalogue : iterable of Effect types
        Those that are known by their names.

    Raises
    ------
    ModelError
        An effect the catalogue does not have, or one of its parameters is missing.
    """
    cell, types = scene.cell, {kind.type: kind for kind in catalogue}
    delays = [(channel.delay_s, row) for row, channel in enumerate(cell.channels)]
    for delay_s, group in groupby(delays, key=lambda item: item[0]):
        if delay_s:
            cell = cell.then_output(delay_step(delay_s, [row for _, row in group]))
    for known in cell.spec.effects:
        if known.kept_in != 'effects':
            continue
        if known.type not in types:
            slips, _ = misspelt([known.type], types)
            raise ModelError(
                'unknown effect',
                where='effects',
                found=known.type,
                expected=near(known.type, tuple(types)) if slips else None,
                advice='if it is one of your own, name its folder',
            )
        effect = types[known.type](known.location or None, known.variant)
        numbers = {item.name: item.value for item in known.parameters}
        if 'frequency' in numbers and not scene.lines_hz:
            scene = dataclasses.replace(scene, lines_hz=(numbers['frequency'],))
        items = effect.parameters(scene)
        detailed = effect.detailed()
        if detailed is not None and set(numbers) - {item.name for item in items}:
            effect, items = detailed, detailed.parameters(scene)
        wanted = [item.name for item in items]
        # Whether a number acts depends on the poses: where it does not, it is neutral.
        if (set(wanted) ^ set(numbers)) - set(effect.optional):
            raise ModelError(
                'parameters do not fit the effect',
                where=f'effects: {known.type}',
                found=', '.join(numbers),
                expected=', '.join(wanted),
            )
        neutral = {item.name: item.neutral for item in items}
        values = [{**neutral, **numbers}[name] for name in wanted]
        cell = effect.apply(cell, values, scene)
    return cell
