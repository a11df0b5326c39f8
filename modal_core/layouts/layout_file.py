"""A sensor layout in a file."""

from pathlib import Path

from modal_core.channel import SensorLayout
from modal_core.files.yaml_file import load_yaml


def layout_from_file(path: Path) -> SensorLayout:
    """Read a sensor layout; errors name the file.

    Raises
    ------
    SettingsError, LayoutError
        No such file, no YAML, or no layout.
    """
    return SensorLayout.from_mapping(load_yaml(path), str(path))
