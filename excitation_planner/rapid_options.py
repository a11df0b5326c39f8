"""How a RAPID module is written: what the controller it is for has, and calls things."""

from dataclasses import dataclass
import re

from modal_core.errors import PlanError
from modal_core.settings.schema import check_settings, setting

LONGEST_NAME = 32
"""Letters of an identifier (ABB, Technical reference manual, RAPID kernel: identifiers)."""
_NAME = re.compile(rf'[A-Za-z][A-Za-z0-9_]{{0,{LONGEST_NAME - 1}}}', re.ASCII)
_DEVICE = re.compile(r'[A-Za-z0-9_.-]{1,32}', re.ASCII)


@dataclass(frozen=True, slots=True)
class RapidOptions:
    """How the module is written.

    Parameters
    ----------
    module_name : str
        What the module's name begins with; the plan's hash follows.
    tool : str
        Tooldata of the moves; what it weighs is what the controller plans with.
    load : str
        Loaddata that counts in place of the tool's own; empty: the tool's.
    work_object : str
        Wobjdata of the moves; empty: none.
    mechanical_unit : str
        Mechanical unit that EGM speaks of.
    udp_device : str
        Name of the UDP device in the controller's configuration.
    stream : bool
        Moves only: also stream time-stamped joint positions by EGM (option 689-1).
    collision_detection : bool
        Turn motion supervision on (option 613-1; RobotWare 7: 3107-1).
    digital_output : str
        Signal that is 1 from the first move to the last; empty: none.
    low_pass_hz : float [Hz]
        EGM guidance only: filter on the speed reference.
    """

    module_name: str = setting('AmaExcitation', 'what the name of a RAPID module begins with')
    tool: str = setting('tool0', 'tooldata of the moves')
    load: str = setting('', "loaddata in place of the tool's own; empty: the tool's")
    work_object: str = setting('', 'wobjdata of the moves; empty: none')
    mechanical_unit: str = setting('ROB_1', 'mechanical unit')
    udp_device: str = setting('UCdevice', "EGM: UDPUC device of the controller's configuration")
    stream: bool = setting(
        True, 'moves: stream the joints by EGM meanwhile, which needs option 689-1'
    )
    collision_detection: bool = setting(
        True, 'turn motion supervision on, which needs option Collision Detection'
    )
    digital_output: str = setting('', 'signal that is 1 from first to last move; empty: none')
    low_pass_hz: float = setting(
        100.0, 'EGM guidance: low-pass on the speed reference [Hz]', 0.0, 100.0
    )

    def check(self) -> None:
        """Refuse names that RAPID does not take, and numbers out of range.

        Raises
        ------
        PlanError, SettingsError
            Naming the option.
        """
        check_settings(self)
        for what in ('tool', 'load', 'work_object', 'mechanical_unit', 'digital_output'):
            value = getattr(self, what)
            optional = what in ('load', 'work_object', 'digital_output')
            if not (is_name(value) or (optional and not value)):
                raise PlanError(
                    'not a RAPID name', where=what, found=value[:40],
                    expected='a letter, then letters, digits and _, at most 32',
                )  # fmt: skip
        if not _DEVICE.fullmatch(self.udp_device):
            raise PlanError(
                'not the name of a device', where='udp_device', found=self.udp_device[:40]
            )

    @property
    def moving(self) -> str:
        """What ends a move: its tool, work object and load."""
        work = f'\\WObj:={self.work_object}' if self.work_object else ''
        load = f'\\TLoad:={self.load}' if self.load else ''
        return f'{self.tool}{work}{load}'

    def mark(self, value: int) -> list[str]:
        """Return the statement that sets the mark of the motion; none without a signal."""
        return [f'    SetDO {self.digital_output},{value};'] if self.digital_output else []


def is_name(text: str) -> bool:
    """Tell whether RAPID takes a text as a name."""
    return bool(_NAME.fullmatch(text))
