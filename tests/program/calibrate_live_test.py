#!/usr/bin/env python3
"""palpate calibrate all with a person at the devices: asked in words, answered by keys, seen in the devices' streams alone."""
import json
import math
import signal
import tomllib
import unittest

from person_at_devices import Laboratory, Session
from program import ProgramTest

DEVICES = ("--arm", "lab", "--tracker", "lab", "--camera", "lab", "--rig", "rig.toml", "--poses", "20")
SEED = "5"


class CalibrateLive(ProgramTest):
    def truth(self, kind):
        self.runs("world", "sample", kind, "--seed", SEED, "--out", f"truth-{kind}")
        return json.loads(self.read(f"truth-{kind}", "truth.json"))

    def test_a_person_who_does_what_is_shown_ends_at_a_complete_rig(self):
        self.runs("rig", "new", "rig.toml")
        laboratory = Laboratory(self, "--seed", SEED)
        # The first session is broken off after the surfaces; the second goes on there.
        first = Session(self, laboratory, *DEVICES, at_the_end=lambda step, ended: "q" if step == "table and wall" else "\n")
        self.assertEqual(first.ends(), 1, first.lines)
        self.assertIn("goes on with the next", first.lines[-1])
        self.assertEqual([ended["ended"] for ended in first.ended], ["pointer tip", "table and wall"])
        repeated = []

        def once_again(step, ended):
            if not ended["done"]:
                self.assertLess(repeated.count(step), 3, ended)
                repeated.append(step)
                return "r"
            return "\n"
        second = Session(self, laboratory, *DEVICES, at_the_end=once_again)
        self.assertEqual(second.ends(), 0, second.lines[-5:])
        self.assertEqual([ended["ended"] for ended in second.ended if ended["done"]],
                         ["landmarks", "stylus tip", "arm", "delay of the tracker", "lens and hand-eye", "landmarks from pictures"])
        self.assertEqual([told["kept"] for told in second.shown if "kept" in told], ["pointer tip", "table and wall"])
        rig = tomllib.loads(self.read("rig.toml").decode())
        self.assertIn("complete", self.runs("rig", "check", "rig.toml").out)
        self.assertLess(rig["arm"]["held_out_mean_mm"], 0.5)
        # Each step bears the time of its own end.
        dates = [rig[part]["date"] for part in ("pointer_pivot", "tip_pivot", "arm", "hand_eye", "landmarks_from")]
        self.assertEqual(dates, sorted(set(dates)))
        self.assertEqual(rig["landmarks_from"]["method"], "head-motion")
        tip = math.dist(rig["pointer_pivot"]["tip_mm"], self.truth("pointer")["tip_mm"])
        self.assertLess(tip, 0.5)
        self.assertEqual([told["of"] for told in second.shown if "step" in told][0], 8)

    def test_ctrl_c_keeps_what_is_done_and_says_how_to_go_on(self):
        self.runs("rig", "new", "rig.toml")
        laboratory = Laboratory(self, "--seed", SEED)
        session = None

        def interrupt(step, ended):
            session.process.send_signal(signal.SIGINT)
            return ""
        session = Session(self, laboratory, *DEVICES, at_the_end=interrupt)
        self.assertEqual(session.ends(), 1, session.lines)
        self.assertIn("stopped", session.lines[-1])
        self.assertIn("pointer_pivot", tomllib.loads(self.read("rig.toml").decode()))

    def test_what_is_missing_is_named(self):
        self.runs("rig", "new", "rig.toml")
        self.refuses(["calibrate", "all", "--arm", "lab", "--rig", "rig.toml"], 2, "--tracker is missing")
        self.refuses(["calibrate", "all", *DEVICES[:6], "--rig", "none.toml"], 2, "no such file", "palpate rig new")
        self.refuses(["calibrate", "all", "--arm", "nowhere:1", *DEVICES[2:]], 2, "nowhere:1")
        self.says_no(self.run_program("calibrate", "all", *DEVICES), 1, "laboratory")  # it has looked for it in its folder


if __name__ == "__main__":
    unittest.main()
