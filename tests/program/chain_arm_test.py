#!/usr/bin/env python3
"""An arm that is no PHANToM goes into the rig: what stands there puts its tip where a laser tracker saw it."""
import csv
import math
import os
import tomllib
import unittest

from program import ProgramTest

UR5 = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "data", "ur5_laser_tracker")
ARM = os.path.join(UR5, "ur5.toml")
GRID = os.path.join(UR5, "3D_UR5_uncalibrated_grid_cleaned.csv")
UNSEEN = os.path.join(UR5, "3D_UR5_uncalibrated_random_cleaned.csv")


def times(A, B):
    return [[sum(A[i][k] * B[k][j] for k in range(4)) for j in range(4)] for i in range(4)]


def row_matrix(row, theta):
    """One Denavit-Hartenberg row, as textbooks print it."""
    t, alpha = math.radians(theta + row["theta_offset_deg"]), math.radians(row["alpha_deg"])
    ct, st, ca, sa = math.cos(t), math.sin(t), math.cos(alpha), math.sin(alpha)
    return [[ct, -st * ca, st * sa, row["a_mm"] * ct], [st, ct * ca, -ct * sa, row["a_mm"] * st],
            [0, sa, ca, row["d_mm"]], [0, 0, 0, 1]]


def base_matrix(base):
    w, x, y, z = base["rotation_qwxyz"]
    p = base["translation_mm"]
    return [[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y), p[0]],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x), p[1]],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y), p[2]], [0, 0, 0, 1]]


def tip(arm, readings):
    X = base_matrix(arm["base"])
    for row, psi, gain, offset in zip(arm["joint"], readings, arm["gains"], arm["offsets_deg"]):
        X = times(X, row_matrix(row, gain * psi + offset))
    return [sum(X[i][k] * v for k, v in enumerate([*arm["tool_mm"], 1.0])) for i in range(3)]


class ChainArm(ProgramTest):
    def rig(self):
        with open(self.path("rig.toml"), "rb") as file:
            return tomllib.load(file)

    def mean_error(self, arm):
        with open(UNSEEN, encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
        errors = []
        for row in rows:
            angles = [float(row[f"joint_{j}"]) for j in range(1, 7)]
            seen = [float(row[f"{axis}_t"]) + float(row[f"{axis}_dif"]) for axis in "xyz"]
            errors.append(math.dist(tip(arm, angles), seen))
        return sum(errors) / len(errors)

    def calibrate(self, *more):
        self.runs("calibrate", "arm", "--samples", GRID, "--test", UNSEEN, "--free", "gains,offsets", "--rig", "rig.toml", *more)

    def test_its_calibration_is_kept_and_used(self):
        self.runs("rig", "new", "rig.toml")
        self.calibrate("--arm", ARM)
        rig = self.rig()
        self.assertEqual((rig["arm"]["model"], rig["arm"]["type"], rig["nominal_arm"]["name"]), ("ur5", "dh", "ur5"))
        self.assertLess(self.mean_error(rig["arm"]), 0.35)
        self.assertEqual(len(rig["arm"]["covariance_si"]), 24)
        shown = self.runs("rig", "show", "rig.toml").out
        for words in ("ur5", "6, a chain", "tool, mm", "nominal arm", "joints"):
            self.assertIn(words, shown)
        # The rig knows the arm from now on; its rows are free in a second run.
        self.runs("calibrate", "arm", "--samples", GRID, "--free", "gains,offsets,dh", "--rig", "rig.toml")
        again = self.rig()
        self.assertEqual(again["nominal_arm"], rig["nominal_arm"])
        self.assertLess(self.mean_error(again["arm"]), 0.2)

    def test_what_no_rig_can_hold_is_refused(self):
        self.runs("rig", "new", "rig.toml")
        before = self.rig()
        with open(ARM, encoding="utf-8") as file:
            rows = file.read()
        self.write("nine.toml", rows + 3 * "\n[[joint]]\na_mm = 0\nalpha_deg = 0\nd_mm = 1\n")
        self.refuses(["calibrate", "arm", "--arm", "nine.toml", "--samples", GRID, "--rig", "rig.toml"], 2, "9 joints", "3 to 8")
        self.assertEqual(self.rig(), before)

    def test_readings_at_rest_are_as_many_as_joints(self):
        self.runs("rig", "new", "rig.toml")
        self.calibrate("--arm", ARM)
        self.refuses(["rig", "check", "rig.toml", "--rest-readings", "1,2,3"], 2, "3 readings", "6 joints")


if __name__ == "__main__":
    unittest.main()
