"""Subscriptions: a client is told by websocket when a resource changes."""

import asyncio
from collections.abc import Callable, Mapping
from dataclasses import dataclass
import re

from aiohttp import web

from abb_emulator.rws.rws_pages import event_item, linked_page
from abb_emulator.rws.rws_refusal import RwsRefusalError, unknown
from abb_emulator.rws.rws_resources import Shown

# Assumed: no figure of a controller is published.
LOOK_S = 0.05
"""How often changes are looked for; a controller may take longer."""
MOST_SUBSCRIPTIONS, MOST_RESOURCES = 19, 64
ELOG = '/rw/elog/0'
_WITH_FIELD = re.compile(r'(?P<path>[^;]+?)(?:;(?P<field>\w+))?/?')
# Event class and the field it tells, by how the path of the resource begins.
KINDS = (
    ('/rw/panel/ctrl', 'pnl-ctrlstate-ev', 'ctrlstate', 'ctrlstate'),
    ('/rw/panel/opmode', 'pnl-opmode-ev', 'opmode', 'opmode'),
    ('/rw/panel/speedratio', 'pnl-speedratio-ev', 'speedratio', 'speedratio'),
    ('/rw/rapid/execution;rapidexec', 'rap-execcycle-ev', 'cycle', 'rapidexeccycle'),
    ('/rw/rapid/execution', 'rap-ctrlexecstate-ev', 'ctrlexecstate', 'ctrlexecstate'),
    ('/rw/iosystem/signals/', 'ios-signalstate-ev', 'lvalue', 'lvalue'),
    ('/rw/rapid/symbol/', 'rap-data', 'value', 'value'),
)


@dataclass(slots=True)
class Watched:
    """One resource of a subscription.

    Parameters
    ----------
    uri : str
        As the client named it.
    kind : str
        Class of its events.
    read, told : str
        Field that is read, and what the event calls it.
    last : str or None
        Told last.
    """

    uri: str
    kind: str
    read: str
    told: str
    last: str | None = None


class Subscriptions:
    """The subscriptions of one server.

    Parameters
    ----------
    show : callable
        Returns what stands at a path as the client words it.
    protocol : str
        Of the websocket.
    """

    def __init__(self, show: Callable[[str], Shown], protocol: str) -> None:
        self._show, self._protocol = show, protocol
        self._groups: dict[int, list[Watched]] = {}
        self._n_made = 0

    def add(self, form: Mapping[str, str], identifiers: list[str]) -> int:
        """Make a subscription; return its number.

        Raises
        ------
        RwsRefusalError
            Too many, or of something that is not there.
        """
        if len(self._groups) >= MOST_SUBSCRIPTIONS or len(identifiers) > MOST_RESOURCES:
            raise RwsRefusalError('too many subscriptions')
        group = [self._watched(form.get(identifier, '')) for identifier in identifiers]
        if not group:
            raise RwsRefusalError('no resources')
        self._n_made += 1
        self._groups[self._n_made] = group
        return self._n_made

    def remove(self, number: int) -> None:
        """End a subscription.

        Raises
        ------
        RwsRefusalError
            There is none.
        """
        if self._groups.pop(number, None) is None:
            raise unknown('Subscription')

    async def tell(self, number: int, request: web.Request) -> web.StreamResponse:
        """Send the changes of a subscription until the client goes.

        Raises
        ------
        RwsRefusalError
            There is no such subscription, or the websocket has another protocol.
        """
        group = self._groups.get(number)
        if group is None:
            raise unknown('Subscription')
        if self._protocol not in request.headers.get('Sec-WebSocket-Protocol', ''):
            raise RwsRefusalError('unknown protocol')
        socket = web.WebSocketResponse(protocols=(self._protocol,), heartbeat=30.0)
        await socket.prepare(request)
        listener = asyncio.ensure_future(_until_closed(socket))
        try:
            while not socket.closed and number in self._groups and not listener.done():
                items = [item for one in group for item in self._changes(one)]
                for item in items:
                    links = {'group': f'subscription/{number}'}
                    await socket.send_str(linked_page(links, f'<ul>{item}</ul>'))
                await asyncio.sleep(LOOK_S)
        except ConnectionError:
            pass
        finally:
            listener.cancel()
            self._groups.pop(number, None)
        return socket

    def _watched(self, uri: str) -> Watched:
        if uri.rstrip('/') == ELOG:
            numbers = self._event_numbers()
            return Watched(ELOG, 'elog-message-ev', '', 'seqnum', str(max(numbers, default=0)))
        for front, kind, read, told in KINDS:
            if uri.startswith(front):
                self._value(uri, read)
                return Watched(uri, kind, read, told)
        raise unknown(uri)

    def _changes(self, one: Watched) -> list[str]:
        if one.uri == ELOG:
            new = sorted(item for item in self._event_numbers() if item > int(one.last or 0))
            one.last = str(new[-1]) if new else one.last
            return [event_item(one.kind, f'{ELOG}/{item}', {one.told: str(item)}) for item in new]
        value = self._value(one.uri, one.read)
        if value == one.last:
            return []
        one.last = value
        return [event_item(one.kind, one.uri, {one.told: value})]

    def _value(self, uri: str, field: str) -> str:
        found = _WITH_FIELD.fullmatch(uri)
        shown = self._show(found['path'] if found else uri)
        return str(shown.resources[0].fields[field])

    def _event_numbers(self) -> list[int]:
        return [int(one.title.rpartition('/')[2]) for one in self._show(ELOG).resources]


async def _until_closed(socket: web.WebSocketResponse) -> None:
    async for _ in socket:
        pass
