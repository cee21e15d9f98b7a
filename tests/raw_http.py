"""HTTP spoken byte by byte, as by clients that are slow, huge or malformed."""

import contextlib
import socket
import ssl

ANY_CERTIFICATE = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
ANY_CERTIFICATE.check_hostname, ANY_CERTIFICATE.verify_mode = False, ssl.CERT_NONE


@contextlib.contextmanager
def connection(port, *, tls=False):
    """A connection to a server on this machine; with TLS, any certificate will do."""
    with contextlib.ExitStack() as stack:
        line = stack.enter_context(socket.create_connection(("127.0.0.1", port), timeout=10))
        if tls:
            line = stack.enter_context(ANY_CERTIFICATE.wrap_socket(line))
        yield line


def received(line):
    """Everything that the server sends until it closes."""
    answer = b""
    with contextlib.suppress(ConnectionResetError, ssl.SSLError):
        while part := line.recv(65536):
            answer += part
    return answer


def sent_endlessly(line, beginning, part, most=30_000_000):
    """Send until the server closes; the number of bytes that it took."""
    sent = 0
    with contextlib.suppress(BrokenPipeError, ConnectionResetError, TimeoutError, ssl.SSLError):
        line.sendall(beginning)
        while sent < most:
            line.sendall(part)
            sent += len(part)
    return sent
