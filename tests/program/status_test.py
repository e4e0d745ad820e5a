#!/usr/bin/env python3
"""palpate status: a running system as a person and a program see it."""
import csv
import json
import unittest

from laboratory import LaboratoryTest
from program import wait_until


class Status(LaboratoryTest):
    def test_without_a_server_it_says_so(self):
        self.refuses(["status", "--connect", f"ipc://{self.root}/nobody.sock"], 1, "no physics server answers", "palpate physics")

    def test_loops_clients_and_exchange_of_a_running_system_are_shown(self):
        world, physics = self.start_world(), self.start_physics()
        # Its clock pretends to be 5 s ahead: that of the server is then 5 s behind.
        graphics = self.start_graphics("--disguise-offset-s", "5", "--out", "logs")
        seen = {}

        def screen():
            nonlocal seen
            seen = json.loads(self.runs("status", "--json", "-").out)
            return any(c["name"] == "graphics" and c["frames"] > 5 for c in seen["clients"])
        wait_until(screen, "the graphics server tells how it is doing")
        self.assertEqual([loop["name"] for loop in seen["loops"]], ["haptic", "physics"])
        for loop in seen["loops"]:
            self.assertGreater(loop["ticks"], 0)
            self.assertGreater(sum(loop["late_octaves_from_16_ns"]), 0)
            self.assertLessEqual(loop["late_us"]["p50"], loop["late_us"]["p99"])
        # On a busy machine the laboratory may stand still for milliseconds: forces are degraded then.
        self.assertIn(seen["loops"][0]["condition"].split(":")[0], ["ready", "running", "degraded"])
        self.assertEqual(seen["loops"][1]["condition"], "")
        shown = next(c for c in seen["clients"] if c["name"] == "graphics")
        self.assertEqual(shown["role"], "operator")
        self.assertGreater(shown["round_trip_us"]["median"], 0)
        self.assertAlmostEqual(shown["clock_offset_s"], -5.0, delta=0.1)  # one machine, one clock
        self.assertGreater(shown["clock_uncertainty_us"], 0)
        self.assertGreater(seen["service"]["requests"], 0)
        view = self.runs("status", "--once").out
        for words in ("pingpong at ipc://", "haptic loop", "forces ", "overruns", "under", "graphics     operator", "round trip", "states answered"):
            self.assertIn(words, view)
        self.assertRegex(view, r"clock -(5\.0|4\.9)\d+ s \+- ")
        self.assertNotIn("\x1b", view)
        self.assertEqual(self.stop_in_order(graphics, physics, world), [[], [], []])
        # What it told meanwhile, beside its own log of each frame: a moment's count is that of some moment of the log.
        rows = list(csv.DictReader(self.read("logs", "realtime_frames.csv").decode().splitlines()))
        self.assertLessEqual(shown["frames"], len(rows))
        self.assertEqual(shown["late"], sum(int(row["late"]) for row in rows[:shown["frames"]]))
        until = float(rows[shown["frames"] - 1]["time_s"])
        self.assertLessEqual(shown["rate_hz"], 1.001 * shown["frames"] / until)
        self.assertGreater(shown["rate_hz"], 0)


if __name__ == "__main__":
    unittest.main()
