"""Where the files that ship with the package are: the source tree, or the installed share/."""

from pathlib import Path
import sys

from modal_core.errors import SettingsError

PACKAGE = 'autonomous_modal_analysis'


def share_path(*parts: str) -> Path:
    """Return the path of a shipped file, for example ``share_path('config', 'robots')``.

    Works from a source tree, an editable install, a pip install and a colcon install.

    Raises
    ------
    SettingsError
        It is in none of these places.
    """
    source_tree = Path(__file__).resolve().parents[1]
    # colcon: <prefix>/lib/pythonX.Y/site-packages/modal_core -> <prefix>/share/<package>
    prefixes = [Path(sys.prefix), *Path(__file__).resolve().parents]
    places = [source_tree, *(prefix / 'share' / PACKAGE for prefix in prefixes)]
    for place in places:
        candidate = place.joinpath(*parts)
        if candidate.exists():
            return candidate
    raise SettingsError('shipped file not found', where=Path(*parts), found=str(source_tree))
