#!/usr/bin/env python3
"""Data that are well formed and cannot carry an answer: refused with the reason, exit 1, nothing written."""
import math
import unittest

from program import ProgramTest

POSES = "time_s,x_mm,y_mm,z_mm,qw,qx,qy,qz\n"
POINTS = "x_mm,y_mm,z_mm\n"
# Rotations about x, y and z by turns, as rough as hand-written numbers; the tip at (0, 0, -100) mm rests in the origin.
TURNS = ((0.966, 0.259, 0, 0), (0.966, 0, 0.259, 0), (0.966, 0, 0, 0.259), (0.966, -0.259, 0, 0), (0.966, 0, -0.259, 0))


def poses(turns):
    rows = []
    for i, (w, x, y, z) in enumerate(turns):
        size = w * w + x * x + y * y + z * z
        up = [2 * (x * z + w * y) / size, 2 * (y * z - w * x) / size, 1 - 2 * (x * x + y * y) / size]
        rows.append(",".join(map(str, [i / 10, *(100 * u for u in up), w, x, y, z])) + "\n")
    return POSES + "".join(rows)


class WeakData(ProgramTest):
    def refuses_pivot(self, content, *words):
        self.write("poses.csv", content)
        for method in ("algebraic", "sphere", "robust"):
            with self.subTest(method):
                self.refuses(["calibrate", "pivot", "--poses", "poses.csv", "--method", method, "--json", "result.json", "--pivots-out",
                              "pivots.csv", "--out", "part.toml"], 1, "poses.csv: ", "pivot", *words)

    def test_the_same_poses_are_enough_once_there_are_some(self):
        self.write("poses.csv", poses(TURNS))
        self.runs("calibrate", "pivot", "--poses", "poses.csv", "--json", "result.json")

    def test_a_pivot_from_too_few_poses(self):
        self.refuses_pivot(poses(TURNS[:2]), "2 poses", "at least 4 are needed")

    def test_a_pivot_without_rotation(self):
        self.refuses_pivot(POSES + "".join(f"{i},{i % 7},{i % 5},{i % 3},1,0,0,0\n" for i in range(50)), "turns by 0.0 deg", "at least 10 deg", "swing")

    def test_a_pivot_turned_about_one_axis_only(self):
        turns = [0.03 * i for i in range(30)]
        self.refuses_pivot(poses([(math.cos(t), math.sin(t), 0, 0) for t in turns]), "axis")

    def test_points_on_a_line(self):
        self.write("line.csv", POINTS + "".join(f"{i},{2 * i},{3 * i}\n" for i in range(6)))
        self.write("turned.csv", POINTS + "".join(f"{-2 * i},{i},{3 * i}\n" for i in range(6)))
        self.refuses(["calibrate", "points", "--from", "line.csv", "--to", "turned.csv", "--json", "result.json"], 1, "on a line", "beside")

    def test_two_points_and_lists_of_unlike_length(self):
        self.write("two.csv", POINTS + "0,0,0\n1,0,0\n")
        self.write("three.csv", POINTS + "0,0,0\n1,0,0\n0,1,0\n")
        self.refuses(["calibrate", "points", "--from", "two.csv", "--to", "two.csv"], 1, "2 points", "at least 3")
        self.refuses(["calibrate", "points", "--from", "two.csv", "--to", "three.csv"], 2, "two.csv", "three.csv", "same length")

    def test_a_surface_of_two_corners_or_of_corners_on_a_line(self):
        self.write("two.csv", POINTS + "0,0,0\n1000,0,0\n")
        self.refuses(["calibrate", "surface", "--points", "two.csv", "--out", "part.toml"], 1, "2 points", "four corners")
        self.write("line.csv", POINTS + "0,0,0\n500,0,0\n1000,0,0\n1500,0,0\n")
        self.refuses(["calibrate", "surface", "--points", "line.csv", "--out", "part.toml"], 1, "lie on a line")

    def test_hand_and_eye_that_do_not_meet_in_time_or_do_not_turn(self):
        self.write("early.csv", POSES + "".join(f"{i},{i},0,0,1,0,0,0\n" for i in range(30)))
        self.write("late.csv", POSES + "".join(f"{1000 + i},{i},0,0,1,0,0,0\n" for i in range(30)))
        self.write("between.csv", POSES + "".join(f"{0.5 + i},{i},0,0,1,0,0,0\n" for i in range(29)))
        command = ["calibrate", "hand-eye", "--json", "result.json", "--hand", "early.csv", "--eye"]
        self.refuses([*command, "late.csv"], 1, "hand-eye", "--estimate-delay")
        self.refuses([*command, "between.csv"], 1, "hand-eye")

    def test_an_arm_from_two_samples(self):
        self.write("arm.csv", "joint_1_deg,joint_2_deg,joint_3_deg,x_mm,y_mm,z_mm\n1,2,3,4,5,6\n2,3,4,5,6,7\n")
        self.refuses(["calibrate", "arm", "--samples", "arm.csv", "--arm", "phantom-premium-1.5", "--json", "result.json"], 1, "arm")

    def test_an_arm_that_did_not_make_these_samples(self):
        self.runs("world", "sample", "arm", "--points", "70", "--out", "sim")
        header, *rows = self.read("sim", "arm.csv").decode().splitlines()
        command = ["calibrate", "arm", "--samples", "odd.csv", "--arm", "phantom-premium-1.5", "--json", "result.json"]
        cells = [row.split(",") for row in rows]
        odd = {"joints": (header, [[c[1], c[0], *c[2:]] for c in cells]),
               "rows": (header, [[*a[:3], *b[3:]] for a, b in zip(cells, cells[17:] + cells[:17])]),
               "angles": (header.replace("_deg", "_rad"), cells),
               "places": (header.replace("_mm,", "_m,"), cells)}
        for name, (columns, table) in odd.items():
            with self.subTest(name):
                self.write("odd.csv", "\n".join([columns, *map(",".join, table)]) + "\n")
                self.refuses(command, 1, "odd.csv", "off the best fit", "check the units")
        self.write("odd.csv", "\n".join([header, *rows]) + "\n")
        self.runs(*command)

    def test_a_camera_from_one_view(self):
        rows = "".join(f"one,{i},{i % 9},{i // 9},{100 + 20 * (i % 9)},{100 + 20 * (i // 9)}\n" for i in range(54))
        self.write("corners.csv", "image,corner,board_x_squares,board_y_squares,u_px,v_px\n" + rows)
        self.refuses(["calibrate", "camera", "--corners", "corners.csv", "--json", "result.json", "--out", "part.toml"], 1, "corners.csv", "view")


if __name__ == "__main__":
    unittest.main()
