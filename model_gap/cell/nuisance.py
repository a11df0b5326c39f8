"""What is known only to a percent or so: tolerances that must not be given a name.

Every tolerance is a standard normal number; the prior is its own standard deviation.
"""

from collections.abc import Callable
import dataclasses
from dataclasses import dataclass

import numpy as np

from model_gap.campaign import Complex
from model_gap.cell.cell_model import CellModel, Filter
from structural_model.spec import JointSpec, LinkSpec, ModelSpec, Spring


@dataclass(frozen=True)
class Tolerances:
    """One standard deviation of each kind of ordinary imperfection.

    Parameters
    ----------
    stiffness, damping, mass, inertia, gain : float
        Relative.
    centre_of_mass_m, sensor_position_m : float [m]
        Per axis.
    """

    stiffness: float = 0.02
    damping: float = 0.10
    mass: float = 0.015
    inertia: float = 0.025
    centre_of_mass_m: float = 0.005
    gain: float = 0.01
    sensor_position_m: float = 0.004


@dataclass(frozen=True)
class Nuisance:
    """One tolerance.

    Parameters
    ----------
    name : str
        What it is, for the report.
    kind : str
        ``spring``, ``spec`` (masses), ``position`` or ``gain``: how far its influence reaches.
    apply : callable
        (cell, standard deviations) -> cell.
    what : str
        ``stiffness`` or ``damping`` of a joint's drive, ``base``, ``mass`` of a link (or where it
        is), or nothing: what an effect may stand for.
    joint, link : str
        The joint whose drive it is of, the link whose mass, or nothing.
    sigma : float
        One standard deviation, relative.
    """

    name: str
    kind: str
    apply: Callable[[CellModel, float], CellModel]
    what: str = ''
    joint: str = ''
    link: str = ''
    sigma: float = 0.0


def nuisances(cell: CellModel, links: tuple[str, ...], size: Tolerances) -> tuple[Nuisance, ...]:
    """Return every tolerance of an arm and its sensors.

    Parameters
    ----------
    cell : CellModel
        Nominal.
    links : tuple of str
        Moving links that have inertia.
    size : Tolerances
        How large one standard deviation is.
    """
    found: list[Nuisance] = []
    for joint in cell.spec.joints:
        found += _joint(joint, size)
    for number, spring in enumerate(cell.spec.base.springs):
        if not spring.rigid:
            found.append(_base(number, size))
    for link in links:
        found += _link(link, size)
    for mass in cell.spec.masses:
        found.append(_mass(mass.name, size))
    for sensor in dict.fromkeys(channel.name.rsplit('.', 1)[0] for channel in cell.channels):
        found += [_position(sensor, axis, size) for axis in range(3)]
    for number, channel in enumerate(cell.channels):
        found.append(_gain(number, channel.name, size))
    return tuple(found)


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


def _spring_change(what: str, amount: float) -> Callable[[Spring], Spring]:
    factor = float(np.exp(amount))

    def change(spring: Spring) -> Spring:
        if what == 'stiffness':
            return Spring(spring.stiffness * factor, spring.damping)
        return Spring(spring.stiffness, spring.damping * factor)

    return change


def _joint(joint: JointSpec, size: Tolerances) -> list[Nuisance]:
    found = []
    for what, sigma in (('stiffness', size.stiffness), ('damping', size.damping)):
        if not joint.drive.spring.rigid:

            def drive(
                cell: CellModel, value: float, what: str = what, sigma: float = sigma
            ) -> CellModel:
                change = _spring_change(what, sigma * value)
                return cell.with_spec(change_drive(cell.spec, joint.name, change))

            name = f'{what} of {joint.name}'
            found.append(Nuisance(name, 'spring', drive, what, joint.name, sigma=sigma))
        for number, spring in enumerate(joint.tilts):
            if spring.rigid:
                continue

            def tilt(
                cell: CellModel,
                value: float,
                what: str = what,
                sigma: float = sigma,
                number: int = number,
            ) -> CellModel:
                change = _spring_change(what, sigma * value)
                return cell.with_spec(change_tilt(cell.spec, joint.name, number, change))

            found.append(Nuisance(f'{what} across {joint.name} ({number + 1})', 'spring', tilt))
    return found


def _base(number: int, size: Tolerances) -> Nuisance:
    def apply(cell: CellModel, value: float) -> CellModel:
        springs = list(cell.spec.base.springs)
        springs[number] = Spring(
            springs[number].stiffness * np.exp(size.stiffness * value), springs[number].damping
        )
        base = dataclasses.replace(
            cell.spec.base,
            springs=tuple(springs),  # type: ignore[arg-type]
        )
        return cell.with_spec(dataclasses.replace(cell.spec, base=base))

    return Nuisance(f'base stiffness {number}', 'spring', apply, 'base')


def _link(link: str, size: Tolerances) -> list[Nuisance]:
    def change(field: str, sigma: float) -> Callable[[CellModel, float], CellModel]:
        def apply(cell: CellModel, value: float) -> CellModel:
            return cell.with_spec(
                change_link(
                    cell.spec,
                    link,
                    lambda item: dataclasses.replace(
                        item, **{field: getattr(item, field) * np.exp(sigma * value)}
                    ),
                )
            )

        return apply

    def shift(axis: int) -> Callable[[CellModel, float], CellModel]:
        def apply(cell: CellModel, value: float) -> CellModel:
            def moved(item: LinkSpec) -> LinkSpec:
                place = list(item.com_shift_m)
                place[axis] += size.centre_of_mass_m * value
                return dataclasses.replace(item, com_shift_m=(place[0], place[1], place[2]))

            return cell.with_spec(change_link(cell.spec, link, moved))

        return apply

    found = [
        (f'mass of {link}', change('mass_factor', size.mass)),
        (f'inertia of {link}', change('inertia_factor', size.inertia)),
        *((f'centre of mass of {link} ({"xyz"[axis]})', shift(axis)) for axis in range(3)),
    ]
    return [Nuisance(name, 'spec', apply, 'mass', link=link) for name, apply in found]


def _mass(name: str, size: Tolerances) -> Nuisance:
    def apply(cell: CellModel, value: float) -> CellModel:
        masses = tuple(
            dataclasses.replace(item, mass_kg=item.mass_kg * np.exp(size.mass * value))
            if item.name == name
            else item
            for item in cell.spec.masses
        )
        return cell.with_spec(dataclasses.replace(cell.spec, masses=masses))

    return Nuisance(f'mass of {name}', 'spec', apply)


def _position(sensor: str, axis: int, size: Tolerances) -> Nuisance:
    def apply(cell: CellModel, value: float) -> CellModel:
        channels = []
        for channel in cell.channels:
            place = list(channel.position_m)
            if channel.name.rsplit('.', 1)[0] == sensor:
                place[axis] += size.sensor_position_m * value
            channels.append(
                dataclasses.replace(channel, position_m=(place[0], place[1], place[2]))
            )
        return dataclasses.replace(cell, channels=tuple(channels))

    return Nuisance(f'position of {sensor} ({"xyz"[axis]})', 'position', apply)


def gain_step(number: int, factor: float) -> Filter:
    """Return a step that scales one channel."""

    def step(omega: np.ndarray, spectra: Complex) -> Complex:
        scaled = spectra.copy()
        scaled[number] *= factor
        return scaled

    return step


def _gain(number: int, name: str, size: Tolerances) -> Nuisance:
    def apply(cell: CellModel, value: float) -> CellModel:
        return cell.then_output(gain_step(number, float(np.exp(size.gain * value))))

    return Nuisance(f'gain of {name}', 'gain', apply, sigma=size.gain)
