"""The result as gap.json: the keys of a vibration campaign where they mean the same."""

import math
from typing import Any

import numpy as np

from model_gap.trajectory.encoder_gap import (
    EncoderGap,
    gap_share,
    Law,
    left_share,
    noise_share,
    Quantity,
)
from model_gap.trajectory.gear_told import GearTold
from model_gap.trajectory.motion import BAND_HZ
from model_gap.trajectory.rival import Rival
from model_gap.trajectory.words import not_told, unexplained_lines
from structural_model.description import KnownEffect


def encoder_gap_mapping(gap: EncoderGap) -> dict[str, Any]:
    """Return the content of gap.json as plain values."""
    heldout = [item.name for item in gap.campaign.heldout]
    return {
        'verdict': gap.verdict.value,
        'campaign': 'encoders',
        'effects': [_law(law) for law in gap.laws],
        'quantities': {item.name: _quantity(item, heldout) for item in gap.quantities},
        'unexplained': unexplained_lines(gap),
        'not_told': not_told(gap),
        'band_hz': [0.0, BAND_HZ],
        'fitting': [item.name for item in gap.campaign.fitting],
        'heldout': heldout,
        'remarks': list(gap.campaign.remarks),
    }


def _law(law: Law) -> dict[str, Any]:
    return {
        'type': law.effect.type,
        'location': law.effect.location,
        'variant': law.effect.variant,
        'parameters': _parameters(law.effect),
        'parameters_of_fitted': _parameters(law.fitted),
        'parameters_of_heldout': _parameters(law.heldout),
        'log_evidence_gain': _number(law.gain),
        'heldout_gap_without': _number(law.without),
        'heldout_gap_with': _number(law.all_in),
        'rivals': list(law.rivals),
    }


def _parameters(effect: KnownEffect) -> dict[str, Any]:
    return {
        item.name: {
            'value': _number(item.value),
            'sigma': _number(item.sigma),
            'unit': item.unit,
        }
        for item in effect.parameters
    }


def _quantity(quantity: Quantity, heldout: list[str]) -> dict[str, Any]:
    return {
        'unit': 'N m' if quantity.name == 'torque' else 'rad',
        'axes': list(quantity.rows),
        'rms_before': {name: _numbers(values) for name, values in quantity.before.items()},
        'rms_after': {name: _numbers(values) for name, values in quantity.after.items()},
        'heldout_gap_after': _number(gap_share(quantity, heldout)),
        'heldout_gap_noise': _number(noise_share(quantity, heldout)),
        'heldout_left_of_measured': _number(left_share(quantity, heldout)),
        'rms_noise': {name: _numbers(values) for name, values in quantity.noise.items()},
        'gears_not_named': [_gear(item) for item in quantity.gears],
        'rival_from_data': [_rival(item) for item in quantity.rivals],
        'unconfirmed': [term.label for term in quantity.unconfirmed],
    }


def _gear(gear: GearTold) -> dict[str, Any]:
    return {
        'joint': gear.joint,
        'model_stiffness': _number(gear.model),
        'stiffness': {
            'value': _number(gear.stiffness),
            'sigma': _number(gear.sigma),
            'unit': 'N m/rad',
        },
        'least_stiffness': _number(gear.least),
        'within': _number(gear.within),
        'confirmed': gear.confirmed,
    }


def _rival(rival: Rival) -> dict[str, Any]:
    return {
        'rms_before': _number(rival.before),
        'rms_of_laws': _number(rival.laws),
        'rms_of_data_alone': _number(rival.alone),
        'rms_of_both': _number(rival.beside),
        'significance': _number(rival.significance),
        'beats_the_laws': rival.beats,
        'goes_with': {'input': rival.input[0], 'joint': rival.input[1]},
    }


def _numbers(values: np.ndarray) -> list[float | None]:
    return [_number(item) for item in values.tolist()]


def _number(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None
