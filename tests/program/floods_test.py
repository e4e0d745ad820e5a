#!/usr/bin/env python3
"""Messages without end and messages that do not end: the physics server keeps its memory, serves its observers and ends when it is asked to."""
import signal
import sys
import threading
import time
import unittest

from guarded import GuardedServerTest
from program import resident_mib, wait_until

MOST_MIB = 32.0   # that a flood may take, and leave behind
GAP_S = 1.0       # of an observer's states, which starves beside the others of a busy machine; 0.1 s on a quiet one, it was 27 s
END_S = 2.0       # of the server
COMES_IN_S = 2.0  # an operator beside a flood; 0.35 s on a quiet machine


class Watching(threading.Thread):
    """An observer that notes the longest time without a state."""

    def __init__(self, observer, subscribe):
        super().__init__(daemon=True)
        self.observer, self.subscribe, self.longest, self.stop = observer, subscribe, 0.0, threading.Event()
        self.start()

    def run(self):
        last = renewed = time.monotonic()
        while not self.stop.is_set():
            now = time.monotonic()
            if now - renewed > 0.5:
                self.observer.say(subscribe=self.subscribe)
                renewed = now
            if self.observer.hears(0.1):
                now = time.monotonic()
                self.longest, last = max(self.longest, now - last), now
        self.longest = max(self.longest, time.monotonic() - last)

    def end(self):
        self.stop.set()
        self.join()


class Floods(GuardedServerTest):
    def setUp(self):
        super().setUp()
        self.admit("observer", self.guest, "guest")
        self.physics = self.start_server()

    def serve_through(self, what, *flood, **beside):
        """Where others keep the machine busy, what has come waits in memory for its turn, and so do states: a second time then."""
        for _ in range(2):
            more, gap = self.flood(what, *flood, **beside)
            if more < MOST_MIB and gap < GAP_S:
                return
        self.fail(f"{what}: {more:.0f} MiB more, a gap of {gap:.2f} s, twice beyond the bounds")

    def flood(self, what, many, port, seconds, pairs=None, meanwhile=None):
        """A flood beside an observer: what the server takes more at most, in MiB, and the observer's longest gap, in s."""
        process = self.physics.process.pid
        observer = self.comes_in(self.screen)
        before = most = resident_mib(process)
        watching = Watching(observer, self.wire.Subscribe(rate_hz=100))
        self.addCleanup(watching.end)
        leave = [self.crowd(what, many, f"tcp://127.0.0.1:{port}", *self.with_keys(pair)) for pair in pairs or [self.guest]]
        until = time.monotonic() + seconds
        while time.monotonic() < until:
            most = max(most, resident_mib(process))
            if meanwhile:
                meanwhile()
            time.sleep(0.02)
        for end in leave:
            end()
        wait_until(lambda: resident_mib(process) < before + MOST_MIB, "the memory comes back")  # looked at once a second
        watching.end()
        observer.socket.close()
        print(f"{what} x {many}: {most - before:.0f} MiB more at most, {resident_mib(process) - before:.0f} MiB left, gap {watching.longest:.2f} s", file=sys.stderr)
        self.assertFalse(self.physics.ended(), self.physics.lines())
        return most - before, watching.longest

    def operator_comes_in(self):
        """A new connection of an operator is answered in time."""
        begun = time.monotonic()
        operator = self.peer(self.chief, self.port)
        self.status(operator, COMES_IN_S)
        self.waited.append(time.monotonic() - begun)
        operator.socket.close()

    def ends_in_time(self, beside):
        begun = time.monotonic()
        self.physics.send(signal.SIGTERM)
        self.assertEqual(self.physics.ends().code, 0)
        print(f"ends {time.monotonic() - begun:.2f} s after SIGTERM, {beside}", file=sys.stderr)
        self.assertLess(time.monotonic() - begun, END_S, beside)

    def test_messages_of_any_size_from_few_and_many_connections(self):
        for port in (self.port, self.port + 1):
            for many in (1, 30):
                for size in (13, 64, 1000, 3900, 60000):
                    self.serve_through(f"flood-{size}", many, port, 0.7)
        self.ends_in_time("after floods")

    def test_several_keys_together_and_an_operator_who_comes_in(self):
        pairs, self.waited = [self.pair() for _ in range(4)], []
        for number, pair in enumerate(pairs):
            self.admit("observer", pair, f"guest{number}")
        for port in (self.port, self.port + 1):
            for what in ("40", "3000", "hello"):
                self.serve_through(f"flood-{what}", 8, port, 0.7, pairs, self.operator_comes_in)
        self.assertGreaterEqual(len(self.waited), 10)
        print(f"{len(self.waited)} times an operator came in within {max(self.waited):.2f} s", file=sys.stderr)

    def test_the_end_comes_during_a_flood(self):
        self.crowd("flood-1000", 30, f"tcp://127.0.0.1:{self.port}", *self.with_keys(self.guest))
        self.crowd("flood-60000", 1, f"tcp://127.0.0.1:{self.port + 1}", *self.with_keys(self.guest))
        time.sleep(0.5)
        self.ends_in_time("during floods")


if __name__ == "__main__":
    unittest.main()
