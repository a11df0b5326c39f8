"""Resources as a controller writes them: XHTML, or JSON in the shape of either version."""

from html import escape
import json
from typing import Any

from abb_emulator.rws.rws_refusal import RwsRefusalError
from abb_emulator.rws.rws_resources import Fields, Resource, Shown

XHTML, JSON, HAL = 'application/xhtml+xml', 'application/json', 'application/hal+json;v=2.0'
XHTML_2 = 'application/xhtml+xml;v=2.0'
SUCCESS = 294912
"""Status code that version 2.0 puts into every answer with a state."""


def page(base: str, shown: Shown) -> str:
    """Return resources as XHTML."""
    return _page(base, f'<div class="state">{listed(shown)}</div>')


def listed(shown: Shown) -> str:
    """Return resources as the items of an XHTML list."""
    items = ''.join(
        f'<li class="{one.kind}" title="{escape(one.title)}">{_spans(one.fields)}</li>'
        for one in shown.resources
    )
    return f'<ul>{items}</ul>'


def json_1(base: str, shown: Shown) -> str:
    """Return resources as JSON of version 1.0."""
    states = [_state(one) for one in shown.resources]
    return json.dumps({'_links': {'base': {'href': base}}, '_embedded': {'_state': states}})


def json_2(base: str, shown: Shown) -> str:
    """Return resources as JSON of version 2.0."""
    links: dict[str, Any] = {'base': {'href': base}, 'self': {'href': ''}}
    states = [_state(one) for one in shown.resources]
    if not shown.collection:
        return json.dumps({'_links': links, 'status': {'code': SUCCESS}, 'state': states})
    linked = [
        {'_links': {'self': {'href': one.title}}, **state}
        for one, state in zip(shown.resources, states, strict=True)
    ]
    return json.dumps({'_links': links, '_embedded': {'resources': linked}})


def refusal_page(refusal: RwsRefusalError) -> str:
    """Return a refusal as XHTML."""
    text = (
        f'<div class="status"><span class="code">{refusal.code}</span>'
        f'<span class="msg">{escape(str(refusal))}</span></div>'
    )
    return _page('', text)


def refusal_json(refusal: RwsRefusalError, modern: bool) -> str:
    """Return a refusal as JSON of either version."""
    status = {'status': {'code': refusal.code, 'msg': str(refusal)}}
    return json.dumps(status if modern else {'_embedded': status})


def linked_page(links: dict[str, str], content: str = '') -> str:
    """Return XHTML with links by their relation."""
    text = ''.join(f'<a href="{href}" rel="{rel}"></a>' for rel, href in links.items())
    return _page('', f'<div class="state">{text}{content}</div>')


def event_item(kind: str, href: str, fields: Fields) -> str:
    """Return what a subscription tells of one resource."""
    link = f'<a href="{href}" rel="self"/>'
    return f'<li class="{kind}" title="{kind}">{link}{_spans(fields)}</li>'


def _state(one: Resource) -> dict[str, Any]:
    return {'_type': one.kind, '_title': one.title, **one.fields}


def _spans(fields: Fields) -> str:
    return ''.join(
        f'<span class="{name}">{escape(value)}</span>'
        for name, value in fields.items()
        if isinstance(value, str)
    )


def _page(base: str, content: str) -> str:
    return (
        '<?xml version="1.0" encoding="UTF-8"?><html xmlns="http://www.w3.org/1999/xhtml">'
        f'<head><title>control</title><base href="{escape(base)}"/></head>'
        f'<body>{content}</body></html>'
    )
