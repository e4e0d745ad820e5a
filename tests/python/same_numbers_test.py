#!/usr/bin/env python3
"""What the package finds is what the program finds, to the last bit: on recordings of others, and on a simulated desk."""
import json
import os
import pathlib
import subprocess
import tempfile
import unittest

import numpy as np

import palpate

PROGRAM = os.environ["PALPATE"]
DATA = pathlib.Path(__file__).parents[2] / "data"
UR5 = DATA / "ur5_laser_tracker"


class SameNumbers(unittest.TestCase):
    maxDiff = None

    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.folder.cleanup)
        cls.sample = {}

    def program(self, *arguments):
        done = subprocess.run([PROGRAM, "calibrate", *map(str, arguments), "--json", "-"], cwd=self.folder.name,
                              capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        told = json.loads(done.stdout)
        told.pop("data")
        return told

    def simulated(self, kind):
        """A simulated recording of that kind; its folder."""
        if kind not in self.sample:
            out = pathlib.Path(self.folder.name) / kind
            subprocess.run([PROGRAM, "world", "sample", kind, "--seed", "5", "--out", str(out)], cwd=self.folder.name,
                           capture_output=True, check=True)
            self.sample[kind] = out
        return self.sample[kind]

    def same(self, result, *arguments):
        expected = self.program(*arguments)
        given = result.to_dict()
        self.assertEqual(json.dumps(given), json.dumps(expected))  # keys in their order, numbers to the last bit
        return given

    def test_pivot_of_eight_landmarks(self):
        poses = DATA / "plus_eight_landmark_pivots" / "stylus_to_reference.csv"
        told = self.same(palpate.calibrate_pivot(palpate.read_poses(poses, segments="landmark")),
                         "pivot", "--poses", poses, "--segments", "landmark")
        self.assertEqual(len(told["segments"]), 8)

    def test_pivot_whose_rests_are_found_from_a_sequence(self):
        poses = DATA / "plus_eight_landmark_pivots" / "EightLandmarkPointsTrackedForPhantomRegistration.igs.mha"
        self.same(palpate.calibrate_pivot(palpate.read_poses(poses, transform="StylusToReference"), segments="auto", method="robust"),
                  "pivot", "--poses", poses, "--transform", "StylusToReference", "--segments", "auto", "--method", "robust")

    def test_camera_from_corners(self):
        corners = DATA / "opencv_chessboard_left" / "corners_left.csv"
        self.same(palpate.calibrate_camera(palpate.read_corners(corners, (9, 6), 0.025), (640, 480)),
                  "camera", "--corners", corners, "--board", "9x6", "--square-mm", "25", "--size-px", "640x480")

    def test_camera_from_photographs(self):
        images = DATA / "opencv_chessboard_left" / "left0*.jpg"
        self.same(palpate.calibrate_camera(palpate.find_corners(str(images), (9, 6), 0.025)),
                  "camera", "--images", images, "--board", "9x6", "--square-mm", "25")

    def test_hand_eye_with_its_delay(self):
        folder = DATA / "ethz_handeye_primesense1"
        hand, eye = (next(folder.glob(pattern)) for pattern in ("*vicon*", "*rgb*"))
        self.same(palpate.calibrate_hand_eye(palpate.read_poses(hand), palpate.read_poses(eye), estimate_delay=True),
                  "hand-eye", "--hand", hand, "--eye", eye, "--estimate-delay")

    def test_arm_of_a_laser_tracker_judged_by_other_samples(self):
        train, test = UR5 / "3D_UR5_uncalibrated_grid_cleaned.csv", UR5 / "3D_UR5_uncalibrated_random_cleaned.csv"
        result = palpate.calibrate_arm(palpate.read_arm_samples(train), UR5 / "ur5.toml", free=["gains", "offsets"],
                                       test=palpate.read_arm_samples(test))
        expected = self.program("arm", "--samples", train, "--arm", UR5 / "ur5.toml", "--free", "gains,offsets", "--test", test)
        given = result.to_dict()
        self.assertEqual((given.pop("test_from"), expected.pop("test_from")), ("test", str(test)))
        self.assertEqual(json.dumps(given), json.dumps(expected))

    def test_simulated_arm_with_its_gimbal(self):
        samples = self.simulated("arm") / "arm.csv"
        self.same(palpate.calibrate_arm(palpate.read_arm_samples(samples), "phantom-premium-1.5"),
                  "arm", "--samples", samples, "--arm", "phantom-premium-1.5")

    def test_points(self):
        folder = DATA / "plus_eight_landmark_pivots"
        named = palpate.read_points(folder / "landmarks_phantom.csv")
        moved = pathlib.Path(self.folder.name) / "moved.csv"
        rows = [f"{label},{-1e3 * y + 0.1 * i},{1e3 * x},{1e3 * z + 5}" for i, (label, (x, y, z)) in enumerate(zip(named.labels, named.points))]
        moved.write_text("label,x_mm,y_mm,z_mm\n" + "\n".join(rows) + "\n", encoding="ascii")
        other = palpate.read_points(moved)
        self.same(palpate.absolute_orientation(named.points, other.points, labels=named.labels),
                  "points", "--from", folder / "landmarks_phantom.csv", "--to", moved)

    def test_delay_between_poses(self):
        folder = DATA / "ethz_handeye_primesense1"
        hand, eye = (next(folder.glob(pattern)) for pattern in ("*vicon*", "*rgb*"))
        self.same(palpate.calibrate_delay(palpate.read_poses(hand), palpate.read_poses(eye)), "delay", "--from", hand, "--to", eye)

    def test_surfaces_and_landmarks_of_a_simulated_desk(self):
        folder = self.simulated("surface")
        points = folder / "surface.csv"
        rig = pathlib.Path(self.folder.name) / "rig.toml"
        subprocess.run([PROGRAM, "rig", "new", str(rig)], check=True, capture_output=True)
        touched, order = {}, []
        header, *rows = points.read_text(encoding="utf-8").split()
        names = header.split(",")
        for row in rows:
            cells = dict(zip(names, row.split(",")))
            name = cells.get("surface") or cells["label"].rpartition("_")[0]
            if name not in touched:
                touched[name] = ([], [])
                order.append(name)
            touched[name][0].append([1e-3 * float(cells[axis + "_mm"]) for axis in "xyz"])
            touched[name][1].append(int(cells.get("corner") or cells["label"].rpartition("_")[2]))
        results = palpate.calibrate_surfaces(touched)
        expected = self.program("surface", "--points", points, "--rig", rig)
        given = [result.to_dict() for result in results]
        self.assertEqual(json.dumps(given), json.dumps(expected.get("surfaces", [expected])))
        dots = self.simulated("landmarks") / "landmarks.csv"
        read = palpate.read_points(dots)
        result = palpate.calibrate_landmarks(read, palpate.Rig.load(rig).surfaces, labels=read.labels)
        self.same(result, "landmarks", "--points", dots, "--rig", rig)

    def test_fields_are_the_json_in_si(self):
        poses = palpate.read_poses(DATA / "plus_eight_landmark_pivots" / "stylus_to_reference.csv", segments="landmark")
        result = palpate.calibrate_pivot(poses)
        told = result.to_dict()
        np.testing.assert_allclose(1e3 * result.tip, told["tip_mm"], rtol=1e-15)
        np.testing.assert_allclose(1e3 * result.tip_std, told["tip_std_mm"], rtol=1e-12)
        np.testing.assert_allclose(1e6 * result.covariance, told["covariance"]["matrix"], rtol=1e-12)
        self.assertEqual(result.order[:3], ("tip_x", "tip_y", "tip_z"))
        self.assertEqual(result.segments, tuple(segment["label"] for segment in told["segments"]))
        self.assertAlmostEqual(1e3 * result.rms, told["rms_mm"], 12)


if __name__ == "__main__":
    unittest.main()
