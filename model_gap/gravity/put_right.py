"""Put right what gravity tells: recordings' units and columns, and where the arm stands."""

from collections.abc import Sequence
import dataclasses

import numpy as np

from modal_core.channel import SensorLayout
from model_gap.campaign import Campaign, GapRecord
from model_gap.cell import encoder_of, offset_joint, Tolerances
from model_gap.gravity.at_rest import G_M_S2, tilted
from model_gap.gravity.faults import Fault, Kind
from model_gap.gravity.usual import USUAL
from structural_model import FlexibleJointModel


def put_right(campaign: Campaign, faults: Sequence[Fault]) -> Campaign:
    """Return a campaign with its units put right, and what was exchanged changed back."""
    channels = campaign.layout.channels
    factor = np.array([G_M_S2 if _in_g(faults, it.sensor) else 1.0 for it in channels])
    exchanges = [fault for fault in faults if fault.kind in (Kind.SENSORS, Kind.JOINTS)]
    if (factor == 1.0).all() and not exchanges:
        return campaign

    def right(record: GapRecord) -> GapRecord:
        record = dataclasses.replace(record, acceleration=record.acceleration * factor)
        for fault in exchanges:
            record = _changed_back(record, fault, [it.sensor for it in channels])
        return record

    return dataclasses.replace(campaign, records=tuple(map(right, campaign.records)))


def _changed_back(record: GapRecord, fault: Fault, sensors: Sequence[str]) -> GapRecord:
    if fault.kind is Kind.JOINTS:
        return dataclasses.replace(
            record,
            pose=fault.exchanged(record.pose[None])[0],
            motor_acceleration=fault.exchanged(record.motor_acceleration),
            motor_velocity=fault.exchanged(record.motor_velocity),
            motor_shift=fault.exchanged(record.motor_shift),
        )
    # Sensors that show no gravity have no columns where faults are weighed.
    columns = [n for name in fault.between for n, sensor in enumerate(sensors) if sensor == name]
    whole = dataclasses.replace(fault, columns=tuple(columns))
    return dataclasses.replace(record, acceleration=whole.exchanged(record.acceleration))


def right_units(layout: SensorLayout, faults: Sequence[Fault]) -> SensorLayout:
    """Return a layout that says which sensors read in g."""
    sensors = [
        dataclasses.replace(sensor, unit='g') if _in_g(faults, sensor.name) else sensor
        for sensor in layout
    ]
    return SensorLayout(tuple(sensors), layout.name)


def _in_g(faults: Sequence[Fault], sensor: str) -> bool:
    return any(fault.kind is Kind.UNIT and fault.place == sensor for fault in faults)


def as_it_stands(model: FlexibleJointModel, faults: Sequence[Fault]) -> FlexibleJointModel:
    """Return a model whose joints and base stand as gravity tells."""
    spec = model.spec
    for fault in faults:
        if fault.kind is Kind.ENCODER:
            spec = offset_joint(spec, fault.place, fault.values[0])
        elif fault.kind is Kind.TILT:
            spec = tilted(spec, fault.values)
    return model if spec is model.spec else dataclasses.replace(model, spec=spec)


def left_open(tolerances: Tolerances, faults: Sequence[Fault]) -> Tolerances:
    """Return tolerances of the encoders that read wrong: vibration tells more of them.

    Of two that gravity cannot tell apart, either may have the whole offset.
    """
    open_ = {}
    for fault in faults:
        for item in (fault, fault.rival):
            if item is not None and item.kind is Kind.ENCODER:
                spread = item.sigma if fault.rival is None else abs(item.values[0])
                open_[encoder_of(item.place)] = float(np.degrees(max(spread, USUAL.encoder_rad)))
    return dataclasses.replace(tolerances, by_name={**tolerances.by_name, **open_})
