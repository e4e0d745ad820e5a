#!/usr/bin/env python3
"""palpate verify: a rig as it was calibrated, and after something was knocked; alone in the simulated laboratory and with a person at the devices."""
import json
import os
import sys
import tomllib
import unittest

from person_at_devices import Laboratory, Session
from program import ProgramTest

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import check_mcap  # noqa: E402

SEED = "5"
LIVE = ("--arm", "lab", "--tracker", "lab", "--camera", "lab", "--rig", "rig.toml", "--quick")


class Verify(ProgramTest):
    def knocked(self, name, lines):
        with open(self.path(name), "w", encoding="utf-8") as file:
            file.write("[knock]\n" + lines + "\n")
        return name

    def recorded(self, file, topics, attachments):
        """Whole, and with what it should hold."""
        found = check_mcap.check(self.path(file))
        self.assertLessEqual(topics, found["topics"].keys())
        for topic in topics:
            self.assertGreater(found["topics"][topic], 50, topic)
        self.runs("recording", "export", file, "--attachments", file + "-files")
        self.assertLessEqual(attachments, set(os.listdir(self.path(file + "-files"))))

    def last(self):
        return tomllib.loads(self.read("rig.toml").decode())["verification"][-1]

    def test_a_rig_that_holds_a_knocked_base_and_a_person_who_finds_the_camera_moved(self):
        self.runs("calibrate", "all", "--rig", "rig.toml", "--seed", SEED, "--poses", "30", "--record", "all.mcap")
        self.recorded("all.mcap", {"/arm/sample", "/tracker/sample", "/camera/left/stamp"}, {"rig-before.toml", "rig.toml", "arm.csv", "hand.csv"})
        held = self.runs("verify", "--quick", "--rig", "rig.toml", "--seed", SEED, "--json", "held.json", "--record", "held.mcap")
        self.recorded("held.mcap", {"/arm/sample", "/tracker/sample", "/camera/left/stamp"}, {"rig-before.toml", "rig.toml"})
        self.assertIn(f"in the simulated laboratory (--seed {SEED}; no --arm, --tracker and --camera)", held.out)
        self.assertIn("the rig holds", held.out)
        result = json.loads(self.read("held.json"))
        self.assertTrue(result["holds"])
        self.assertEqual(result["changes"], [])
        self.assertGreaterEqual(result["touched"], 5)
        self.assertLess(result["seconds"], 40)
        for name in ("arm_mm", "places_mm", "picture_px", "tip_px", "camera_delay_ms"):
            figure = result["figures"][name]
            low, high = figure["interval_95"]
            self.assertTrue(low <= figure["error"] <= high, (name, figure))
        kept = self.last()
        self.assertTrue(kept["holds"])
        self.assertEqual(kept["arm_mm"][0], result["figures"]["arm_mm"]["error"])
        shown = self.runs("rig", "show", "rig.toml").out
        self.assertIn(f"{kept['date']}, quick: holds", shown)
        self.assertIn(f"arm_mm               {kept['arm_mm'][0]:.3f} (", shown)

        world = self.knocked("base.toml", "base_mm = [1.5, 0, 1]")
        done = self.run_program("verify", "--quick", "--rig", "rig.toml", "--seed", SEED, "--world", world, "--json", "base.json")
        self.assertEqual(done.code, 1, done)
        for words in ("arm base", "palpate calibrate arm", f"or it was calibrated in another laboratory than the simulated one of --seed {SEED}"):
            self.assertIn(words, done.err)
        result = json.loads(self.read("base.json"))
        self.assertFalse(result["holds"])
        self.assertEqual([change["what"] for change in result["changes"]], ["arm base"])
        self.assertEqual(self.last()["changed"], ["arm base"])

        world = self.knocked("camera.toml", "camera_deg = [0.5, 0.5, 0]")
        laboratory = Laboratory(self, "--seed", SEED, "--world", world)
        session = Session(self, laboratory, *LIVE, "--json", "camera.json", "--record", "camera.mcap", command=("verify",))
        self.assertEqual(session.ends(), 1, session.lines[-5:])
        self.assertIn("camera", session.lines[-1])
        self.assertNotIn("laboratory", session.lines[-1])
        result = json.loads(self.read("camera.json"))
        self.assertEqual([change["what"] for change in result["changes"]], ["camera"])
        self.assertEqual([told["of"] for told in session.shown if "step" in told][0], 4)
        self.recorded("camera.mcap", {"/arm/sample", "/tracker/sample", "/camera/left/stamp"}, {"rig-before.toml", "rig.toml"})

    def test_a_rig_of_another_laboratory_is_not_called_this_ones(self):
        self.runs("calibrate", "all", "--rig", "rig.toml", "--seed", SEED, "--poses", "30")
        again = self.runs("calibrate", "all", "--rig", "rig.toml", "--seed", "12", "--poses", "30")
        self.assertIn("what is kept was calibrated in another", again.err)
        self.assertIn("with parts of another", again.out)

    def test_what_cannot_be_verified_is_refused(self):
        self.refuses(["verify", "--rig", "none.toml"], 2, "no such file")
        self.runs("rig", "new", "new.toml")
        self.refuses(["verify", "--rig", "new.toml"], 1, "lacks its arm", "palpate calibrate all")
        self.assertNotIn("another laboratory", self.run_program("verify", "--rig", "new.toml").err)
        self.refuses(["verify", "--rig", "new.toml", "--arm", "lab"], 2, "--tracker is missing")


if __name__ == "__main__":
    unittest.main()
