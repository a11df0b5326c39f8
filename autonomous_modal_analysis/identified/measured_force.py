"""The force that a recording holds beside its responses."""

from modal_core.errors import RecordingError
from modal_recordings.force_column import open_with_force
from modal_recordings.open_recording import Recording
from oma_identifier.known_force import KnownForce


def measured_force(recording: Recording) -> KnownForce:
    """Return the force of a table.

    Raises
    ------
    RecordingError
        It holds none, or several.
    """
    given = getattr(recording, 'sample_rate_hz', None)
    try:
        found = open_with_force(recording.path, sample_rate_hz=given)
    except RecordingError as error:
        raise RecordingError(
            f'method force: {error.what}',
            where=error.where,
            found=error.found,
            expected=error.expected,
            advice='head the column of the force force@CHANNEL [N], or use ssi_cov',
        ) from error
    responses = found.responses
    if not found.force_n.any():
        raise RecordingError('the force is zero', where=recording.path, found=found.name)
    return KnownForce(
        found.force_n[:, None],
        responses.sample_rate_hz,
        responses.start_ns,
        found.name,
        found.without_unit,
    )
