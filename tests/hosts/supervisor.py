"""Keeps parts running, as an engine does that restarts them always."""

import os
import signal
import subprocess
import threading


class Supervisor:
    """Runs one command, again and again where that is asked for.

    Parameters
    ----------
    command : list
    environment : dict
    restarts : bool
    log : Path
    """

    def __init__(self, command, environment, restarts, log):
        self._command, self._environment, self._restarts = command, environment, restarts
        self._log = log
        self.codes = []
        self._stopping = threading.Event()
        self._process = None
        self._thread = threading.Thread(target=self._keep, daemon=True)

    def start(self):
        """Begin."""
        self._thread.start()

    def _keep(self):
        with self._log.open("ab") as log:
            while not self._stopping.is_set():
                self._process = subprocess.Popen(
                    self._command, env=self._environment, stdout=log, stderr=log, start_new_session=True
                )
                self.codes.append(self._process.wait())
                if not self._restarts or self._stopping.wait(1.0):
                    return

    def stop(self):
        """End it, with all that it has started."""
        self._stopping.set()
        if self._process is not None:
            try:
                os.killpg(self._process.pid, signal.SIGKILL)
            except ProcessLookupError:
                pass  # ended by itself
        self._thread.join(20)
