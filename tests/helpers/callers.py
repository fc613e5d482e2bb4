"""Who calls: a port of this machine that answers nobody and counts."""

import contextlib
import socket
import threading


@contextlib.contextmanager
def listening():
    """Yield ``(port, callers)`` of a server on 127.0.0.1; ``callers`` grows by an address with every connection."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        callers: list = []
        thread = threading.Thread(target=_answer, args=(server, callers), daemon=True)
        thread.start()
        try:
            yield server.getsockname()[1], callers
        finally:
            with contextlib.suppress(OSError):
                server.shutdown(socket.SHUT_RDWR)  # wakes the thread
            server.close()
            thread.join(60)


def _answer(server, callers) -> None:
    with contextlib.suppress(OSError):  # closed
        while True:
            connection, address = server.accept()
            callers.append(address)
            connection.close()
