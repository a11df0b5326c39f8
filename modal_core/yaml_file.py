"""Read YAML that may come from anywhere: size-capped, safe, one clear error."""

from pathlib import Path

import yaml

from modal_core.errors import SettingsError

LARGEST_FILE_BYTES = 2_000_000


def load_yaml(path: Path) -> dict[str, object]:
    """Return the mapping a YAML file holds.

    Raises
    ------
    SettingsError
        The file is missing, too large, not YAML, uses aliases, or is not a mapping.
    """
    try:
        size = path.stat().st_size
        if size > LARGEST_FILE_BYTES:
            raise SettingsError(
                'file too large', where=path, found=size, expected=f'<= {LARGEST_FILE_BYTES} bytes'
            )
        text = path.read_text(encoding='utf-8')
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, 'strerror', None) or error
        raise SettingsError(f'cannot be read: {reason}', where=path) from error
    try:
        # Aliases are how a few lines become gigabytes; no file of ours needs them.
        if any(isinstance(event, yaml.AliasEvent) for event in yaml.parse(text)):
            raise SettingsError('YAML aliases are not accepted', where=path)
        data = yaml.safe_load(text)
    except (yaml.YAMLError, ValueError, RecursionError) as error:
        raise SettingsError(f'not YAML: {error}', where=path) from error
    if not isinstance(data, dict):
        raise SettingsError('not a mapping', where=path, found=type(data).__name__)
    return data
