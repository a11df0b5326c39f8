"""Settings of the identifier as keywords."""

from dataclasses import fields
from typing import Any, TypedDict

from modal_core.settings.near_names import refuse_unknown
from oma_identifier.settings import IdentificationSettings


class Settings(TypedDict, total=False):
    """Keywords of an identification: the fields of :class:`IdentificationSettings`."""

    window_s: float
    hop_s: float | None
    min_frequency_hz: float | None
    max_frequency_hz: float | None
    min_order: int
    max_order: int
    block_rows: int | None
    n_references: int | None
    max_damping_ratio: float
    method: str
    memory_s: float | None
    refine: bool | None
    gyroscopes: bool
    known_motion: bool


def checked_settings(given: Any) -> IdentificationSettings:
    """Return settings from keywords.

    Raises
    ------
    SettingsError
        A keyword that is none of the settings, or a value of another kind or out of range.
    """
    known = [field.name for field in fields(IdentificationSettings)]
    refuse_unknown(given, known, 'unknown setting')
    return IdentificationSettings(**given)
