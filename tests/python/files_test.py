#!/usr/bin/env python3
"""Files as the program reads them: poses in their forms, samples of an arm, rigs and the transforms that follow from them."""
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

import numpy as np

import palpate
from simulated import turn

PROGRAM = os.environ["PALPATE"]
DATA = pathlib.Path(__file__).parents[2] / "data"


class Files(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def write(self, name, text):
        path = self.folder / name
        path.write_text(text, encoding="ascii")
        return path

    def run_program(self, *arguments):
        subprocess.run([PROGRAM, *map(str, arguments)], check=True, capture_output=True, cwd=self.folder)

    def test_the_sources_alone_say_what_is_missing(self):
        sources = DATA.parent / "python"
        done = subprocess.run([sys.executable, "-c", "import palpate"], env={**os.environ, "PYTHONPATH": str(sources)}, capture_output=True,
                              text=True, cwd=self.folder)
        self.assertIn(f"ImportError: palpate: {sources}/palpate is without its compiled part", done.stderr)
        self.assertIn("docs/guides/python.md", done.stderr)

    def test_poses_in_millimetres_and_as_matrices(self):
        csv = self.write("a.csv", "time_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,place\n0.5,10,20,30,0.8,0,0.6,0,a\n1.5,-1,2,3,1,0,0,0,\n")
        poses = palpate.read_poses(csv, segments="place")
        np.testing.assert_allclose(poses.positions, [[0.01, 0.02, 0.03], [-0.001, 0.002, 0.003]])
        np.testing.assert_allclose(poses.time, [0.5, 1.5])
        self.assertEqual(poses.segments, ("a", None))
        np.testing.assert_allclose(np.asarray(poses)[0, :3, :3], turn(np.array([0, 2 * np.arcsin(0.6), 0])), atol=1e-12)
        matrix = np.asarray(poses)[0].copy()
        matrix[:3, 3] *= 1e3
        header = ",".join(f"m{i}{j}" for i in range(3) for j in range(4))
        again = palpate.read_poses(self.write("b.csv", header + "\n" + ",".join(repr(float(x)) for x in matrix[:3].ravel()) + "\n"))
        self.assertIsNone(again.time)
        np.testing.assert_allclose(np.asarray(again)[0], np.asarray(poses)[0], atol=1e-12)

    def test_some_of_the_poses(self):
        poses = palpate.read_poses(DATA / "plus_eight_landmark_pivots" / "stylus_to_reference.csv", segments="landmark")
        some = poses[10:20]
        np.testing.assert_array_equal(np.asarray(some), np.asarray(poses)[10:20])
        self.assertEqual(some.segments, poses.segments[10:20])
        mask = np.zeros(len(poses), dtype=bool)
        mask[[3, 5]] = True
        self.assertEqual(len(poses[mask]), 2)
        with self.assertRaises(ValueError):
            some.positions[0] = 0

    def test_samples_of_an_arm(self):
        samples = palpate.read_arm_samples(DATA / "ur5_laser_tracker" / "3D_UR5_uncalibrated_grid_cleaned.csv")
        self.assertEqual(samples.joints.shape[1], 6)
        self.assertEqual(samples.tips.shape, (len(samples), 3))
        self.assertIsNone(samples.markers)
        self.assertLess(np.abs(samples.joints).max(), 2 * np.pi)

    def test_a_rig_and_its_transforms(self):
        self.run_program("world", "sample", "arm", "--seed", "5", "--out", "arm")
        self.run_program("rig", "new", "rig.toml")
        self.run_program("calibrate", "arm", "--samples", "arm/arm.csv", "--arm", "phantom-premium-1.5", "--rig", "rig.toml")
        self.run_program("world", "sample", "hand-eye", "--seed", "5", "--out", "eye")
        hand, eye = self.folder / "eye" / "hand.csv", self.folder / "eye" / "eye.csv"
        self.run_program("calibrate", "hand-eye", "--hand", hand, "--eye", eye, "--estimate-delay", "--rig", "rig.toml")
        self.run_program("world", "sample", "surface", "--seed", "5", "--out", "desk")
        self.run_program("calibrate", "surface", "--points", "desk/surface.csv", "--rig", "rig.toml")
        rig = palpate.Rig.load(self.folder / "rig.toml")
        self.assertIn("arm", rig.parts)
        fixed = rig.transform("TipMarker", "Tip")
        np.testing.assert_allclose(rig.transform("Tip", "TipMarker") @ fixed, np.eye(4), atol=1e-12)
        (surface,) = rig.surfaces
        base, table = rig.transform("World", "ArmBase"), rig.transform("World", surface.name)
        np.testing.assert_array_equal(table, surface.pose)
        np.testing.assert_allclose(rig.transform("ArmBase", surface.name), np.linalg.inv(base) @ table, atol=1e-12)
        camera = palpate.calibrate_hand_eye(palpate.read_poses(hand), palpate.read_poses(eye), estimate_delay=True)
        np.testing.assert_allclose(rig.transform("CameraMarker", "CameraOptical"), camera.camera_in_marker, atol=1e-10)
        # The stylus that the readings give carries the marker to where the tracker saw it.
        samples = palpate.read_arm_samples(self.folder / "arm" / "arm.csv")
        result = palpate.calibrate_arm(samples, "phantom-premium-1.5")
        stylus = rig.stylus(samples.joints, samples.gimbal)
        np.testing.assert_allclose(stylus[:, :3, 3], result.tips(samples.joints), atol=1e-9)
        seen = np.asarray(samples.markers) @ fixed
        self.assertLess(np.median(np.linalg.norm(seen[:, :3, 3] - stylus[:, :3, 3], axis=1)), 2e-3)
        deviations = result.tip_stds(samples.joints)
        self.assertTrue(np.all((deviations > 0) & (deviations < 2e-3)))
        with self.assertRaisesRegex(KeyError, "World"):
            rig.transform("World", "Moon")
        with self.assertRaisesRegex(KeyError, "nothing fixed joins them"):
            rig.transform("World", "Tip")


if __name__ == "__main__":
    unittest.main()
