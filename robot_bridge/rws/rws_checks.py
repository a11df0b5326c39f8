"""Whether a controller is as it must be before a released program is started.

Every check refuses in one line; what the controller does not tell counts as not so.
"""

import re
from urllib.parse import unquote

from excitation_planner.rapid import HASH_DIGITS
from modal_core.errors import BridgeError
from robot_bridge.rws.released_program import ReleasedProgram
from robot_bridge.rws.web_services import WebServices

# Single cycle, not yet begun and already over.
ONCE = ('once', 'oncedone')


def check_automatic(web: WebServices) -> None:
    """Refuse any mode but automatic."""
    web.expect('mode', 'opmode', 'AUTO')


def check_ready(web: WebServices) -> None:
    """Refuse a controller that is not in automatic mode, with motors on, at rest, alone."""
    check_automatic(web)
    web.expect('motors', 'ctrlstate', 'motoron')
    web.expect('execution', 'ctrlexecstate', 'stopped')
    tasks = {state.get('name', ''): state for state in web.states('tasks')}
    if _is_on(tasks.get(web.task, {}).get('active', '')):
        tasks.pop(web.task)
    else:
        raise BridgeError('the task is not active', where=web.task, advice='see the task panel')
    for name, state in tasks.items():
        moves = state.get('motiontask', '').lower() == 'true'
        normal = state.get('type', '').lower().startswith('norm')
        if _is_on(state.get('active', '')) and (moves or normal):
            raise BridgeError(
                'another task would be started too',
                where='task panel',
                found=name,
                expected=f'{web.task} alone',
                advice='deselect it in the task panel',
            )


def check_loaded(web: WebServices, program: ReleasedProgram) -> None:
    """Refuse another text under this name, and a program pointer elsewhere."""
    text = _module_text(web, program.name)
    if not any(program.is_text(form) for form in (text, unquote(text))):
        raise BridgeError(
            'the module in the controller is not the one that was released',
            where=program.name,
            advice='load and compare it at the pendant',
        )
    states = web.states('pointer')
    pointer = next((item for item in states if item.get('_title') == 'progpointer'), {})
    # The resource itself spells it so.
    module = pointer.get('modulemame', pointer.get('modulename', ''))
    place = (module.casefold(), pointer.get('routinename', '').casefold())
    if place != (program.name.casefold(), 'main'):
        raise BridgeError(
            'the program pointer is not at main of the released module',
            where=web.task,
            found='/'.join(place),
            expected=f'{program.name}/main',
        )


def check_place(web: WebServices, program: ReleasedProgram) -> None:
    """Refuse an arm that stands elsewhere than at the start of the plan."""
    try:
        state = web.states('joints')[0]
        axes = [float(state[f'rax_{number}']) for number in range(1, 7)]
    except (LookupError, ValueError) as error:
        raise BridgeError(
            'the controller does not tell where the arm stands', where='jointtarget'
        ) from error
    program.check_place(axes)


def check_once(web: WebServices) -> None:
    """Refuse a run mode that begins anew at the end of the program."""
    cycle = web.value('execution', 'cycle')
    if cycle not in ONCE:
        raise BridgeError(
            'the program would begin anew at its end',
            where='run mode',
            found=cycle,
            expected=ONCE[0],
        )


def names_like(web: WebServices, name: str) -> list[str]:
    """Return the other loaded modules that carry another plan's hash; others are somebody's."""
    stem = name.rpartition('_')[0]
    of_a_plan = re.compile(rf'{re.escape(stem)}_[0-9a-f]{{{HASH_DIGITS}}}', re.IGNORECASE)
    loaded = [state.get('name', '') for state in web.states('modules')]
    return [
        other
        for other in loaded
        if stem and other.casefold() != name.casefold() and of_a_plan.fullmatch(other)
    ]


def _module_text(web: WebServices, name: str) -> str:
    """Return a loaded module as the controller holds it."""
    states = web.states('text', name)
    state = states[0] if states else {}
    file = state.get('file-path', '').strip('"')
    # A long module is not answered but written to a file.
    if 'module-text' not in state and file.startswith('$'):
        return web.file(file).decode(errors='replace')
    return state.get('module-text', '')


def _is_on(text: str) -> bool:
    return text.lower() in ('on', 'true')
