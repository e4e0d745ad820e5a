#!/usr/bin/env python3
"""A physics server records to a disk that takes its time: somebody is told while it lasts, nothing is lost, and forces go on."""
import json
import os
import signal
import sys
import unittest

from laboratory import LaboratoryTest
from program import wait_until

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import check_mcap  # noqa: E402

SLOW_MS = 2500  # a call; as long as this the loops would stand still, were they ever to wait for one
WAITS = "the disk has not come back for a second"


class SlowDisk(LaboratoryTest):
    def test_it_is_told_while_it_lasts_and_the_loops_go_on(self):
        self.start_world("--arm-only")
        plain = self.environment
        self.environment = {**plain, "LD_PRELOAD": os.environ["SLOW_DISK_LIBRARY"], "SLOW_DISK_MS": str(SLOW_MS), "SLOW_DISK_AFTER": "150000", "SLOW_DISK_CALLS": "3"}
        physics = self.start_physics("--app", "touch", "--record", self.path("slow.mcap"), "--json", "physics.json")
        self.environment = plain
        wait_until(lambda: any(WAITS in line for line in physics.lines()), "the slow disk is told of")
        size = os.path.getsize(self.path("slow.mcap"))
        self.assertFalse(physics.ended(), physics.lines())
        wait_until(lambda: os.path.getsize(self.path("slow.mcap")) > size + 200_000, "the recording goes on")
        physics.send(signal.SIGINT)
        self.assertEqual(physics.ends().code, 0, physics.lines())
        figures = json.loads(self.read("physics.json"))
        self.assertEqual(figures["recording"]["dropped"], {})
        self.assertEqual(figures["recording"]["missed"], 0)
        self.assertEqual(check_mcap.check(self.path("slow.mcap"))["topics"]["/arm/sample"], figures["haptic"]["ticks"])
        self.assertLess(figures["haptic"]["jitter_us"]["max"], 1000 * SLOW_MS, "no tick waited for the disk")
        self.runs("replay", "slow.mcap", "--verify")

    def test_a_disk_that_never_comes_back_keeps_nobody_from_ending(self):
        self.start_world("--arm-only")
        plain = self.environment
        self.environment = {**plain, "LD_PRELOAD": os.environ["SLOW_DISK_LIBRARY"], "SLOW_DISK_MS": "3600000", "SLOW_DISK_AFTER": "150000",
                            "SLOW_DISK_CALLS": "1"}
        physics = self.start_physics("--app", "touch", "--record", self.path("slow.mcap"))
        self.environment = plain
        wait_until(lambda: any(WAITS in line for line in physics.lines()), "the slow disk is told of")
        physics.send(signal.SIGTERM)
        done = physics.ends()
        self.assertEqual(done.code, 1, done)
        self.assertIn("the disk does not take the rest", done.lines[-1])
        self.runs("recording", "repair", "slow.mcap", "whole.mcap")
        self.assertGreater(check_mcap.check(self.path("whole.mcap"))["topics"]["/arm/sample"], 100)


if __name__ == "__main__":
    unittest.main()
