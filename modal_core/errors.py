"""One family of errors: each says in one line what is wrong, where, and what to do."""

from modal_core.words.printable import printable

LONGEST_PART = 1000
"""Characters of a value that are shown: a name may have a million."""


class ModalAnalysisError(Exception):
    """Anything a user can put right; base of all errors the suite raises on purpose.

    Parameters
    ----------
    what : str
        What is wrong, as a short statement.
    where : str
        File, topic, field or joint it was found in.
    found : object
        The offending value.
    expected : object
        What would have been right.
    advice : str
        What to do about it.
    """

    def __init__(
        self,
        what: str,
        *,
        where: object = '',
        found: object = None,
        expected: object = None,
        advice: str = '',
    ) -> None:
        self.what = what
        self.where = str(where)
        self.found = found
        self.expected = expected
        self.advice = advice
        super().__init__(what)

    def __str__(self) -> str:
        """Return the error as one line without control characters."""
        what, where = _one_line(self.what), _one_line(self.where)
        line = f'{where}: {what}' if where else what
        details = []
        if self.found is not None:
            details.append(f'found {_one_line(self.found)}')
        if self.expected is not None:
            details.append(f'expected {_one_line(self.expected)}')
        if details:
            line += f' ({", ".join(details)})'
        if self.advice:
            line += f'; {_one_line(self.advice)}'
        return line


class SettingsError(ModalAnalysisError):
    """A parameter, option or settings file is out of range or unknown."""


class LayoutError(ModalAnalysisError):
    """A sensor layout is malformed or names something that does not exist."""


class RecordingError(ModalAnalysisError):
    """A recording cannot be read or written."""


class MessageError(ModalAnalysisError):
    """A received message breaks its own contract: length, shape, finiteness or rate."""


class IdentificationError(ModalAnalysisError):
    """A window of responses cannot be identified."""


class ModelError(ModalAnalysisError):
    """A robot model is incomplete or a pose lies outside it."""


class PlanError(ModalAnalysisError):
    """An excitation plan breaks a limit or cannot be made."""


class MapError(ModalAnalysisError):
    """A modal map is of something else, or is asked beyond what it knows."""


class HistoryError(ModalAnalysisError):
    """A history of results cannot be read or written."""


class BatchError(ModalAnalysisError):
    """Work on many recordings cannot be handed out, or its manifest cannot be read."""


class BridgeError(ModalAnalysisError):
    """The robot, its controller or the link to it refuses or fails."""


def _one_line(value: object) -> str:
    return printable(' '.join(str(value).split()), LONGEST_PART)
