"""How roughly a cell is known: one size of every kind of ordinary imperfection, or one by name."""

from collections.abc import Container, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
import math
from typing import Any

from modal_core.errors import SettingsError
from modal_core.settings.near_names import near
from model_gap.cell.arm_nuisances import (
    base_nuisances,
    encoder_nuisance,
    joint_nuisances,
    link_nuisances,
    mass_nuisances,
)
from model_gap.cell.cell_model import CellModel
from model_gap.cell.nuisance import Nuisance
from model_gap.cell.sensor_nuisances import sensor_nuisances


@dataclass(frozen=True)
class Tolerances:
    """One standard deviation of each kind of ordinary imperfection.

    Parameters
    ----------
    stiffness, damping, mass, inertia, gain : float
        Relative.  No damping is known better than its spring, unless it is stated by name.
    centre_of_mass_m, sensor_position_m : float [m]
        Per axis.
    sensor_rotation_deg : float [deg]
        Of a sensor's mount, about each axis.
    encoder_deg : float [deg]
        Of where a joint's encoder has its zero.  0.1 deg of a calibrated robot hardly show in
        vibration: 0 saves the time that they would take.
    by_name : dict of str to float
        Of single ones, ``stiffness of joint_2``: relative, in metres, or in degrees.
    """

    stiffness: float = 0.02
    damping: float = 0.10
    mass: float = 0.015
    inertia: float = 0.025
    centre_of_mass_m: float = 0.005
    gain: float = 0.01
    sensor_position_m: float = 0.004
    sensor_rotation_deg: float = 1.0
    encoder_deg: float = 0.0
    by_name: Mapping[str, float] = field(default_factory=dict)

    def stated(self, sizes: Mapping[str, object], where: str) -> 'Tolerances':
        """Return them with some stated otherwise, by kind or by name.

        Parameters
        ----------
        sizes : dict of str to number
            As a person wrote them.
        where : str
            For errors.

        Raises
        ------
        SettingsError
            Not a number, or beyond all use.
        """
        given = {name: _size(name, value, where) for name, value in sizes.items()}
        own = {name: size for name, size in given.items() if name not in KINDS}
        of_kind: dict[str, Any] = {name: size for name, size in given.items() if name in KINDS}
        return replace(self, **of_kind, by_name={**self.by_name, **own})


KINDS = tuple(item.name for item in fields(Tolerances) if item.name != 'by_name')
# Of a relative or a length [m], and of an angle [deg]: what is known less is not known at all.
LARGEST, LARGEST_DEG = 1.0, 30.0


def _size(name: str, value: object, where: str) -> float:
    try:
        size = float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError):
        size = math.nan
    angle = 'rotation' in name or 'encoder' in name
    largest = LARGEST_DEG if angle else LARGEST
    if isinstance(value, bool) or not 0.0 <= size <= largest:
        raise SettingsError(
            'not a tolerance',
            where=f'{where}: {name}',
            found=value,
            expected=f'0 to {largest:g}{" deg" if angle else ""}',
        )
    return size


def nuisances(cell: CellModel, links: tuple[str, ...], size: Tolerances) -> tuple[Nuisance, ...]:
    """Return every tolerance of an arm and its sensors; what has none is known exactly.

    There is a gain for every channel, in their order.

    Parameters
    ----------
    cell : CellModel
        Nominal.
    links : tuple of str
        Moving links that have inertia.
    size : Tolerances
        How large one standard deviation is.

    Raises
    ------
    SettingsError
        A tolerance is stated by a name that none has.
    """
    found: list[Nuisance] = []
    for joint in cell.spec.joints:
        found += joint_nuisances(joint, size.stiffness, size.damping)
        found.append(encoder_nuisance(joint.name, size.encoder_deg))
    found += base_nuisances(cell.spec.base.springs, size.stiffness)
    for link in links:
        found += link_nuisances(link, size.mass, size.inertia, size.centre_of_mass_m)
    for mass in cell.spec.masses:
        found += mass_nuisances(mass, size.mass, size.inertia, size.centre_of_mass_m)
    found += sensor_nuisances(
        cell.channels, size.sensor_position_m, size.sensor_rotation_deg, size.gain
    )
    names = [item.name for item in found]
    for name in size.by_name:
        if name not in names:
            raise SettingsError(
                'unknown tolerance', found=name, expected=near(name, (*KINDS, *names))
            )
    sized = [
        item.sized(size.by_name[item.name]) if item.name in size.by_name else item
        for item in found
    ]
    sized = _damping_no_better(sized, size.by_name)
    return tuple(item for item in sized if item.sigma > 0.0 or item.kind == 'gain')


def _damping_no_better(items: Sequence[Nuisance], stated: Container[str]) -> list[Nuisance]:
    """Return tolerances in which no damping is known better than its spring, unless it is stated.

    A model's dampers are guessed, or a loss factor times their springs.
    """
    sigma = {item.name: item.sigma for item in items}

    def known(item: Nuisance) -> Nuisance:
        if item.name in stated or not item.name.startswith('damping') or item.sigma == 0.0:
            return item
        spring = item.name.replace('damping', 'stiffness', 1)
        return replace(item, sigma=max(item.sigma, sigma[spring]))

    return [known(item) for item in items]
