"""Packages only some need: pandas for tables, matplotlib for pictures, distributed for batches."""

from importlib import import_module
from typing import Any

from autonomous_modal_analysis.missing import MissingError

EXTRAS = {'pandas': 'tables', 'matplotlib': 'plots', 'pyarrow': 'parquet', 'distributed': 'batch'}


def optional(module: str) -> Any:
    """Import a module of an optional package.

    Raises
    ------
    MissingError
        The package is not installed; names what installs it.
    """
    package = module.partition('.')[0]
    try:
        return import_module(module)
    except ModuleNotFoundError as error:
        if (error.name or '').partition('.')[0] != package:
            raise
        raise MissingError(
            f'{package} is not installed',
            advice=f'install it with: pip install {package}, or the suite with its extra'
            f' [{EXTRAS[package]}]',
        ) from error
