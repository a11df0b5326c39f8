"""The three files a browser loads, in memory: no request ever reaches the disk."""

from pathlib import Path

from modal_reports import kit_script, kit_style

HERE = Path(__file__).resolve().parents[1] / 'static'
SCRIPTS = ('tables.js', 'screens.js', 'live.js')


def page_files() -> dict[str, tuple[str, bytes]]:
    """Return content type and content of each file, by its path."""
    texts = {
        '/': ('text/html', (HERE / 'live.html').read_text(encoding='utf-8')),
        '/live.css': ('text/css', kit_style([HERE / 'live.css'])),
        '/live.js': ('text/javascript', kit_script([HERE / name for name in SCRIPTS])),
    }
    return {path: (kind, text.encode()) for path, (kind, text) in texts.items()}
