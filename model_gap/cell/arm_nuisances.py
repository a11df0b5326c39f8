"""Tolerances of an arm: springs, dampers, masses and where they are."""

from collections.abc import Callable, Sequence
import dataclasses
import math

from model_gap.cell.cell_model import CellModel
from model_gap.cell.changes import change_drive, change_link, change_tilt, offset_joint
from model_gap.cell.nuisance import Nuisance
from structural_model.description import JointSpec, LinkSpec, MassSpec, ModelSpec, Spring

Change = Callable[[CellModel, float], CellModel]
OfSpring = Callable[[Spring], Spring]


def joint_nuisances(joint: JointSpec, stiffness: float, damping: float) -> list[Nuisance]:
    """Return tolerances of a joint's drive and of what gives way across it."""
    found = []
    for what, sigma in (('stiffness', stiffness), ('damping', damping)):
        if not joint.drive.spring.rigid:
            change = _spring(what, _drive(joint.name))
            name = f'{what} of {joint.name}'
            found.append(Nuisance(name, 'spring', change, sigma, what=what, joint=joint.name))
        for number, spring in enumerate(joint.tilts):
            if not spring.rigid:
                change = _spring(what, _tilt(joint.name, number))
                name = f'{what} across {joint.name} ({number + 1})'
                found.append(Nuisance(name, 'spring', change, sigma))
    return found


def encoder_nuisance(joint: str, sigma_deg: float) -> Nuisance:
    """Return the tolerance of where a joint's encoder has its zero."""

    def apply(cell: CellModel, amount: float) -> CellModel:
        return cell.with_spec(offset_joint(cell.spec, joint, amount))

    sigma = math.radians(sigma_deg)
    return Nuisance(encoder_of(joint), 'pose', apply, sigma, 'rad', 'encoder', joint)


def encoder_of(joint: str) -> str:
    """Return the name of that tolerance."""
    return f'encoder of {joint}'


def base_nuisances(springs: Sequence[Spring], sigma: float) -> list[Nuisance]:
    """Return tolerances of the springs under the base."""
    return [
        Nuisance(
            f'base stiffness {number}',
            'spring',
            _spring('stiffness', _base(number)),
            sigma,
            what='base',
        )
        for number, spring in enumerate(springs)
        if not spring.rigid
    ]


def _spring(what: str, of: Callable[[ModelSpec, OfSpring], ModelSpec]) -> Change:
    def apply(cell: CellModel, amount: float) -> CellModel:
        factor = math.exp(amount)

        def change(spring: Spring) -> Spring:
            if what == 'stiffness':
                return Spring(spring.stiffness * factor, spring.damping)
            return Spring(spring.stiffness, spring.damping * factor)

        return cell.with_spec(of(cell.spec, change))

    return apply


def _drive(joint: str) -> Callable[[ModelSpec, OfSpring], ModelSpec]:
    return lambda spec, change: change_drive(spec, joint, change)


def _tilt(joint: str, number: int) -> Callable[[ModelSpec, OfSpring], ModelSpec]:
    return lambda spec, change: change_tilt(spec, joint, number, change)


def _base(number: int) -> Callable[[ModelSpec, OfSpring], ModelSpec]:
    def of(spec: ModelSpec, change: OfSpring) -> ModelSpec:
        springs = list(spec.base.springs)
        springs[number] = change(springs[number])
        base = dataclasses.replace(spec.base, springs=tuple(springs))  # type: ignore[arg-type]
        return dataclasses.replace(spec, base=base)

    return of


def link_nuisances(
    link: str, mass: float, inertia: float, centre_of_mass_m: float
) -> list[Nuisance]:
    """Return tolerances of a link's mass, of where it is, and of its inertia."""

    def scaled(field: str) -> Change:
        def apply(cell: CellModel, amount: float) -> CellModel:
            def change(item: LinkSpec) -> LinkSpec:
                value = getattr(item, field) * math.exp(amount)
                return dataclasses.replace(item, **{field: value})

            return cell.with_spec(change_link(cell.spec, link, change))

        return apply

    def shifted(axis: int) -> Change:
        def apply(cell: CellModel, amount: float) -> CellModel:
            def change(item: LinkSpec) -> LinkSpec:
                place = list(item.com_shift_m)
                place[axis] += amount
                return dataclasses.replace(item, com_shift_m=(place[0], place[1], place[2]))

            return cell.with_spec(change_link(cell.spec, link, change))

        return apply

    changes = (scaled('mass_factor'), scaled('inertia_factor'), *map(shifted, range(3)))
    return _of_body(link, link, changes, (mass, inertia, centre_of_mass_m))


def mass_nuisances(
    mass: MassSpec, size: float, inertia: float, centre_of_mass_m: float
) -> list[Nuisance]:
    """Return tolerances of a mass that is fixed to a link, those of a link: it is a part of it."""

    def changed(change: Callable[[MassSpec, float], MassSpec]) -> Change:
        def apply(cell: CellModel, amount: float) -> CellModel:
            masses = tuple(
                change(item, amount) if item.name == mass.name else item
                for item in cell.spec.masses
            )
            return cell.with_spec(dataclasses.replace(cell.spec, masses=masses))

        return apply

    def heavier(item: MassSpec, amount: float) -> MassSpec:
        return dataclasses.replace(item, mass_kg=item.mass_kg * math.exp(amount))

    def larger(item: MassSpec, amount: float) -> MassSpec:
        x, y, z = (radius * math.exp(0.5 * amount) for radius in item.gyration_m)
        return dataclasses.replace(item, gyration_m=(x, y, z))

    def shifted(axis: int) -> Callable[[MassSpec, float], MassSpec]:
        def change(item: MassSpec, amount: float) -> MassSpec:
            place = list(item.position_m)
            place[axis] += amount
            return dataclasses.replace(item, position_m=(place[0], place[1], place[2]))

        return change

    changes = (changed(heavier), changed(larger), *(changed(shifted(axis)) for axis in range(3)))
    found = _of_body(mass.name, mass.link, changes, (size, inertia, centre_of_mass_m))
    return found if any(mass.gyration_m) else [found[0], *found[2:]]


def _of_body(
    name: str, link: str, changes: Sequence[Change], sizes: tuple[float, float, float]
) -> list[Nuisance]:
    """Return tolerances of a body's mass and inertia, and of where it is along x, y and z."""
    mass, inertia, centre_of_mass_m = sizes
    heavier, larger, *shifted = changes
    found = [
        Nuisance(f'mass of {name}', 'spec', heavier, mass),
        Nuisance(f'inertia of {name}', 'spec', larger, inertia),
        *(
            Nuisance(f'centre of mass of {name} ({axis})', 'spec', shift, centre_of_mass_m, 'm')
            for axis, shift in zip('xyz', shifted, strict=True)
        ),
    ]
    return [dataclasses.replace(item, what='mass', link=link) for item in found]
