#!/usr/bin/env python3
"""Rig files that can be read and cannot be right, real bodies that are registered into one, and a desk's rig without its arm."""
import json
import math
import os
import re
import unittest

from program import ProgramTest

CUBE = "solid cube\n" + "".join(
    f"facet normal 0 0 0\nouter loop\n{''.join('vertex %d %d %d' % v + chr(10) for v in (a, b, c))}endloop\nendfacet\n"
    for a, b, c in (((0, 0, 0), (0, 80, 0), (80, 0, 0)), ((0, 0, 0), (80, 0, 0), (0, 0, 80)), ((0, 0, 0), (0, 0, 80), (0, 80, 0)),
                    ((80, 0, 0), (0, 80, 0), (0, 0, 80)))) + "endsolid cube\n"
OBJECT = '\n[[object]]\nname = "head"\nmesh = "head.stl"\nmesh_unit = "mm"\ntranslation_mm = [1, 2, 3]\nrotation_qwxyz = [1, 0, 0, 0]\n'


class RigValues(ProgramTest):
    def camera_rig(self):
        """A rig whose lens was calibrated."""
        self.runs("rig", "new", "rig.toml")
        self.runs("world", "sample", "camera", "--out", "camera")
        self.runs("calibrate", "camera", "--corners", "camera/corners.csv", "--rig", "rig.toml")
        return self.read("rig.toml").decode()

    def test_a_lens_that_cannot_be_is_named(self):
        text = self.camera_rig()
        self.assertNotIn("doubtful", self.run_program("rig", "check", "rig.toml").out)
        for key, value, words in (("width_px", "64", "outside its picture of 64 x"), ("fx_px", "56", "it would see"),
                                  ("distortion", "[-0.9, 0, 0, 0, 0]", "turns back on itself")):
            with self.subTest(key):
                self.write("rig.toml", re.sub(rf"(?m)^{key} = .*$", f"{key} = {value}", text))
                checked = self.run_program("rig", "check", "rig.toml")
                self.assertEqual(checked.code, 1)
                self.assertRegex(checked.out, rf"doubtful +camera: .*{re.escape(words)}")
                self.assertIn("cannot be right in camera", checked.err)
                self.assertIn("doubtful", self.runs("rig", "show", "rig.toml").out)

    def test_a_body_whose_shape_cannot_be_read_is_named(self):
        self.runs("rig", "new", "rig.toml")
        text = self.read("rig.toml").decode()
        self.write("rig.toml", text + OBJECT)
        checked = self.run_program("rig", "check", "rig.toml")
        self.assertEqual(checked.code, 1)
        self.assertRegex(checked.out, r"doubtful +object 'head': .*head\.stl: no such file")
        self.write("head.stl", "solid of nothing\n")
        self.assertIn("object 'head'", self.run_program("rig", "check", "rig.toml").err)
        self.write("head.stl", CUBE)
        self.assertNotIn("doubtful", self.run_program("rig", "check", "rig.toml").out)

    def points(self):
        """Five points of a body, and where a turn by 30 deg about z and a shift bring them."""
        c, s = math.cos(math.radians(30)), math.sin(math.radians(30))
        mesh = [(0, 0, 0), (80, 0, 0), (0, 80, 0), (0, 0, 80), (30, 20, 10)]
        head = "x_mm,y_mm,z_mm\n"
        self.write("mesh.csv", head + "".join(f"{x},{y},{z}\n" for x, y, z in mesh))
        self.write("touched.csv", head + "".join(f"{c * x - s * y + 120},{s * x + c * y - 1520},{z + 1400}\n" for x, y, z in mesh))
        return ["calibrate", "points", "--from", "mesh.csv", "--to", "touched.csv"]

    def poses(self, name):
        """Numbers of the rig's one body, as its file has them."""
        text = self.read(name).decode().split("[[object]]")[1]
        return [[float(x) for x in re.search(rf"{key} = \[(.*)\]", text).group(1).split(",")] for key in ("translation_mm", "rotation_qwxyz")]

    def is_where_it_was_touched(self, name):
        place, turn = self.poses(name)
        for found, truth in zip(place + turn, [120, -1520, 1400, math.cos(math.radians(15)), 0, 0, math.sin(math.radians(15))]):
            self.assertAlmostEqual(found, truth, delta=1e-6)

    def test_a_body_is_registered_by_touched_points(self):
        self.runs("rig", "new", "rig.toml")
        self.write("head.stl", CUBE)
        command = self.points()
        self.refuses([*command, "--rig", "rig.toml"], 2, "--object")
        self.refuses([*command, "--object", "head"], 2, "--rig")
        self.refuses([*command, "--rig", "rig.toml", "--object", "head"], 2, "rig.toml", "no [[object]]", "--mesh")
        self.refuses([*command, "--mesh", "head.stl"], 2, "--object")
        self.refuses([*command, "--rig", "rig.toml", "--object", "head", "--mesh", "hand.stl"], 2, "hand.stl", "no such file")
        self.runs(*command, "--rig", "rig.toml", "--object", "head", "--mesh", "head.stl")
        self.is_where_it_was_touched("rig.toml")
        self.assertNotIn("doubtful", self.run_program("rig", "check", "rig.toml").out)
        self.runs(*command, "--out", "part.toml", "--object", "head", "--mesh", "head.stl", "--mesh-unit", "m")
        self.assertIn('mesh_unit = "m"', self.read("part.toml").decode())

    def test_a_body_that_stands_in_the_rig_is_moved_and_keeps_its_shape(self):
        self.runs("rig", "new", "rig.toml")
        self.write("rig.toml", self.read("rig.toml").decode() + OBJECT)
        self.runs(*self.points(), "--rig", "rig.toml", "--object", "head")
        self.is_where_it_was_touched("rig.toml")
        self.assertEqual(self.read("rig.toml").decode().count("[[object]]"), 1)
        self.assertIn('mesh = "head.stl"', self.read("rig.toml").decode())
        self.runs(*self.points(), "--rig", "rig.toml", "--out", "part.toml", "--object", "head")
        self.assertIn('mesh = "head.stl"', self.read("part.toml").decode())

    def test_a_delay_that_was_not_measured_is_told(self):
        self.runs("rig", "new", "rig.toml")
        self.runs("world", "sample", "arm", "--out", "arm")  # still poses
        self.runs("calibrate", "arm", "--samples", "arm/arm.csv", "--rig", "rig.toml")
        self.assertRegex(self.run_program("rig", "check", "rig.toml").out, r"tracker's delay +not measured: .*palpate calibrate")
        self.write("rig.toml", self.read("rig.toml").decode() + "\n[delays]\ntracker_after_arm_s = 0.01\n"
                   "camera_after_tracker_s = 0.03\ntracker_std_s = 3e-5\ncamera_std_s = 6e-5\nrms_mm = 0.0\n")
        self.assertNotIn("tracker's delay", self.run_program("rig", "check", "rig.toml").out)

    def test_a_delay_between_clocks_of_different_origins_is_named_and_not_played_with(self):
        self.runs("rig", "new", "rig.toml")
        text = self.read("rig.toml").decode() + "\n[delays]\ntracker_after_arm_s = 0\ncamera_after_tracker_s = 300.25\n" + "tracker_std_s = 3e-5\ncamera_std_s = 6e-5\nrms_mm = 0.0\n"
        self.write("rig.toml", text)
        checked = self.run_program("rig", "check", "rig.toml")
        self.assertEqual(checked.code, 1)
        self.assertRegex(checked.out, r"doubtful +delays: camera_after_tracker_s is 300\.25 s, at most 3 s")
        self.refuses(["graphics", "--rig", "rig.toml"], 1, "rig.toml: delays: camera_after_tracker_s is 300.25 s")
        self.write("rig.toml", text.replace("300.25", "0.3"))
        self.assertNotIn("doubtful", self.run_program("rig", "check", "rig.toml").out)
        self.refuses(["graphics", "--rig", "rig.toml"], 1, "arm, camera or hand-eye calibration is missing")

    def test_a_new_rigs_lengths_are_those_of_the_maker(self):
        self.runs("rig", "new", "rig.toml")
        self.assertIn("lengths_mm = [209.55, 209.55]", self.read("rig.toml").decode())
        self.runs("board", "--out", "board.pdf")
        self.runs("rig", "webcam", "desk.toml", "--board", "board.toml")
        desk = self.read("desk.toml").decode()
        self.assertEqual(desk.count("lengths_mm = [209.55, 209.55]"), 2)
        self.assertIn("translation_mm = [100.0, -1400.0, 1750.0]", desk)

    def test_a_result_takes_the_place_of_no_rig_and_of_no_table(self):
        self.runs("world", "sample", "pivot", "--out", "sim")
        self.runs("world", "sample", "surface", "--out", "sim")
        pivot = ["calibrate", "pivot", "--poses", "sim/pivot.csv"]
        self.runs("rig", "new", "rig.toml")
        self.runs("calibrate", "surface", "--points", "sim/surface.csv", "--rig", "rig.toml")
        self.refuses([*pivot, "--out", "rig.toml"], 2, "--out rig.toml: is a rig file with more than this result", "--rig rig.toml adds")
        self.refuses([*pivot, "--json", "rig.toml"], 2, "--json rig.toml: is a rig file", "--rig rig.toml adds")
        self.refuses([*pivot, "--pivots-out", "sim/pivot.csv"], 2, "is read or written already")
        self.refuses([*pivot, "--pivots-out", "new.csv", "--json", "new.csv"], 2, "is read or written already")
        # What holds this part alone is replaced, and each file is told.
        for _ in range(2):
            told = self.runs(*pivot, "--out", "tip.toml", "--pivots-out", "pivots.csv").out
        for name in ("tip.toml", "pivots.csv"):
            self.assertRegex(told, rf"written to +{name}")
        self.assertTrue(self.read("pivots.csv").startswith(b"label,x_mm,y_mm,z_mm"))

    def test_dots_off_every_surface_are_refused(self):
        self.runs("world", "sample", "landmarks", "--out", "sim")
        self.runs("world", "sample", "surface", "--out", "sim")
        self.runs("rig", "new", "rig.toml")
        self.runs("calibrate", "surface", "--points", "sim/wall.csv", "--name", "wall", "--rig", "rig.toml")
        rows = self.read("sim/landmarks.csv").decode().splitlines()
        self.write("dots.csv", "\n".join([rows[0], *rows[1:7]]) + "\n")  # those on the table
        self.refuses(["calibrate", "landmarks", "--points", "dots.csv", "--rig", "rig.toml"], 1, "6 of 6 landmarks lie more than 10 mm off every surface",
                     "calibrate surface")

    def test_dots_touched_once_have_no_residual(self):
        for kind in ("surface", "landmarks"):
            self.runs("world", "sample", kind, "--out", "sim")
        self.runs("rig", "new", "rig.toml")
        for name, file in (("table", "surface.csv"), ("wall", "wall.csv")):
            done = self.runs("calibrate", "surface", "--points", os.path.join("sim", file), "--name", name, "--rig", "rig.toml")
            self.assertNotIn("warning", done.out)
        self.runs("calibrate", "landmarks", "--points", "sim/landmarks.csv", "--rig", "rig.toml")
        landmarks = next(line for line in self.runs("rig", "show", "rig.toml").out.splitlines() if line.startswith("landmarks"))
        self.assertIn("no residual", landmarks)
        # What lens, hand-eye and these dots have in common does not fit other dots.
        rig = self.read("rig.toml").decode()
        size = 9 + 6 + 3 * rig.count("[[landmark]]")
        unit = [[float(i == j) for j in range(size)] for i in range(size)]
        self.write("rig.toml", f"{rig}\n[registration]\ncovariance_si = {unit}\n")
        self.runs("rig", "show", "rig.toml")
        self.write("fewer.csv", "\n".join(self.read("sim", "landmarks.csv").decode().splitlines()[:9]))
        self.assertIn("these 8 take their place", self.runs("calibrate", "landmarks", "--points", "fewer.csv", "--rig", "rig.toml").out)
        self.assertNotIn(b"[registration]", self.read("rig.toml"))

    def test_a_desks_rig_without_its_arm_names_what_starts_it(self):
        self.runs("board", "--out", "board.pdf")
        self.runs("rig", "webcam", "desk.rig.toml", "--board", "board.toml")
        self.says_no(self.run_program("physics", "--rig", "desk.rig.toml"), 1, "palpate play --rig desk.rig.toml",
                     "palpate world run --arm-only")

    def test_the_distance_of_the_board_tells_another_unit(self):
        self.runs("world", "sample", "camera", "--out", "camera")
        command = ["calibrate", "camera", "--corners", "camera/corners.csv", "--json", "-"]
        near, far = json.loads(self.runs(*command).out)["board_distance_mm"]
        self.assertGreater(near, 200)
        self.assertLess(far, 2000)
        small = json.loads(self.runs(*command, "--square-mm", "2.5").out)["board_distance_mm"]
        self.assertAlmostEqual(small[0], near / 10, delta=1e-3 * near)


if __name__ == "__main__":
    unittest.main()
