#!/usr/bin/env python3
"""An arm that states its place: a delta arm that is not as its maker has it goes into the rig, and what stands there puts its
tip where it is. The delta arm and the reader of the rig are this file's own."""
import math
import random
import tomllib
import unittest

from delta import place, readings, tip, turned
from program import ProgramTest

MADE = [(2 * math.pi * i / 3, 30.0, 110.0, 200.0, 0.0) for i in range(3)]  # azimuth, offset, upper, lower (mm), zero
MIDDLE = (0.0, 0.0, 170.0)
ARM = 'name = "delta"\ntype = "cartesian"\nrange_mm = [[-70, 70], [-70, 70], [125, 215]]\n'


class CartesianArm(ProgramTest):
    BASE = ((math.cos(0.3), 0.0, math.sin(0.3), 0.0), (100.0, -400.0, 750.0))

    def setUp(self):
        super().setUp()
        self.random = random.Random(5)
        vary = self.random.gauss
        self.built = [(a + vary(0, 0.005), o + vary(0, 0.3), u + vary(0, 0.2), l + vary(0, 0.3), z + vary(0, 0.008))
                      for a, o, u, l, z in MADE]
        self.write("delta.toml", ARM)

    def somewhere(self):
        return [m + self.random.uniform(-s, s) for m, s in zip(MIDDLE, (70, 70, 45))]

    def stated(self, p):
        return place(MADE, readings(self.built, p))

    def in_world(self, p):
        return [a + b for a, b in zip(turned(self.BASE[0], p), self.BASE[1])]

    def samples(self, name, count, noise):
        rows = ["arm_x_mm,arm_y_mm,arm_z_mm,x_mm,y_mm,z_mm"]
        for _ in range(count):
            p = self.somewhere()
            seen = [x + self.random.gauss(0, noise) for x in self.in_world(p)]
            rows.append(",".join(map(repr, [*self.stated(p), *seen])))
        self.write(name, "\n".join(rows) + "\n")

    def mean_error(self, arm):
        errors = []
        for _ in range(300):
            p = self.somewhere()
            errors.append(math.dist(tip(arm, self.stated(p)), self.in_world(p)))
        return sum(errors) / len(errors), max(errors)

    def test_the_delta_of_this_file_goes_there_and_back(self):
        for _ in range(20):
            p = self.somewhere()
            self.assertLess(math.dist(place(self.built, readings(self.built, p)), p), 1e-9)

    def test_its_calibration_is_kept_and_puts_the_tip_where_it_is(self):
        self.samples("samples.csv", 120, 0.05)
        self.runs("rig", "new", "rig.toml")
        told = self.runs("calibrate", "arm", "--samples", "samples.csv", "--arm", "delta.toml", "--rig", "rig.toml", "--json", "arm.json").out
        self.assertIn("correction", told)
        self.assertNotIn("gains", told)
        with open(self.path("rig.toml"), "rb") as file:
            rig = tomllib.load(file)
        arm = rig["arm"]
        self.assertEqual((arm["model"], arm["type"], rig["nominal_arm"]["name"]), ("delta", "cartesian", "delta"))
        self.assertNotIn("gains", arm)
        self.assertEqual(len(arm["covariance_si"]), 39)
        mean, most = self.mean_error(arm)
        self.assertLess(mean, 0.1)
        self.assertLess(most, 0.25)
        plain = dict(arm, correction_mm=[0.0] * 24)
        self.assertGreater(self.mean_error(plain)[0], 3 * mean)
        for words in ("delta, which states its place", "range x, y, z, mm", "correction, mm", "rest readings, mm"):
            self.assertIn(words, self.runs("rig", "show", "rig.toml").out)
        # Out again, and in again: the calibrated arm as an arm's file, and the rig that knows it.
        self.runs("export", "rig.toml", "--as", "arm", "--out", "again.toml")
        with open(self.path("again.toml"), "rb") as file:
            again = tomllib.load(file)
        for a, b in zip(again["correction_mm"], arm["correction_mm"]):
            self.assertAlmostEqual(a, b, delta=1e-9)
        self.assertEqual(self.runs("export", "rig.toml", "--as", "urdf").out.count('type="prismatic"'), 3)
        self.runs("calibrate", "arm", "--samples", "samples.csv", "--rig", "rig.toml")
        self.refuses(["rig", "check", "rig.toml", "--rest-readings", "0.5,0.2,0"], 1, "does not tell what the arm read at rest", "rest_readings_mm")
        self.refuses(["calibrate", "arm", "--samples", "samples.csv", "--rig", "rig.toml", "--rest-readings", "0,0,0,0"], 2, "4 readings are given")
        self.runs("calibrate", "arm", "--samples", "samples.csv", "--rig", "rig.toml", "--rest-readings", "0,0,0")
        self.assertIn("unchanged", self.run_program("rig", "check", "rig.toml", "--rest-readings", "0.5,0.2,0").out)
        self.refuses(["rig", "check", "rig.toml", "--rest-readings", "0.5,0.2,4"], 1, "joint 3 reads 4.000 mm, 0.000 then")

    def test_what_does_not_fit_is_refused(self):
        self.samples("samples.csv", 60, 0.05)
        self.write("joints.csv", "joint_1_deg,joint_2_deg,joint_3_deg,x_mm,y_mm,z_mm\n" + "1,2,3,4,5,6\n" * 9)
        with_arm = ["--arm", "delta.toml"]
        self.refuses(["calibrate", "arm", "--samples", "joints.csv", *with_arm], 2, "holds joint readings", "arm_x_mm,arm_y_mm,arm_z_mm is expected")
        self.refuses(["calibrate", "arm", "--samples", "samples.csv", "--arm", "phantom-premium-1.5"], 2, "holds places of a Cartesian arm")
        self.refuses(["calibrate", "arm", "--samples", "samples.csv", *with_arm, "--free", "gains"], 2, "correction, tip or delay is expected")
        self.refuses(["calibrate", "arm", "--samples", "samples.csv", *with_arm, "--method", "eq7"], 2, "use the joint method")
        self.write("metres.csv", self.read("samples.csv").replace(b"arm_x_mm,arm_y_mm,arm_z_mm", b"arm_x_m,arm_y_m,arm_z_m"))
        self.refuses(["calibrate", "arm", "--samples", "metres.csv", *with_arm], 1, "check")
        self.write("broken.toml", ARM.replace("[125, 215]", "[215, 125]"))
        self.refuses(["calibrate", "arm", "--samples", "samples.csv", "--arm", "broken.toml"], 2, "broken.toml:3: range_mm", "lower end first")


if __name__ == "__main__":
    unittest.main()
