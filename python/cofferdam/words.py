"""Lines of JSON on standard output: what a unit says to the orchestrator."""

import io
import json
import logging
import os
import sys
import threading


class Words:
    """Takes standard output for itself, writes words there and counts them.

    What the unit prints becomes messages of the log. What libraries write to the file descriptor goes to standard error.
    """

    def __init__(self, unit):
        self.unit, self.count = unit, 0
        self.step, self.iteration, self.time = 0, 0, 0.0
        # What is collected meanwhile may say something, too.
        self._lock = threading.RLock()
        sys.stdout.flush()
        self._descriptor = os.dup(1)
        os.dup2(2, 1)
        self.printed = sys.stdout = _Printed(self)
        # Ends a line that was printed before.
        self._write(b"\n")

    def _write(self, line):
        try:
            while line:
                line = line[os.write(self._descriptor, line) :]
        except OSError:
            # No reader is left.
            pass

    def say(self, kind, content):
        with self._lock:
            # What is no Unicode, as in names of files, would be no JSON.
            self._write(json.dumps({kind: content}, ensure_ascii=False).encode(errors="replace") + b"\n")
            self.count += 1

    def message(self, level, source, text):
        """A message for the log, which belongs to the present step."""
        at = {"step": self.step, "iteration": self.iteration, "time": self.time}
        self.say("message", {"unit": self.unit, "level": level, **at, "source": source, "text": text})

    def failed(self, text):
        """Why the unit cannot be made, or why the call failed."""
        self.say("failed", {"text": f"{self.unit}: {text}"})


class _Printed(io.TextIOBase):
    """In place of `sys.stdout`: each line becomes a message."""

    encoding = "utf-8"

    def __init__(self, words):
        self._words, self._begun = words, ""

    def writable(self):
        return True

    def fileno(self):
        return 1

    def write(self, text):
        *lines, self._begun = (self._begun + text).split("\n")
        for line in lines:
            if line.strip():
                self._words.message("information", "print", line)
        return len(text)

    def finish(self):
        """Sends a line that was begun."""
        if self._begun:
            self.write("\n")


class Logged(logging.Handler):
    """Records of `logging` as messages."""

    def __init__(self, words):
        super().__init__()
        self._words = words

    def emit(self, record):
        levels = [(logging.ERROR, "error"), (logging.WARNING, "warning"), (logging.INFO, "information")]
        level = next((name for least, name in levels if record.levelno >= least), "debug")
        try:
            self._words.message(level, record.name, self.format(record))
        except Exception:
            self.handleError(record)

    @classmethod
    def attach(cls, words):
        """Records from `INFO` up, unless the unit has set up `logging` itself, and warnings."""
        root = logging.getLogger()
        if not root.handlers:
            root.setLevel(logging.INFO)
        root.addHandler(cls(words))
        logging.captureWarnings(True)
