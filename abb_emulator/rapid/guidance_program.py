"""A program that lets the sensor guide the robot, as an operator would start it."""

from collections.abc import Generator

from abb_emulator.controller import Controller
from abb_emulator.controller_settings import RapidError
from abb_emulator.egm import GuidanceSettings


def guide(controller: Controller, settings: GuidanceSettings) -> Generator[None, None, None]:
    """Follow the sensor until the session ends by itself (EGMRunJoint).

    A program stopped meanwhile and started again takes guidance up anew, from where it stands.
    """
    law = controller.guide(settings)
    while not law.finished:
        yield
        if controller.axes.motion is None and not law.finished:
            law = controller.guide(settings)


def guidance_program(
    controller: Controller, settings: GuidanceSettings, wait_for_sensor: bool
) -> Generator[None, None, None]:
    """Set a session up, run guidance, and hold when it ends.

    Parameters
    ----------
    controller : Controller
        Executes the program.
    settings : GuidanceSettings
        Of the session.
    wait_for_sensor : bool
        Begin guidance only when the sensor has answered, as a careful operator does.
    """
    session = controller.set_up(settings)
    session.sending = True
    while wait_for_sensor and not session.heard:
        yield
    try:
        yield from guide(controller, settings)
    except RapidError as error:
        controller.note(f'guidance ended: {error.code}')
        controller.stop(error.code)
        # The session keeps reporting ERROR until the program is started anew.
        return
    controller.reset_session()
