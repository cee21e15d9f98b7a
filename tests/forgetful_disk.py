"""A disk that keeps nothing but what was synced: what a power cut may leave of a folder.

It watches `os.fsync` of this process. A synced file keeps its content of that moment, whatever its name becomes; a
synced folder keeps the names that it had, each for the file or folder that bore it. POSIX promises no more. A disk may
have written anything else on its own, too; so a power cut keeps that by chance: all, nothing, or some of it. Of a
file that was not synced it may keep the first bytes only.
"""

import os
import random
import stat
import threading
from pathlib import Path


class ForgetfulDisk:
    """What was synced below a folder.

    Parameters
    ----------
    root : Path
        The folder that itself, and its name, are on the disk.
    monkeypatch : pytest.MonkeyPatch

    Attributes
    ----------
    before_sync : callable
        Called before each sync. What was written until then is not yet on the disk.
    """

    def __init__(self, root, monkeypatch):
        self.root, self._fsync, self._lock = Path(root), os.fsync, threading.RLock()
        self.contents, self.names, self.folders, self.syncs = {}, {}, set(), 0
        self.before_sync = lambda: None
        # A number of a file that is gone would be given to another.
        self._kept_open = []
        monkeypatch.setattr(os, "fsync", self._synced)

    def _synced(self, opened):
        status = os.fstat(opened)
        path = Path(os.readlink(f"/proc/self/fd/{opened}"))
        if path.is_relative_to(self.root):
            with self._lock:
                self.before_sync()
                self.syncs += 1
                self._kept_open.append(os.open(path, os.O_RDONLY))
                if stat.S_ISDIR(status.st_mode):
                    self.names[status.st_ino] = _names(path)
                    self.folders.update(each.inode() for each in os.scandir(path) if each.is_dir())
                else:
                    self.contents[status.st_ino] = path.read_bytes()

    def power_cut(self, place, chance, seed=0):
        """Copy to a place what a power cut would leave now. `chance` is that of a write which was not synced."""
        with self._lock:
            _Survivors(self, random.Random(seed), chance).copy(self.root, place)

    def close(self):
        """Let the files go."""
        for opened in self._kept_open:
            os.close(opened)


class _Survivors:
    def __init__(self, disk, rng, chance):
        self.disk, self.rng, self.chance = disk, rng, chance

    def _survives(self):
        return self.rng.random() < self.chance

    def copy(self, folder, place):
        """Copy what is left of a folder that is there now."""
        self._copy_names(self.disk.names.get(folder.stat().st_ino, {}), _names(folder), folder, place)

    def _copy_names(self, before, now, folder, place):
        place.mkdir()
        here = {number: folder / name for name, number in now.items()}
        for name in sorted(before.keys() | now.keys()):
            number = now.get(name) if self._survives() else before.get(name)
            if number is not None:
                self._copy(number, here.get(number), place / name)

    def _copy(self, number, path, place):
        """Copy a file or a folder by its number. What has been replaced or removed is nowhere else any more."""
        if path is not None and path.is_dir():
            self.copy(path, place)
        elif number in self.disk.folders:
            self._copy_names(self.disk.names.get(number, {}), {}, place, place)
        else:
            place.write_bytes(self._content(number, path))

    def _content(self, number, path):
        """All that was written to a file, what was last synced, or the first bytes of what was never synced."""
        synced = self.disk.contents.get(number)
        if path is None or not self._survives():
            return synced or b""
        try:
            written = path.read_bytes()
        except FileNotFoundError:  # renamed by another thread since its folder was read
            return synced or b""
        whole = synced is not None or self._survives()
        return written if whole else written[: self.rng.randrange(len(written) + 1)]


def _names(folder):
    with os.scandir(folder) as found:
        return {each.name: each.inode() for each in found}
