"""Stability lobes: in come a tool and a cut; out go limits over speed and cuts to take."""

from machining.lobes.chart import Chart
from machining.lobes.lobes import Lobes, stability_lobes
from machining.lobes.propose import Proposal

__all__ = ['Chart', 'Lobes', 'Proposal', 'stability_lobes']
