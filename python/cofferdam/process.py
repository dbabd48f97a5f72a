"""The process of a unit: its task, its service, and its end."""

import ctypes
import json
import os
import signal
import sys
import threading
import time
import traceback

from .exchange import Exchange, NotOffered
from .folder import Folder
from .header import DONE, FAILED, NOT_OFFERED, PROTOCOL_VERSION
from .service import Service, header_of, values_of
from .task import Task
from .waiting import Wait, shorten_naps
from .words import Logged, Words

_FAILED = 4
"""Exit status if the unit fails or the orchestrator dies."""
_GRACE = 0.5
"""Time for a computation to finish after the run is over, s."""


def serve(cls):
    """Makes the unit of the class `cls` that the orchestrator asks for, and serves it until the run is over.

    `cls` derives from `cofferdam.Reservoir` or `cofferdam.Dam`. This is the last line of a unit's program. An exception of
    the class fails the call; its traceback is a message in the log. What the unit prints or gives to `logging` is a message
    too.
    """
    try:
        task, standard_input = _task()
    except ValueError as error:
        program = os.path.basename(sys.argv[0])
        sys.exit(f"{program}: the first line of standard input is no task ({error}); `cofferdam run` starts units by itself")
    words = Words(task["unit"])
    Logged.attach(words)
    # Who ends a run asks the orchestrator, which ends its units; job schedulers signal to all processes at once.
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        # A handler: what is ignored would be ignored by programs that the unit starts, too.
        signal.signal(number, lambda *_: None)
    shorten_naps()
    lifeline = _Lifeline(words, standard_input)
    try:
        _check(task)
        folder = Folder(task["folder"])
        exchange = Exchange(cls, Task.from_json(task), task["folder"])
        service = Service(task, exchange.layout, exchange.most_values)
    except Exception as error:
        words.printed.finish()
        _report(words, error)
        sys.exit(_FAILED)
    description = exchange.description(task["brief"])
    words.say("ready", {"protocol": PROTOCOL_VERSION, "description": description})
    try:
        _answer_requests(exchange, service, words, lifeline)
    except Exception as error:
        # An orchestrator that dies may be the reason.
        time.sleep(_GRACE / 5)
        if not lifeline.over:
            _report(words, error)
            sys.exit(_FAILED)
    service = None
    folder.leave(lifeline.orphaned)
    if lifeline.orphaned:
        lifeline.report()
        lifeline.end_group()
        sys.exit(_FAILED)


def _task():
    """The task: the first line of standard input. Returns it and what follows, from which nothing else then reads."""
    if sys.stdin.isatty():
        raise ValueError("it is a terminal")
    standard_input = os.fdopen(os.dup(0), encoding="utf-8")
    sys.stdin = open(os.devnull)
    os.dup2(sys.stdin.fileno(), 0)
    task = json.loads(standard_input.readline())
    if not isinstance(task, dict) or not {"unit", "protocol"} <= task.keys():
        raise ValueError("it names no unit")
    return task, standard_input


def _check(task):
    found = task["protocol"]
    if found != PROTOCOL_VERSION:
        raise RuntimeError(
            f"the orchestrator speaks version {found} of the exchange protocol, the Python package cofferdam version"
            f" {PROTOCOL_VERSION}; install the package of the orchestrator's own build"
        )
    if task.get("service") != "ipc" or "brief" not in task:
        raise RuntimeError("the task is one for a built-in unit: it has no brief, or asks for private files")


def _answer_requests(exchange, service, words, lifeline):
    wait = Wait()
    clock = time.perf_counter_ns
    while not lifeline.over:
        request = service.receive()
        if request is None:
            wait.pause()
            continue
        wait.end()
        header = header_of(request)
        words.step, words.iteration, words.time = header.step, header.iteration, header.time
        began, status = clock(), DONE
        try:
            answer = exchange.answer(header, values_of(request, exchange.values_needed(header)))
        except NotOffered:
            answer, status = (), NOT_OFFERED
        except Exception as error:
            _report(words, error, _when(header))
            answer, status = (), FAILED
        busy = clock() - began
        words.printed.finish()
        response = request.loan_slice_uninit(len(answer))
        values_of(response, len(answer))[:] = answer
        echo = header_of(response)
        ctypes.memmove(ctypes.byref(echo), ctypes.byref(header), ctypes.sizeof(header))
        echo.status, echo.busy, echo.words = status, busy, words.count
        response.assume_init().send()
        wait.begin()


def _when(header):
    if header.step == 0:
        return " at initialisation"
    return f" in step {header.step} from t = {header.time} s, iteration {header.iteration}"


def _report(words, error, when=""):
    """Says why a call failed: the last line of the traceback, and all of it as a message."""
    frames = traceback.extract_tb(error.__traceback__)
    own = [frame for frame in frames if os.path.dirname(frame.filename) != os.path.dirname(__file__)]
    what = "".join(traceback.format_exception_only(error)).strip().splitlines()[-1]
    where = f" ({os.path.basename(own[-1].filename)}, line {own[-1].lineno}, in {own[-1].name})" if own else ""
    if own:
        words.message("error", own[-1].filename, "".join(traceback.format_exception(error)).rstrip())
    words.failed(what + where + when)


class _Lifeline:
    """Watches standard input: its end without the line `end` means that the orchestrator has died."""

    def __init__(self, words, standard_input):
        self._words, self.over, self.orphaned = words, False, False
        self._input = standard_input
        threading.Thread(target=self._watch, daemon=True).start()

    def _watch(self):
        ended = any(line == "end\n" for line in self._input)
        self.orphaned = not ended
        self.over = True
        time.sleep(_GRACE)
        # A computation continues, or a thread of the unit.
        if not ended:
            self.report()
            self.end_group()
        os._exit(0 if ended else _FAILED)

    def end_group(self):
        """Ends this process and what it has started: the orchestrator made a group of them, and can no longer end it."""
        if os.getpgrp() == os.getpid():
            os.killpg(0, signal.SIGKILL)

    def report(self):
        words = self._words
        when = f"in step {words.step}, iteration {words.iteration}" if words.step else "before the first step"
        # Written in one piece, because other units write the same.
        os.write(2, f"{words.unit}: the orchestrator died {when}; this unit ends\n".encode())
