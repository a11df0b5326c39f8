"""Sensors that were moved between recordings: each recording's own layout, and one of all."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from modal_core.channel import Sensor, SensorLayout
from modal_core.layouts.layout_file import layout_from_file
from model_gap.campaign.campaign_file import CampaignEntry
from model_gap.campaign.series import Series


@dataclass(frozen=True)
class SetUps:
    """Sensor layouts of a campaign.

    A sensor that stands elsewhere in another set-up counts as one more sensor there: its mount is
    another one.

    Parameters
    ----------
    whole : SensorLayout
        All sensors at all places.
    layouts : dict of Path or None to SensorLayout
        By file, as recorded; None: of the recordings that name none.
    names : dict of Path or None to dict of str to str
        By file, what each channel is called in the whole.
    """

    whole: SensorLayout
    layouts: dict[Path | None, SensorLayout] = field(default_factory=dict)
    names: dict[Path | None, dict[str, str]] = field(default_factory=dict)

    @classmethod
    def of(cls, entries: Sequence[CampaignEntry], common: Callable[[], SensorLayout]) -> 'SetUps':
        """Return the layouts of some recordings.

        Parameters
        ----------
        entries : sequence of CampaignEntry
            Of a campaign.
        common : callable
            Gives the layout of recordings that have none of their own.

        Raises
        ------
        SettingsError, LayoutError
            A layout is missing or malformed.
        """
        layouts = {
            path: common() if path is None else layout_from_file(path)
            for path in dict.fromkeys(entry.layout for entry in entries)
        }
        sensors: dict[str, Sensor] = {}
        names: dict[Path | None, dict[str, str]] = {}
        for path, layout in layouts.items():
            names[path] = {}
            for sensor in layout:
                name = _name(sensor, path, sensors)
                sensors[name] = replace(sensor, name=name)
                names[path] |= {f'{sensor.name}.{axis}': f'{name}.{axis}' for axis in sensor.axes}
        first = next(iter(layouts.values()))
        return cls(SensorLayout(tuple(sensors.values()), first.name), layouts, names)

    def own(self, entry: CampaignEntry) -> SensorLayout:
        """Return the layout of a recording, as it was recorded."""
        return self.layouts[entry.layout]

    def in_whole(self, entry: CampaignEntry, series: Series) -> Series:
        """Return a recording's series with its channels called as in the whole."""
        names = self.names[entry.layout]
        return replace(series, names=tuple(names[name] for name in series.names))


def _name(sensor: Sensor, path: Path | None, known: dict[str, Sensor]) -> str:
    """Return a sensor's own name, or with its set-up where one of that name stands elsewhere."""
    name, number = sensor.name, 1
    while name in known and known[name] != replace(sensor, name=name):
        set_up = '' if path is None else path.stem
        name = f'{sensor.name}@{set_up}' if number == 1 else f'{sensor.name}@{set_up}_{number}'
        number += 1
    return name
