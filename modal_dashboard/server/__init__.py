"""The web server of the page.

In come updates, from any thread; out go the page and, over a web socket, what changes.  It only
ever sends: nothing that a browser says changes anything.
"""

from modal_dashboard.server.access import Access, host_of, is_loopback, SHORTEST_TOKEN
from modal_dashboard.server.page_server import PageServer

__all__ = ['SHORTEST_TOKEN', 'Access', 'PageServer', 'host_of', 'is_loopback']
