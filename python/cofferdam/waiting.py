"""Waits for the orchestrator's next request."""

import ctypes
import os
import time

# As orchestrator/shared-memory/src/transport/wait.rs, which gives the reasons; s.
SPIN = 6e-6
YIELD = 100e-6
SHORTEST_NAP = 20e-6
LONGEST_NAP = 1e-3
NAP_SHARE = 50
AROUND = 150e-6
CROWDED = 1e-3
SHY = 50e-3

_PR_SET_TIMERSLACK = 29


class Wait:
    """Spins, then yields, then sleeps until the request is expected; sleeps at once where others keep the cores busy."""

    def __init__(self):
        self._began, self._last, self._shy_until = time.perf_counter(), 0.0, 0.0

    def begin(self):
        self._began = time.perf_counter()

    def end(self):
        self._last = time.perf_counter() - self._began

    def pause(self):
        waited = time.perf_counter() - self._began
        if waited < SPIN:
            return
        soon = max(self._last - AROUND, 0.0)
        if waited < YIELD or soon <= waited < self._last + AROUND:
            self._give_way(self._began + waited)
        else:
            nap = min(max(waited / NAP_SHARE, SHORTEST_NAP), LONGEST_NAP)
            time.sleep(min(nap, soon - waited) if waited < soon else nap)

    def _give_way(self, now):
        if now < self._shy_until:
            time.sleep(SHORTEST_NAP)
            return
        os.sched_yield()
        if time.perf_counter() - now > CROWDED:
            self._shy_until = now + SHY


def shorten_naps():
    """Makes sleeps of the calling thread precise; if this fails, they are only longer."""
    ctypes.CDLL(None).prctl(_PR_SET_TIMERSLACK, 1, 0, 0, 0)
