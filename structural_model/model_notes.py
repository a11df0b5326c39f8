"""What of a model its user should know: what it leaves out, and what looks like a wrong unit."""

from collections.abc import Iterator

from structural_model.arm_description import ArmDescription

FARTHEST_REACH_M = 100.0
"""Arms are shorter; one of 0.1 m whose URDF is in millimetres is longer."""
HEAVIEST_LINK_KG = 10_000.0
"""About what the heaviest industrial robots weigh as a whole."""


def model_notes(model: ArmDescription) -> tuple[str, ...]:
    """Return what its user should know of a model, one line each.

    Parameters
    ----------
    model : ArmDescription
        As it was read.
    """
    return (*_rigid(model), *_units(model))


def _rigid(model: ArmDescription) -> Iterator[str]:
    """Tell which joints are rigid where others are not: a wholly rigid arm is meant to be."""
    rigid = [joint.name for joint in model.spec.joints if joint.drive.spring.rigid]
    if 0 < len(rigid) < len(model.spec.joints):
        yield f'no drive stiffness, so rigid: {", ".join(rigid)}'


def _units(model: ArmDescription) -> Iterator[str]:
    reach_m = model.robot.reach_m
    if reach_m > FARTHEST_REACH_M:
        yield f'the joints of the URDF reach {reach_m:.4g} m: are its lengths in metres?'
    for name, inertia in zip(model.robot.model.names, model.robot.model.inertias, strict=True):
        if inertia.mass > HEAVIEST_LINK_KG:
            yield f'what {name} moves weighs {inertia.mass:.4g} kg: is it in kilograms?'
