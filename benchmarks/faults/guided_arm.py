"""An emulated controller and a bridge on loopback: the rig of arm faults and of their tests."""

from collections.abc import Callable

import numpy as np

from abb_emulator.cell import CellSettings, MotorSide
from abb_emulator.egm import GuidanceSettings, LinkFaults, UdpClient
from abb_emulator.rapid.guidance_program import guidance_program
from robot_bridge.egm import EgmLink, Packet, SessionCheck, SessionLimits
from robot_bridge.operator import FlowSettings, OperatorFlow
from structural_model import load_robot

CYCLE_S = 0.004032
COASTS_S = 0.1
"""How long the controller goes on at the last speed it was asked for (CommTimeout)."""
GUIDANCE = GuidanceSettings(
    low_pass_hz=100.0,
    max_speed_deviation_deg_s=30.0,
    window_low_deg=(-1e-3,) * 6,
    window_high_deg=(1e-3,) * 6,
    condition_time_s=1e6,
    comm_timeout_s=COASTS_S,
)
"""Of the exported program, but that no standstill ends the session."""


class SpoiledClient(UdpClient):
    """The controller's end of the link, whose packets a fault may change."""

    spoil: Callable[[bytes], list[bytes]] = staticmethod(lambda data: [data])

    def send(self, data: bytes, now_s: float) -> None:
        """Send what the fault makes of a packet."""
        for part in self.spoil(data):
            super().send(part, now_s)


class GuidedArm:
    """Everything from the arm's drives to the bridge's operator flow, over real UDP.

    Parameters
    ----------
    rng : Generator
        Of the link's faults.
    flow : FlowSettings
        Of the bridge.
    limits : SessionLimits
        Of its session check.
    guidance : GuidanceSettings
        Of the controller's program.
    """

    def __init__(
        self,
        rng: np.random.Generator,
        flow: FlowSettings,
        limits: SessionLimits,
        guidance: GuidanceSettings = GUIDANCE,
    ) -> None:
        self.model = load_robot('irb6660_205_190')
        self.start_deg = np.degrees(self.model.to_controller(self.model.pose('P1')))
        self.flow = OperatorFlow(flow)
        self.packets: list[Packet] = []
        self.link = EgmLink(
            '127.0.0.1', 0, SessionCheck(limits),
            lambda feedback, judgement, now_s, _: self.flow.on_feedback(
                feedback, judgement, now_s
            ),
            self.flow.abort, self.flow.poll, self.packets.append,
        )  # fmt: skip
        self.faults = LinkFaults(rng)
        self.client = SpoiledClient(self.link.address, self.faults, '127.0.0.1')
        self.motors = MotorSide(self.model, self.start_deg, self.client, CellSettings())
        self.controller = self.motors.controller
        self.controller.start(guidance_program(self.controller, guidance, True))
        self.link.start()

    def close(self) -> None:
        """Give the ports back."""
        self.link.close()
        self.client.close()
