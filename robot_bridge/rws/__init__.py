"""Robot Web Services of ABB: programs loaded, started and stopped by HTTP.

In comes a released program; out go requests, each only after the controller was seen to be as
the release says.
"""

from robot_bridge.rws.released_program import ReleasedProgram
from robot_bridge.rws.rws_client import ProgramControl, RwsClient
from robot_bridge.rws.web_services import RwsAccess

__all__ = ['ProgramControl', 'ReleasedProgram', 'RwsAccess', 'RwsClient']
