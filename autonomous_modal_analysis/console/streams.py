"""Standard output and error as they are found: closed, full, or of few letters."""

import codecs
import os
import sys
from typing import TextIO

PLAIN = {
    '±': '+/-', 'σ': 'sigma', '°': 'deg', '²': '^2', '≥': '>=', '≤': '<=', 'µ': 'u', '–': '-',
    '−': '-',
}  # fmt: skip
HANDLER = 'autonomous_modal_analysis.plain'


def _plainly(error: UnicodeError) -> tuple[str | bytes, int]:
    if not isinstance(error, UnicodeEncodeError):
        raise error
    words = error.object[error.start : error.end]
    shown = (PLAIN.get(c, c.encode('ascii', 'backslashreplace').decode('ascii')) for c in words)
    return ''.join(shown), error.end


def prepare_streams() -> None:
    """Let every letter be written: in words or as its escape where the encoding lacks it."""
    codecs.register_error(HANDLER, _plainly)
    for name in ('stdout', 'stderr'):
        stream: TextIO | None = getattr(sys, name)
        if stream is None:
            # Closed by who started the process: results go nowhere, files are written.
            setattr(sys, name, open(os.devnull, 'w', encoding='utf-8'))  # noqa: PTH123
        elif hasattr(stream, 'reconfigure'):
            stream.reconfigure(errors=HANDLER)


def silence(stream: TextIO) -> None:
    """Let what is still unwritten vanish, so that the end of the process does not fail on it."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, stream.fileno())
    os.close(nowhere)
