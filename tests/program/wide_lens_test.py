#!/usr/bin/env python3
"""A camera that sees 150 degrees from corner to corner: its lens from a board, a demo with it, and what is not a wide lens."""
import json
import os
import re
import subprocess
import sys
import unittest

from program import ProgramTest

HERE = os.path.dirname(os.path.abspath(__file__))
WIDE = dict(fx="305.0", fy="304.2", cx="321.4", cy="238.0", distortion="[0.021, -0.013, 0.004, -0.0009, 0.0]")

RATIONAL = dict(fx="420.0", fy="419.1", cx="317.4", cy="241.0", distortion="[0.45, 0.05, 0.0006, -0.0004, 0.002]")  # 120 degrees


class WideLens(ProgramTest):
    def setUp(self):
        super().setUp()
        self.world("wide.toml", 'lens = "fisheye"', WIDE)

    def world(self, name, lens, values):
        self.runs("world", "new", name)
        before, camera, after = self.read(name).decode().partition("\n[camera]\n")
        for key, value in values.items():
            after = re.sub(rf"^{key} = .*$", f"{key} = {value}", after, count=1, flags=re.M)
        self.write(name, before + camera + lens + "\n" + after)

    def test_the_lens_comes_back_from_views_of_a_board(self):
        self.runs("world", "sample", "camera", "--world", "wide.toml", "--out", "sim")
        truth = json.loads(self.read("sim", "truth.json"))
        self.assertEqual((truth["lens"], len(truth["distortion"])), ("fisheye", 4))
        command = ["calibrate", "camera", "--corners", "sim/corners.csv", "--board", "9x6", "--square-mm", "25"]
        self.runs(*command, "--lens-model", "fisheye", "--json", "lens.json", "--out", "rig.toml")
        lens = json.loads(self.read("lens.json"))
        for key in ("fx", "fy", "cx", "cy"):
            self.assertLess(abs(lens[key] - truth[key]), 5 * lens["std"][key])
        self.assertLess(lens["rms_px"], 0.3)
        # As the rig file and the forms of others have it.
        self.runs("export", "rig.toml", "--as", "camera-info", "--out", "ros.yaml")
        self.assertIn("distortion_model: equidistant", self.read("ros.yaml").decode())
        self.runs("convert", "ros.yaml", "again.json")
        again = json.loads(self.read("again.json"))
        self.assertEqual(again["lens"], "fisheye")
        self.assertEqual(again["distortion"], lens["distortion"])

    def test_a_demo_holds_its_overlay(self):
        self.runs("demo", "--headless", "--quick", "--world", "wide.toml", "--seed", "3", "--out", "report")
        registration = json.loads(self.read("report", "summary.json"))["registration"]
        self.assertLessEqual(registration["world_px_rms"], 0.4)
        self.assertLessEqual(registration["tip_px_rms"], 0.6)
        checked = subprocess.run([sys.executable, os.path.join(HERE, "..", "recompute.py"), self.path("report")], capture_output=True, text=True)
        self.assertEqual(checked.returncode, 0, checked.stdout + checked.stderr)

    def test_a_rational_lens_from_a_board_to_the_picture(self):
        self.world("rational.toml", 'lens = "rational"\ndenominator = [0.78, 0.17, 0.011]', RATIONAL)
        self.runs("world", "sample", "camera", "--world", "rational.toml", "--out", "sim")
        truth = json.loads(self.read("sim", "truth.json"))
        self.assertEqual((truth["lens"], len(truth["distortion"])), ("rational", 8))
        command = ["calibrate", "camera", "--corners", "sim/corners.csv", "--board", "9x6", "--square-mm", "25"]
        self.runs(*command, "--lens-model", "rational", "--json", "lens.json", "--out", "part.toml")
        lens = json.loads(self.read("lens.json"))
        self.assertEqual((len(lens["distortion"]), len(lens["covariance"]["order"])), (8, 12))
        for key in ("fx", "fy", "cx", "cy"):
            self.assertLess(abs(lens[key] - truth[key]), 5 * lens["std"][key])
        self.runs("export", "part.toml", "--as", "camera-info", "--out", "ros.yaml")
        self.assertIn("distortion_model: rational_polynomial", self.read("ros.yaml").decode())
        self.runs("convert", "ros.yaml", "again.json")
        self.assertEqual(json.loads(self.read("again.json"))["distortion"], lens["distortion"])
        self.runs("demo", "--headless", "--quick", "--world", "rational.toml", "--seed", "3", "--out", "report")
        registration = json.loads(self.read("report", "summary.json"))["registration"]
        self.assertLessEqual(registration["world_px_rms"], 0.4)
        self.assertLessEqual(registration["tip_px_rms"], 0.6)
        checked = subprocess.run([sys.executable, os.path.join(HERE, "..", "recompute.py"), self.path("report")], capture_output=True, text=True)
        self.assertEqual(checked.returncode, 0, checked.stdout + checked.stderr)
        rig = self.read("report", "rig.toml").decode()
        self.assertIn('lens = "rational"', rig)
        self.runs("rig", "show", "report/rig.toml")

    def test_what_is_no_wide_lens_is_refused(self):
        text = self.read("wide.toml").decode()
        self.write("bad.toml", text.replace('lens = "fisheye"', 'lens = "fish"'))
        self.refuses(["world", "show", "bad.toml"], 2, "bad.toml", "camera.lens", 'one of "brown", "fisheye", "rational" is expected')
        self.write("rig.toml", 'rig_version = 1\n[camera]\nwidth_px = 640\nheight_px = 480\nfx_px = 300\nfy_px = 300\ncx_px = 320\ncy_px = 240\n'
                               'lens = "fisheye"\ndistortion = [0.1, 0.0, 0.0, 0.0, 0.2]\n')
        self.refuses(["rig", "show", "rig.toml"], 2, "rig.toml", "k1 k2 k3 k4", "0 is expected")


if __name__ == "__main__":
    unittest.main()
