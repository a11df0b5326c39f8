"""The controller's side of Externally Guided Motion.

In come references by UDP; out go feedback packets and guided joints by the documented law, over
a link that can be made faulty.
"""

from abb_emulator.egm.egm_session import EgmSession, Phase, Status
from abb_emulator.egm.guidance_law import GuidanceLaw, GuidanceSettings
from abb_emulator.egm.link_faults import LinkFault, LinkFaults
from abb_emulator.egm.udp_client import UdpClient

__all__ = [
    'EgmSession',
    'GuidanceLaw',
    'GuidanceSettings',
    'LinkFault',
    'LinkFaults',
    'Phase',
    'Status',
    'UdpClient',
]
