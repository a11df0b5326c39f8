"""The version of the suite, as its installation tells."""

from importlib.metadata import PackageNotFoundError, version

PACKAGE = 'autonomous_modal_analysis'


def suite_version() -> str:
    """Return the installed version; a source tree that was never installed has none."""
    try:
        return version(PACKAGE)
    except PackageNotFoundError:
        return 'not installed'


def software() -> str:
    """Return name and version, as results tell what has written them."""
    return f'{PACKAGE} {suite_version()}'
