"""The operator of the node tests serves as watcher."""

from test.support.cell_fixtures import drivers

__all__ = ['drivers']
