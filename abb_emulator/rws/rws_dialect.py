"""How a version of Robot Web Services words its requests.

Version 1.0 (RobotWare 6) puts the action into the query and the task beside it; version 2.0
(RobotWare 7) has a path for each.  Both end up as a path of version 2.0.

References
----------
ABB, Application manual Robot Web Services, 3HAC050973-001 (1.0) and 3HAC073675-001 (2.0).
"""

from collections.abc import Mapping
import re

from abb_emulator.rws.rws_pages import HAL, XHTML_2
from abb_emulator.rws.rws_refusal import (
    NO_SUCH_MEDIA,
    NOT_ACCEPTABLE,
    NOT_ALLOWED,
    RwsRefusalError,
)

FORM_2 = 'application/x-www-form-urlencoded;v=2.0'
FILES_2 = ('text/plain;v=2.0', 'application/octet-stream;v=2.0')
LEGACY_NAMES = {'/rw/panel/ctrlstate': '/rw/panel/ctrl-state'}
_MODULE = re.compile(r'/rw/rapid/modules(/[^/]+)?')
_SYMBOL = re.compile(r'/rw/rapid/symbol/data/(RAPID/.+)')
# What an action sets is named by its path alone.
_ACTIONS = {
    ('/rw/panel/ctrl-state', 'setctrlstate'): '/rw/panel/ctrl-state',
    ('/rw/panel/speedratio', 'setspeedratio'): '/rw/panel/speedratio',
    ('/rw/rapid/execution', 'setcycle'): '/rw/rapid/execution/cycle',
    ('/rw/rapid/symbols', 'search-symbols'): '/rw/rapid/symbols/search',
    ('/users/rmmp', ''): '/users/rmmp',
    ('/rw/mastership', ''): '/rw/mastership/request',
}
_SUFFIXES = {'/rw/iosystem/signals/': 'set-value', '/rw/rapid/symbol/': ''}


def shown_path_1(path: str, query: Mapping[str, str]) -> str:
    """Return the path of what a GET of version 1.0 asks for."""
    path = path.split(';')[0].rstrip('/')
    module = _MODULE.fullmatch(path)
    if module:
        task = query.get('task', '')
        end = '/text' if module[1] and query.get('resource') == 'module-text' else ''
        return f'/rw/rapid/tasks/{task}/modules{module[1] or ""}{end}'
    symbol = _SYMBOL.fullmatch(path)
    return f'/rw/rapid/symbol/{symbol[1]}/data' if symbol else LEGACY_NAMES.get(path, path)


def action_path_1(path: str, query: Mapping[str, str]) -> str:
    """Return the path of what a POST of version 1.0 asks for.

    Raises
    ------
    RwsRefusalError
        It names no action.
    """
    place, action = shown_path_1(path, query), query.get('action', '')
    if (place, action) in _ACTIONS:
        return _ACTIONS[place, action]
    for front, suffix in _SUFFIXES.items():
        if place.startswith(front) and action == 'set':
            return f'{place}/{suffix}'.rstrip('/')
    if not action or place.startswith('/rw/panel/'):
        raise RwsRefusalError('unknown action', found=action[:40])
    task, _, name = place.rpartition('/')
    if action in ('activate', 'deactivate') and task.endswith('/tasks'):
        return f'{task}/{action}' if name == 'T_ROB1' else f'{place}/{action}'
    return f'{place}/{action}'


def check_headers_2(method: str, path: str, headers: Mapping[str, str]) -> None:
    """Refuse what version 2.0 does not take for want of ``v=2.0``.

    Raises
    ------
    RwsRefusalError
        Another media type.
    """
    if not path.startswith('/fileservice'):
        accepted = [_plain(item) for item in headers.get('Accept', '*/*').split(',')]
        if not any(item in ('*/*', HAL, XHTML_2) for item in accepted):
            raise RwsRefusalError(
                'Server cannot generate response for given accept header', NOT_ACCEPTABLE
            )
    sent = _plain(headers.get('Content-Type', ''))
    if method == 'PUT' and path.startswith('/fileservice') and sent not in FILES_2:
        raise RwsRefusalError('Unsupported media type', NO_SUCH_MEDIA, found=sent[:80])
    if method == 'POST' and sent != FORM_2:
        raise RwsRefusalError('Unsupported media type', NO_SUCH_MEDIA, found=sent[:80])


def action_path_2(path: str, query: Mapping[str, str]) -> str:
    """Return the path of what a POST of version 2.0 asks for.

    Raises
    ------
    RwsRefusalError
        An action in the query: that was version 1.0.
    """
    if 'action' in query:
        raise RwsRefusalError('Method not allowed', NOT_ALLOWED)
    return path.rstrip('/')


def _plain(media: str) -> str:
    return media.replace(' ', '').lower()
