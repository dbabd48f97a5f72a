"""The folder of a run in shared memory."""

import fcntl
import os
import shutil
import stat
from pathlib import Path


class Folder:
    """Joins the run: the folder stays as long as a process holds the lock."""

    def __init__(self, path):
        self._path = Path(path)
        status = os.stat(path, follow_symlinks=False)
        if not stat.S_ISDIR(status.st_mode) or status.st_uid != os.geteuid() or status.st_mode & 0o077:
            raise PermissionError(f"others may enter the folder of the run, {path}")
        self._lock = os.open(self._path / "lock", os.O_WRONLY | os.O_APPEND)
        fcntl.flock(self._lock, fcntl.LOCK_SH)

    def leave(self):
        """Removes what belongs to the run if no other process of it is left."""
        try:
            fcntl.flock(self._lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            return
        # What cannot be removed does no harm; the next run tries again.
        for segment in self._path.parent.glob(f"{self._path.name}-*"):
            if segment.is_file() and segment.stat().st_uid == os.geteuid():
                segment.unlink(missing_ok=True)
        shutil.rmtree(self._path, ignore_errors=True)
