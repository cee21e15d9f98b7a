"""Hosts on one machine: network namespaces with addresses and names of their own, on a bridge. Takes root."""

import os
import subprocess
from pathlib import Path

_NET = "10.213.77"


def _ip(*arguments):
    subprocess.run(["ip", *arguments], check=True, capture_output=True, text=True)


class Network:
    """A bridge, and hosts on it.

    Parameters
    ----------
    names : list of str
        Of the hosts.
    secrets : Path
        Folder that every host has at ``/run/secrets``.
    """

    def __init__(self, names, secrets):
        self._own = f"rt{os.getpid() % 100_000}"
        self._names, self._secrets = names, secrets

    def __enter__(self):
        try:
            _ip("link", "add", self._own, "type", "bridge")
            _ip("addr", "add", f"{_NET}.1/24", "dev", self._own)
            _ip("link", "set", self._own, "up")
            for name in self._names:
                self._add(name)
        except BaseException:
            self.__exit__()
            raise
        return self

    def __exit__(self, *_):
        for name in self._names:
            subprocess.run(["ip", "netns", "delete", self._space(name)], capture_output=True)
            folder = self._names_folder(name)
            (folder / "hosts").unlink(missing_ok=True)
            if folder.exists():
                folder.rmdir()
        subprocess.run(["ip", "link", "delete", self._own], capture_output=True)

    def _space(self, name):
        return f"{self._own}-{name}"

    def _names_folder(self, name):
        return Path("/etc/netns") / self._space(name)

    def _link(self, name):
        return f"{self._own}h{self._names.index(name)}"

    def address(self, name):
        """Address of a host."""
        return f"{_NET}.{self._names.index(name) + 10}"

    def _add(self, name):
        space, link = self._space(name), self._link(name)
        _ip("netns", "add", space)
        _ip("link", "add", link, "type", "veth", "peer", "name", "eth0", "netns", space)
        _ip("link", "set", link, "master", self._own, "up")
        _ip("-n", space, "addr", "add", f"{self.address(name)}/24", "dev", "eth0")
        _ip("-n", space, "link", "set", "eth0", "up")
        _ip("-n", space, "link", "set", "lo", "up")
        folder = self._names_folder(name)
        folder.mkdir(parents=True)
        lines = ["127.0.0.1 localhost", *(f"{self.address(each)} {each}" for each in self._names)]
        (folder / "hosts").write_text("\n".join(lines) + "\n")

    def on(self, name, command):
        """A command as it is run on a host: with its network, its name, and the secrets in their place."""
        setting = (
            'hostname "$0"; mount -t tmpfs none /run; mkdir /run/secrets; '
            'mount --bind "$1" /run/secrets; shift; exec "$@"'
        )
        within = ["ip", "netns", "exec", self._space(name), "unshare", "--uts", "sh", "-c", setting]
        return [*within, name, str(self._secrets), *map(str, command)]

    def cut(self, name):
        """Pull a host's plug."""
        _ip("link", "set", self._link(name), "down")

    def mend(self, name):
        """Put it in again."""
        _ip("link", "set", self._link(name), "up")
