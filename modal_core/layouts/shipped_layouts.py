"""Where the sensors of a shipped robot are, for channels that say no more than their names."""

from collections.abc import Iterable
from functools import lru_cache
import re

from modal_core.channel import SensorLayout
from modal_core.errors import ModalAnalysisError
from modal_core.files.share import share_path
from modal_core.layouts.layout_file import layout_from_file

# A name that came over a network or out of a file is no path.
PLAIN_NAME = re.compile(r'(?!\.)[A-Za-z0-9_.-]{1,100}')


def shipped_layout(robot_name: str, channel_names: Iterable[str]) -> SensorLayout | None:
    """Return the layout of a robot of config/robots that places all these channels.

    Parameters
    ----------
    robot_name : str
        As a plan or a robot's description has it.
    channel_names : iterable of str
        All must be in the layout: where some are not, the others need not be those.
    """
    wanted = set(channel_names)
    for layout in _layouts(robot_name):
        if wanted and wanted <= {channel.name for channel in layout.channels}:
            return layout
    return None


@lru_cache(maxsize=8)
def _layouts(robot_name: str) -> tuple[SensorLayout, ...]:
    if not PLAIN_NAME.fullmatch(robot_name):
        return ()
    try:
        folder = share_path('config', 'robots') / robot_name
        return tuple(layout_from_file(path) for path in sorted(folder.glob('sensors*.yaml')))
    except ModalAnalysisError:
        return ()
