"""The comparison as plain values for gap.json."""

import dataclasses
import math
from typing import Any

from model_gap.comparison.compare import ModelComparison
from model_gap.modes import ModelMode, ModePair


def comparison_mapping(comparison: ModelComparison) -> dict[str, Any]:
    """Return all tables; what is not a number becomes null."""
    return {
        'excitation': _plain(comparison.excitation)
        | {
            'bands': [
                {**_plain(band), 'noise_share': _plain(band.noise_share)}
                for band in comparison.excitation.bands
            ]
        },
        'modes': [_mode(pair) for pair in comparison.modes],
        'sensors': [_plain(item) for item in comparison.sensors],
        'amplitude_dependence': [
            {**_plain(item), 'deviations': _plain(item.deviations)} for item in comparison.levels
        ],
        'lines': [_plain(item) for item in comparison.lines],
    }


def _mode(pair: ModePair) -> dict[str, Any]:
    mode = pair.mode
    return {
        'record': pair.record,
        'level': pair.level,
        'pose': pair.pose,
        'heldout': pair.heldout,
        'frequency_hz': _plain(mode.frequency_hz),
        'frequency_sigma_hz': _plain(mode.frequency_std_hz),
        'damping_ratio': _plain(mode.damping_ratio),
        'damping_ratio_sigma': _plain(mode.damping_ratio_std),
        'before': _model(pair, pair.before),
        'after': _model(pair, pair.after),
    }


def _model(pair: ModePair, model: ModelMode | None) -> dict[str, Any] | None:
    if model is None:
        return None
    return {**_plain(model), 'deviations': _plain(pair.deviations(model))}


def _plain(value: Any) -> Any:
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {
            field.name: _plain(getattr(value, field.name)) for field in dataclasses.fields(value)
        }
    if isinstance(value, tuple | list):
        return [_plain(item) for item in value]
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return value
