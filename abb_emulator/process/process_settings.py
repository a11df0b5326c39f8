"""What the spindle does, in the units of workshops."""

from dataclasses import dataclass
import math

from modal_core.errors import SettingsError
from modal_core.settings.schema import setting


@dataclass(frozen=True, slots=True)
class ProcessSettings:
    """Spindle and cut at the tool of the arm; a standing spindle does nothing.

    Parameters
    ----------
    speed_rpm, speed_rate_rpm_s : float [rpm], [rpm/s]
        Spindle speed at the beginning and its rise; 0: there is no process.
    unbalance_g_mm : float [g mm]
    bearing_orders : tuple of float
        Orders of the spindle's speed at which bearings push.
    bearing_n : float [N]
        Amplitude of each.
    n_teeth, diameter_mm, runout_um
        Of the cutter.
    way, radial_depth_mm, depth_mm, feed_mm
        Of the cut: ``up`` or ``down``; feed per tooth.  Depth 0: nothing is cut.
    tangential_n_mm2, radial_n_mm2, tangential_edge_n_mm, radial_edge_n_mm
        Of the material.
    regeneration : bool
        The tool cuts the waves it has left.
    background_n : float [N]
        Standard deviation of the force of chips that break, white up to half the sample rate.
    frame, position_m, spindle_axis, feed_axis
        Where the tool is, from the work to the spindle, and along the feed, in the frame's axes.
    seed : int
        Of the background.
    """

    speed_rpm: float = setting(
        0.0, 'spindle speed at the beginning [rpm]; 0 has no process', 0, 1e6
    )
    speed_rate_rpm_s: float = setting(0.0, 'rise of the spindle speed [rpm/s]', -1e5, 1e5)
    unbalance_g_mm: float = setting(0.0, 'unbalance of the spindle [g mm]', 0.0, 1e9)
    bearing_orders: tuple[float, ...] = setting(
        (0.0, 0.0, 0.0), 'orders of the spindle speed at which bearings push; 0: none', 0.0, 1e3
    )
    bearing_n: float = setting(0.0, 'force of each of these orders [N]', 0.0, 1e6)
    n_teeth: int = setting(2, 'teeth of the cutter', 1, 64)
    diameter_mm: float = setting(12.0, 'diameter of the cutter [mm]', 0.01, 1e4)
    runout_um: float = setting(0.0, 'distance of cutter and spindle axis [µm]', 0.0, 1e4)
    way: str = setting('up', 'up or down milling')
    radial_depth_mm: float = setting(6.0, 'radial depth of cut [mm]', 1e-4, 1e4)
    depth_mm: float = setting(0.0, 'axial depth of cut [mm]; 0 cuts nothing', 0.0, 1e3)
    feed_mm: float = setting(0.05, 'feed per tooth [mm]', 0.0, 100.0)
    tangential_n_mm2: float = setting(800.0, 'tangential cutting coefficient [N/mm²]', 0.0, 1e6)
    radial_n_mm2: float = setting(250.0, 'radial cutting coefficient [N/mm²]', -1e6, 1e6)
    tangential_edge_n_mm: float = setting(10.0, 'tangential edge coefficient [N/mm]', 0.0, 1e4)
    radial_edge_n_mm: float = setting(10.0, 'radial edge coefficient [N/mm]', -1e4, 1e4)
    regeneration: bool = setting(True, 'the tool cuts the waves it has left')
    background_n: float = setting(0.0, 'σ of the force of breaking chips, white [N]', 0.0, 1e6)
    frame: str = setting('flange', 'link that holds the spindle')
    position_m: tuple[float, ...] = setting((0.35, 0.0, 0.0), 'place of the tool in it [m]')
    spindle_axis: tuple[float, ...] = setting((-1.0, 0.0, 0.0), 'from the work to the spindle')
    feed_axis: tuple[float, ...] = setting((0.0, 1.0, 0.0), 'along the feed')
    seed: int = setting(1, 'of the background', 0, 2**63 - 1)

    @property
    def active(self) -> bool:
        """The spindle turns."""
        return self.speed_rpm > 0.0

    @property
    def engagement_rad(self) -> tuple[float, float]:
        """Angles at which a tooth enters and leaves the work [rad].

        Raises
        ------
        SettingsError
            The way is unknown, or the cut wider than the cutter.
        """
        share = self.radial_depth_mm / self.diameter_mm
        if share > 1.0:
            raise SettingsError(
                'wider than the cutter',
                where='process.radial_depth_mm',
                found=self.radial_depth_mm,
                expected=f'at most {self.diameter_mm:g}',
            )
        if self.way == 'up':
            return 0.0, math.acos(1.0 - 2.0 * share)
        if self.way == 'down':
            return math.acos(2.0 * share - 1.0), math.pi
        raise SettingsError(
            'unknown word', where='process.way', found=self.way, expected='up, down'
        )
