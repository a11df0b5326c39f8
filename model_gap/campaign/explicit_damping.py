"""Proportional damping written out at every spring, so that each can be changed on its own."""

import dataclasses

from structural_model import ModelSpec
from structural_model.description import Spring


def explicit_damping(spec: ModelSpec) -> ModelSpec:
    """Return the same arm with β·k moved into the dampers of all springs, and β = 0."""
    beta = spec.damping.stiffness_proportional_s
    if beta == 0.0:
        return spec

    def lossy(spring: Spring) -> Spring:
        if spring.rigid:
            return spring
        return Spring(spring.stiffness, spring.damping + beta * spring.stiffness)

    def each(items: tuple) -> tuple:  # type: ignore[type-arg]
        return tuple(dataclasses.replace(item, spring=lossy(item.spring)) for item in items)

    joints = tuple(
        dataclasses.replace(
            item,
            drive=dataclasses.replace(
                item.drive, spring=lossy(item.drive.spring), servo=lossy(item.drive.servo)
            ),
            tilts=(lossy(item.tilts[0]), lossy(item.tilts[1])),
        )
        for item in spec.joints
    )
    base = dataclasses.replace(
        spec.base,
        springs=tuple(lossy(item) for item in spec.base.springs),  # type: ignore[arg-type]
    )
    return dataclasses.replace(
        spec,
        joints=joints,
        base=base,
        hinges=each(spec.hinges),
        rods=each(spec.rods),
        absorbers=each(spec.absorbers),
        beams=tuple(
            dataclasses.replace(item, damping_s=item.damping_s + beta) for item in spec.beams
        ),
        damping=dataclasses.replace(spec.damping, stiffness_proportional_s=0.0),
    )
