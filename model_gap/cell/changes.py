"""Copies of a model or a chain of steps with one part changed."""

from collections.abc import Callable
import dataclasses

import numpy as np

from model_gap.campaign import Complex
from model_gap.cell.cell_model import Filter
from structural_model.description import JointSpec, LinkSpec, ModelSpec, Spring


def change_joint(
    spec: ModelSpec, name: str, change: Callable[[JointSpec], JointSpec]
) -> ModelSpec:
    """Return a spec with one joint changed."""
    return dataclasses.replace(
        spec, joints=tuple(change(item) if item.name == name else item for item in spec.joints)
    )


def change_drive(spec: ModelSpec, name: str, change: Callable[[Spring], Spring]) -> ModelSpec:
    """Return a spec with one drive's spring changed."""
    return change_joint(
        spec,
        name,
        lambda item: dataclasses.replace(
            item, drive=dataclasses.replace(item.drive, spring=change(item.drive.spring))
        ),
    )


def change_tilt(
    spec: ModelSpec, name: str, number: int, change: Callable[[Spring], Spring]
) -> ModelSpec:
    """Return a spec with one bearing spring changed."""
    return change_joint(
        spec,
        name,
        lambda item: dataclasses.replace(
            item,
            tilts=tuple(  # type: ignore[arg-type]
                change(spring) if place == number else spring
                for place, spring in enumerate(item.tilts)
            ),
        ),
    )


def offset_joint(spec: ModelSpec, name: str, amount: float) -> ModelSpec:
    """Return a spec in which a joint stands so much further than its encoder says [rad]."""
    return change_joint(
        spec, name, lambda item: dataclasses.replace(item, offset_rad=item.offset_rad + amount)
    )


def change_link(spec: ModelSpec, name: str, change: Callable[[LinkSpec], LinkSpec]) -> ModelSpec:
    """Return a spec with one link's corrections changed; made when there are none."""
    have = (
        spec.links
        if any(item.name == name for item in spec.links)
        else (
            *spec.links,
            LinkSpec(name),
        )
    )
    return dataclasses.replace(
        spec, links=tuple(change(item) if item.name == name else item for item in have)
    )


def gain_step(number: int, factor: float) -> Filter:
    """Return a step that scales one channel."""

    def step(omega: np.ndarray, spectra: Complex) -> Complex:
        scaled = spectra.copy()
        scaled[number] *= factor
        return scaled

    return step
