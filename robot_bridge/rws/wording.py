"""How each version of Robot Web Services words what is asked of a controller.

References
----------
ABB, Application manual Robot Web Services, 3HAC050973-001 (1.0, RobotWare 6: IRC5) and
3HAC073675-001 (2.0, RobotWare 7: OmniCore).
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
import json
from types import MappingProxyType

FORM, FILE = 'application/x-www-form-urlencoded', 'text/plain'
VERSION_2 = ';v=2.0'


@dataclass(frozen=True, slots=True)
class Wording:
    """One version.

    Parameters
    ----------
    version : int
        1 or 2.
    mode, motors, execution, tasks, pointer, modules, text, joints : str
        Paths that are read; ``{task}``, ``{unit}`` and ``{name}`` stand for names.
    load, unload, reset, start, stop, request, release : str
        Paths of actions; the last two are those of the mastership of programs.
    starts_as_master : bool
        START goes through while the client holds the mastership.
    ending : str
        Of the path of whatever is read as JSON.
    headers : mapping of str to str
        Of every request but those of files.
    media_ending : str
        Of the media type of whatever is sent.
    """

    version: int
    mode: str
    motors: str
    execution: str
    tasks: str
    pointer: str
    modules: str
    text: str
    joints: str
    load: str
    unload: str
    reset: str
    start: str
    stop: str
    request: str
    release: str
    starts_as_master: bool
    ending: str = ''
    headers: Mapping[str, str] = field(default_factory=lambda: MappingProxyType({}))
    media_ending: str = ''

    def states(self, answer: bytes) -> list[dict[str, str]]:
        """Return the states in an answer, every field as text.

        Raises
        ------
        ValueError, LookupError, TypeError, AttributeError, RecursionError
            It is something else.
        """
        found = json.loads(answer)
        if self.version == 1:
            states = found['_embedded']['_state']
        else:
            # Things with a path of their own are embedded, others are not.
            states = found['state'] if 'state' in found else found['_embedded']['resources']
        return [{str(key): str(item) for key, item in state.items()} for state in states]


VERSION_1_WORDS = Wording(
    version=1,
    mode='/rw/panel/opmode',
    motors='/rw/panel/ctrlstate',
    execution='/rw/rapid/execution',
    tasks='/rw/rapid/tasks',
    pointer='/rw/rapid/tasks/{task}/pcp',
    modules='/rw/rapid/modules?task={task}',
    text='/rw/rapid/modules/{name}?resource=module-text&task={task}',
    joints='/rw/motionsystem/mechunits/{unit}/jointtarget',
    load='/rw/rapid/tasks/{task}?action=loadmod',
    unload='/rw/rapid/tasks/{task}?action=unloadmod',
    reset='/rw/rapid/execution?action=resetpp',
    start='/rw/rapid/execution?action=start',
    stop='/rw/rapid/execution?action=stop',
    request='/rw/mastership/rapid?action=request',
    release='/rw/mastership/rapid?action=release',
    starts_as_master=True,
    ending='json=1',
)
VERSION_2_WORDS = Wording(
    version=2,
    mode='/rw/panel/opmode',
    motors='/rw/panel/ctrl-state',
    execution='/rw/rapid/execution',
    tasks='/rw/rapid/tasks',
    pointer='/rw/rapid/tasks/{task}/pcp',
    modules='/rw/rapid/tasks/{task}/modules',
    text='/rw/rapid/tasks/{task}/modules/{name}/text',
    joints='/rw/motionsystem/mechunits/{unit}/jointtarget',
    load='/rw/rapid/tasks/{task}/loadmod',
    unload='/rw/rapid/tasks/{task}/unloadmod',
    reset='/rw/rapid/execution/resetpp',
    # Clients of real controllers report START refused while they hold the mastership.
    start='/rw/rapid/execution/start?mastership=implicit',
    stop='/rw/rapid/execution/stop',
    request='/rw/mastership/edit/request',
    release='/rw/mastership/edit/release',
    starts_as_master=False,
    headers=MappingProxyType({'Accept': f'application/hal+json{VERSION_2}'}),
    media_ending=VERSION_2,
)
