"""The controller's web services: files, programs, motors, start and stop.

In come HTTP requests; out go the answers of the station, after a digest challenge.
"""

from abb_emulator.rws.rws_server import RwsServer
from abb_emulator.rws.rws_station import Station

__all__ = ['RwsServer', 'Station']
