"""What Robot Web Services refuse, with the status and the code a controller answers.

The codes are those that clients of real and virtual controllers of RobotWare 6 and 7 have
recorded; where none is known for a case, the code of its kind stands.
"""

from modal_core.errors import BridgeError

BAD_REQUEST, FORBIDDEN, NOT_FOUND, NOT_ALLOWED = 400, 403, 404, 405
NOT_ACCEPTABLE, NO_SUCH_MEDIA, UNAVAILABLE = 406, 415, 503
NOT_NOW = -1073442809
"""Not in this state of program, motors or operating mode."""
PARAMETER, SYMBOL, SIGNAL = -1073442813, -1073414146, -1073445866
HELD, NO_MASTERSHIP = -1073445862, -1073445859
NO_PATH, NO_RESOURCE = -1073438713, -1073414146
QUEUE_EXISTS, NO_QUEUE = -1073445879, -1073414146


class RwsRefusalError(BridgeError):
    """A request that is refused.

    Parameters
    ----------
    what : str
        Why, in words.
    status : int
        HTTP status.
    code : int
        The controller's own code.
    """

    def __init__(
        self, what: str, status: int = BAD_REQUEST, code: int = PARAMETER, found: object = None
    ) -> None:
        super().__init__(what, found=found)
        self.status, self.code = status, code


def not_now(why: str) -> RwsRefusalError:
    """Return the refusal of what may be asked, but not in this state."""
    return RwsRefusalError(
        f'Operation not allowed for current PGM state: {why}', FORBIDDEN, NOT_NOW
    )


def unknown(what: str, code: int = NO_RESOURCE) -> RwsRefusalError:
    """Return the refusal of what is not there."""
    return RwsRefusalError(f'{what[:80]} does not exist', NOT_FOUND, code)
