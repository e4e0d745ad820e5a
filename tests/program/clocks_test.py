#!/usr/bin/env python3
"""Clocks that are set, run backwards or stand still while the servers run: forces stay within their rules, and nobody hangs."""
import json
import os
import signal
import struct
import time
import unittest

from laboratory import StandInArmTest
from program import wait_until

HOUR = 3600 * 10**9
WELL = ("ready", "running", "degraded")


class Clocks(StandInArmTest):
    def setUp(self):
        super().setUp()
        self.clock, self.plain = os.path.join(self.root, "clock"), dict(self.environment)
        with open(self.clock, "wb") as file:
            file.write(bytes(32))

    def shifted(self, yes):
        """Whether what is started from here on goes by the shifted clock."""
        self.environment = {**self.plain, "LD_PRELOAD": os.environ["SHIFTED_CLOCK_LIBRARY"], "SHIFTED_CLOCK": self.clock} if yes else self.plain

    def shift(self, wall_ns=0, monotonic_ns=0, stops_ns=0, goes_on_ns=0):
        with open(self.clock, "r+b") as file:
            file.write(struct.pack("4q", wall_ns, monotonic_ns, stops_ns, goes_on_ns))

    def seen(self):
        return json.loads(self.runs("status", "--json", "-").out)

    def goes_on(self, *servers):
        """Loops and frames, with forces that may be given."""
        before = self.seen()

        def more():
            now = self.seen()
            for server in servers:
                self.assertFalse(server.ended(), server.lines())
            frames = [sum(c["frames"] for c in seen["clients"]) for seen in (before, now)]
            return (frames[1] > frames[0] + 5 and all(b["ticks"] > a["ticks"] + 200 for a, b in zip(before["loops"], now["loops"]))
                    and now["loops"][0]["condition"].split(":")[0] in WELL)
        wait_until(more, "loops and frames go on")

    def test_the_wall_clock_is_nobodys_business(self):
        self.plain["PALPATE_LOG"] = self.path("all.log")
        self.shifted(True)
        servers = world, physics, graphics = self.start_all()
        self.shifted(False)
        self.goes_on(*servers)
        for wall in (HOUR, -HOUR, -40 * 24 * 365 * HOUR):
            self.shift(wall_ns=wall)
            self.goes_on(*servers)
        self.assertEqual(self.stop_in_order(graphics, physics, world), [[], [], []])
        for line in self.read("all.log").decode().splitlines():
            self.assertRegex(line, r"^\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d\.\d{3}[+-]\d\d:\d\d (debug|info|warning|error) +\S")

    def test_clocks_that_stand_still_for_a_while_are_as_if_nothing_had_been(self):
        self.shifted(True)
        servers = self.start_all()
        self.shifted(False)
        self.goes_on(*servers)
        now = time.monotonic_ns()
        self.shift(stops_ns=now, goes_on_ns=now + 3 * 10**9)
        time.sleep(3.0)
        self.goes_on(*servers)
        for server in reversed(servers):
            server.send(signal.SIGTERM)
            self.assertEqual(server.ends().code, 0)

    def test_forces_are_off_or_as_they_should_be_after_a_monotonic_clock_has_jumped(self):
        """No kernel does that; a machine that is no longer the same might. The server goes on with its forces as before, or has none and says why."""
        self.mark_checked(self.ARM, "peak_n = 1.0")
        for jump in (HOUR, -HOUR):
            self.shift()
            self.shifted(True)
            physics = self.start_physics("--arm", "openhaptics")
            self.shifted(False)
            wait_until(lambda: self.seen()["loops"][0]["condition"] in ("ready", "running"), "forces are allowed")
            self.shift(monotonic_ns=jump)
            ticks = self.seen()["loops"][0]["ticks"]

            def decided(physics=physics, ticks=ticks):
                if physics.ended() or "forces are off" in "".join(physics.lines()):
                    return True
                done = self.run_program("status", "--json", "-")
                return done.code == 0 and json.loads(done.out)["loops"][0]["ticks"] > ticks + 1000
            wait_until(decided, "the loops go on, or forces are off")
            physics.send(signal.SIGTERM)
            done = physics.ends()
            self.assertIn(done.code, (0, 1), done)
            if done.code == 1:
                self.assertRegex(done.lines[-1], "does not come back|silent|stands still")


if __name__ == "__main__":
    unittest.main()
