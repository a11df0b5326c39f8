"""Where the files that ship with the package are: the source tree, or the installed share/."""

from pathlib import Path
import sys

from modal_core.errors import SettingsError
from modal_core.files.version import PACKAGE


def share_path(*parts: str) -> Path:
    """Return the path of a shipped file, for example ``share_path('config', 'robots')``.

    Works from a source tree, an editable install, a pip install and a colcon install.

    Raises
    ------
    SettingsError
        It is in none of these places.
    """
    source_tree = Path(__file__).resolve().parents[2]
    # <prefix>/lib/pythonX.Y/site-packages/modal_core -> <prefix>/share/<package>, of venvs, of
    # colcon and of pip --user; <target>/modal_core of pip --target.
    prefixes = [*Path(__file__).resolve().parents, Path(sys.prefix)]
    places = [prefix / 'share' / PACKAGE for prefix in prefixes]
    # Beside installed packages another project's folder may be called config.
    if (source_tree / 'package.xml').is_file():
        places.insert(0, source_tree)
    for place in places:
        candidate = place.joinpath(*parts)
        if candidate.exists():
            return candidate
    raise SettingsError('shipped file not found', where=Path(*parts), found=str(source_tree))
