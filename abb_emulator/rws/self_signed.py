"""A certificate as a controller has it: made by itself, known to nobody."""

import hashlib
from pathlib import Path
import ssl
import subprocess
import tempfile

from modal_core.errors import BridgeError

VALID_DAYS = '3650'


def make_certificate(folder: Path, address: str) -> tuple[Path, Path]:
    """Write a new certificate and its key into a folder; return their files.

    Raises
    ------
    BridgeError
        There is no openssl.
    """
    certificate, key = folder / 'certificate.pem', folder / 'key.pem'
    command = [
        'openssl', 'req', '-x509', '-newkey', 'ec', '-pkeyopt', 'ec_paramgen_curve:prime256v1',
        '-nodes', '-keyout', str(key), '-out', str(certificate), '-days', VALID_DAYS,
        '-subj', '/CN=Emulated controller', '-addext', f'subjectAltName=IP:{address}',
    ]  # fmt: skip
    try:
        subprocess.run(command, check=True, capture_output=True, timeout=30)  # noqa: S603
    except (OSError, subprocess.SubprocessError) as error:
        raise BridgeError(
            'no certificate can be made', where='openssl', advice='install openssl'
        ) from error
    return certificate, key


def server_context(address: str) -> tuple[ssl.SSLContext, str]:
    """Return a TLS context with a certificate of its own, and the certificate's SHA-256.

    Raises
    ------
    BridgeError
        No certificate can be made.
    """
    with tempfile.TemporaryDirectory() as folder:
        certificate, key = make_certificate(Path(folder), address)
        context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
        context.load_cert_chain(certificate, key)
        binary = ssl.PEM_cert_to_DER_cert(certificate.read_text())
    return context, hashlib.sha256(binary).hexdigest()
