"""The folder of a run in shared memory."""

import fcntl
import os
import shutil
import stat
import time
from pathlib import Path

_DYING = 0.25
"""Time that the system may take to end a process that was killed, s."""


class Folder:
    """Joins the run: the folder stays as long as a process holds the lock."""

    def __init__(self, path):
        self._path = Path(path)
        status = os.stat(path, follow_symlinks=False)
        if not stat.S_ISDIR(status.st_mode) or status.st_uid != os.geteuid() or status.st_mode & 0o077:
            raise PermissionError(f"others may enter the folder of the run, {path}")
        self._lock = os.open(self._path / "lock", os.O_WRONLY | os.O_APPEND)
        fcntl.flock(self._lock, fcntl.LOCK_SH)

    def leave(self, orphaned):
        """Removes what belongs to the run if no other process of it is left.

        `orphaned`: the orchestrator has died. The system closes its pipes, by which a unit notices, before or after its lock,
        so that this waits a little for it.
        """
        until = time.monotonic() + (_DYING if orphaned else 0.0)
        while not self._is_the_last():
            if time.monotonic() >= until:
                return
            time.sleep(0.001)
        # What cannot be removed does no harm; the next run tries again.
        for segment in self._path.parent.glob(f"{self._path.name}-*"):
            if segment.is_file() and segment.stat().st_uid == os.geteuid():
                segment.unlink(missing_ok=True)
        shutil.rmtree(self._path, ignore_errors=True)

    def _is_the_last(self):
        try:
            fcntl.flock(self._lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            return False
        return True
