"""A cut as people write it: millimetres, degrees, N/mm²."""

from dataclasses import dataclass
import math
from typing import Any

from modal_core.errors import SettingsError
from modal_core.settings.schema import check_settings, read_values, setting

WAYS = ('slot', 'up', 'down')
KINDS = ('receptance', 'mobility', 'accelerance')
"""Of a measured response: displacement, speed or acceleration over force."""
THEORIES = ('periods', 'mean')
NEEDED = ('n_teeth', 'diameter_mm', 'tangential_n_mm2', 'radial_n_mm2')


@dataclass(frozen=True, slots=True)
class CutSettings:
    """Cutter, engagement, material, range of speeds and depths.

    Parameters are listed beside their words below.
    """

    n_teeth: int = setting(0, 'teeth of the cutter', 1, 64)
    diameter_mm: float = setting(0.0, 'diameter of the cutter [mm]', 0.01, 10_000.0)
    tangential_n_mm2: float = setting(0.0, 'tangential cutting coefficient [N/mm²]', 1e-3, 1e6)
    radial_n_mm2: float = setting(0.0, 'radial cutting coefficient [N/mm²]', -1e6, 1e6)
    axial_n_mm2: float = setting(0.0, 'axial cutting coefficient [N/mm²]', -1e6, 1e6)
    tangential_edge_n_mm: float = setting(0.0, 'tangential edge coefficient [N/mm]', 0.0, 1e4)
    radial_edge_n_mm: float = setting(0.0, 'radial edge coefficient [N/mm]', -1e4, 1e4)
    axial_edge_n_mm: float = setting(0.0, 'axial edge coefficient [N/mm]', -1e4, 1e4)
    coefficients_std: float = setting(
        0.0, 'σ of the cutting coefficients, relative to their size', 0.0, 0.9
    )
    helix_deg: float = setting(0.0, 'helix angle [deg]', 0.0, 80.0)
    lead_deg: float = setting(90.0, 'angle of the edges to the machined face [deg]', 6.0, 90.0)
    way: str = setting('slot', 'slot, up or down milling')
    radial_depth_mm: float | None = setting(
        None, 'radial depth of cut [mm]', 1e-6, 10_000.0, 'the whole diameter'
    )
    min_speed_rpm: float = setting(2000.0, 'lowest spindle speed [rpm]', 1.0, 1e6)
    max_speed_rpm: float = setting(20_000.0, 'highest spindle speed [rpm]', 1.0, 1e6)
    n_speeds: int = setting(100, 'speeds looked at', 2, 5000)
    max_depth_mm: float = setting(10.0, 'deepest cut looked at [mm]', 1e-4, 1000.0)
    spindle_axis: tuple[float, ...] = setting(
        (0.0, 0.0, 1.0), 'from the work to the spindle, in the axes of the modes'
    )
    feed_axis: tuple[float, ...] = setting(
        (1.0, 0.0, 0.0), 'feed at 0 deg, in the axes of the modes'
    )
    feed_deg: tuple[float, ...] = setting((), 'feed directions looked at [deg]; none: 0 and 90')
    theory: str = setting(
        'periods', 'periods: semi-discretisation; mean: zeroth order alone, much faster'
    )
    n_samples: int = setting(40, 'samples for the chance of chatter; 0: none', 0, 100_000)
    risk: float = setting(0.05, 'chance of chatter that a proposal may have', 1e-4, 0.5)
    seed: int = setting(1, 'of the samples', 0, 2**63 - 1)

    @classmethod
    def from_mapping(cls, data: object, where: object = '') -> 'CutSettings':
        """Read a cut as YAML holds it.

        Raises
        ------
        SettingsError
            A name is unknown or missing, a value of another kind or out of range.
        """
        values: dict[str, Any] = read_values(cls, data, where)
        missing = [name for name in NEEDED if name not in values]
        if missing:
            raise SettingsError(
                'the cut is not known',
                where=where,
                advice=f'give {", ".join(missing)}, in a file or by options',
            )
        return cls(**values).checked()

    def checked(self) -> 'CutSettings':
        """Return the settings, which fit together.

        Raises
        ------
        SettingsError
            They do not.
        """
        check_settings(self)
        for name, value, known in (('way', self.way, WAYS), ('theory', self.theory, THEORIES)):
            if value not in known:
                raise SettingsError(
                    'unknown word', where=name, found=value, expected=', '.join(known)
                )
        if self.max_speed_rpm <= self.min_speed_rpm:
            raise SettingsError('no range of speeds', found=self.max_speed_rpm)
        if not all(math.isfinite(angle) for angle in self.feed_deg):
            raise SettingsError('not finite', where='feed_deg', found=self.feed_deg)
        return self
