"""Self-signed certificates for servers of this computer."""

from __future__ import annotations

import ipaddress
import ssl
import tempfile
from datetime import UTC, datetime, timedelta
from pathlib import Path as FilePath
from typing import Final

from assistant.base.file_access import write_whole

_CERTIFICATE_LIFETIME: Final = timedelta(days=30)


def self_signed_context(host: str, name: str, file: FilePath) -> ssl.SSLContext:
    """Makes a key and a certificate; the certificate goes into a file, for clients to trust it.

    host: address by which the server is reached, beside `localhost`. name: of its owner. The key is
    nowhere but in memory and, for a moment, in a file that only this user may read. Raises
    ImportError without the package `cryptography`, OSError for the file.
    """
    from cryptography import x509
    from cryptography.hazmat.primitives import hashes, serialization
    from cryptography.hazmat.primitives.asymmetric import ec

    key = ec.generate_private_key(ec.SECP256R1())
    owner = x509.Name([x509.NameAttribute(x509.NameOID.COMMON_NAME, name)])
    now = datetime.now(UTC)
    names: list[x509.GeneralName] = [x509.DNSName("localhost")]
    try:
        names.append(x509.IPAddress(ipaddress.ip_address(host)))
    except ValueError:
        names.append(x509.DNSName(host))
    made = (
        x509.CertificateBuilder()
        .subject_name(owner)
        .issuer_name(owner)
        .public_key(key.public_key())
        .serial_number(x509.random_serial_number())
        .not_valid_before(now - timedelta(days=1))
        .not_valid_after(now + _CERTIFICATE_LIFETIME)
        .add_extension(x509.SubjectAlternativeName(names), critical=False)
        .add_extension(x509.BasicConstraints(ca=True, path_length=0), critical=True)
        .sign(key, hashes.SHA256())
    )
    data = made.public_bytes(serialization.Encoding.PEM)
    write_whole(file, data)
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    context.minimum_version = ssl.TLSVersion.TLSv1_2
    secret = key.private_bytes(
        serialization.Encoding.PEM,
        serialization.PrivateFormat.PKCS8,
        serialization.NoEncryption(),
    )
    with tempfile.TemporaryDirectory() as folder:
        both = FilePath(folder) / "key.pem"
        both.touch(0o600)
        both.write_bytes(secret + data)
        context.load_cert_chain(both)
    return context
