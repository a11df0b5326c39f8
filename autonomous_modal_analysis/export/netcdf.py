"""The head of NetCDF 3 files, and texts in them."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from scipy.io import netcdf_file


@contextmanager
def netcdf(path: Path, about: Mapping[str, str]) -> Iterator[Any]:
    """Yield a NetCDF 3 file to write, with its conventions and where it comes from."""
    with netcdf_file(path, 'w') as file:
        file.Conventions = 'CF-1.8'
        for name, text in about.items():
            setattr(file, name, text.encode())
        yield file


def add_texts(file: Any, name: str, dimension: str, texts: Sequence[str]) -> None:
    """Add texts along a dimension, as rows of letters in UTF-8 with spaces behind."""
    letters = f'{name}_letter'
    coded = [text.encode() for text in texts]
    longest = max([1, *map(len, coded)])
    file.createDimension(letters, longest)
    variable = file.createVariable(name, 'c', (dimension, letters))
    for row, text in enumerate(coded):
        variable[row] = np.frombuffer(text.ljust(longest), dtype='S1')
