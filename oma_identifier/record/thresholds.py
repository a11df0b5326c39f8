"""What windows must show of a mode of the record, in one place, with source or measure."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class RecordThresholds:
    """Limits of what windows and parts of a record must agree in."""

    # Windows show a mode of the record.
    least_windows: float = 3.0
    """Independent windows that show a mode of a record, at least."""
    least_share: float = 0.25
    """Their share of the record's time, at least: a false mode is in one of fifty windows."""
    same_mac: float = 0.8
    """Least MAC of the shapes of one mode in two windows."""

    # Windows, or quarters, of a mode differ beyond chance.
    varies_chance: float = 1e-3
    """Probability that windows of a mode that stays are taken to disagree."""
    degrees: float = 1e3
    """Degrees of freedom of the deviations stated by the windows: they are right to a few per
    cent."""
    smeared: float = 0.5
    """Half-power half-widths that a mode may move within a window: it widens the bell by 2 to 4
    %."""
    narrowest: float = 0.05
    """Half-width of the bell of a mode that drifts, over half the way it went: of 35 that did,
    0.12 to 5.6; of two beside modes that windows could not tell from them, 0.003 and 0.04."""
    fewest_parts: int = 3
    """Quarters of a short record that must show a mode."""
    reach: float = 0.05
    """Share of its frequency, two half-widths at least, in which a mode of a part is looked
    for."""


RECORD = RecordThresholds()
