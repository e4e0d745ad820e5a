#!/usr/bin/env python3
"""Files of other programs: converted, and read by the calibrations as they are."""
import csv
import json
import math
import os
import random
import unittest

from program import ProgramTest

PIVOTS = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "data", "plus_eight_landmark_pivots", "stylus_to_reference.csv")
PLAN = [("A", (10.0, 20.0, 30.0)), ("B", (110.0, 20.0, 30.0)), ("C", (10.0, 90.0, 30.0)), ("D", (10.0, 20.0, 75.0))]


def turned(point):
    """By 90 degrees about z, and moved."""
    x, y, z = point
    return (-y + 5.0, x - 7.0, z + 11.0)


def rotated(q, v):
    w, u = q[0], q[1:]
    cross = lambda a, b: [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    twice = [2.0 * part for part in cross(u, v)]
    return [p + w * a + b for p, a, b in zip(v, twice, cross(u, twice))]


class Convert(ProgramTest):
    def rows_of(self, name):
        with open(self.path(name), encoding="utf-8") as file:
            return list(csv.DictReader(file))

    def test_a_trajectory_of_tum_becomes_a_table(self):
        self.write("take.txt", "# timestamp tx ty tz qx qy qz qw\n1403636580.063556 0.1 -0.2 0.3 0.5 -0.5 0.5 0.5\n1 nan nan nan nan nan nan nan\n")
        done = self.runs("convert", "take.txt", "take.csv")
        self.assertEqual(done.out, "")
        self.assertIn("take.txt: a TUM trajectory (tx ty tz qx qy qz qw, s and m)", done.err)
        self.assertIn("1 pose, 1 row left out in which the body was hidden", done.err)
        with open(self.path("take.csv"), encoding="utf-8") as file:
            self.assertEqual(file.read(), "time_s,x_mm,y_mm,z_mm,qw,qx,qy,qz\n1403636580.063556,100,-200,300,0.5,0.5,-0.5,0.5\n")

    def test_poses_without_times_have_none(self):
        self.write("kitti.txt", "1 0 0 10 0 1 0 20 0 0 1 30\n")
        done = self.runs("convert", "kitti.txt", "out.csv")
        self.assertIn("without times", done.err)
        self.assertEqual(self.rows_of("out.csv")[0]["time_s"], "")
        self.assertEqual(float(self.rows_of("out.csv")[0]["z_mm"]), 30000.0)

    def test_a_lens_a_transform_and_points(self):
        self.write("lens.yml", "%YAML:1.0\n---\nimage_width: 640\nimage_height: 480\ncamera_matrix: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n"
                               "   data: [ 500., 0., 320., 0., 510., 240., 0., 0., 1. ]\n")
        self.runs("convert", "lens.yml", "lens.json")
        lens = json.loads(self.read("lens.json"))
        self.assertEqual((lens["fx"], lens["cy"], lens["width_px"], lens["distortion"]), (500.0, 240.0, 640, [0.0] * 5))
        self.write("t.tfm", "#Insight Transform File V1.0\nTransform: AffineTransform_double_3_3\nParameters: 0 -1 0 1 0 0 0 0 1 1 2 3\nFixedParameters: 0 0 0\n")
        self.runs("convert", "t.tfm", "t.txt")
        self.assertEqual([[float(x) for x in line.split()] for line in self.read("t.txt").decode().splitlines()],
                         [[0, -1, 0, 1], [1, 0, 0, 2], [0, 0, 1, 3], [0, 0, 0, 1]])
        self.write("p.fcsv", "# Markups fiducial file version = 4.11\n# CoordinateSystem = RAS\n1,10,20,30,0,0,0,1,1,1,0,F-1,,\n")
        self.runs("convert", "p.fcsv", "p.csv")
        self.assertEqual(self.read("p.csv"), b"x_mm,y_mm,z_mm,label\n-10,-20,30,F-1\n")

    def test_the_board_in_the_camera_becomes_the_camera_in_the_board(self):
        half = math.sqrt(0.5)
        self.write("eye.csv", f"time_s,x_mm,y_mm,z_mm,qw,qx,qy,qz\n1.5,10,20,300,{half},0,0,{half}\n")
        self.assertIn("turned round", self.runs("convert", "eye.csv", "board.csv", "--invert").err)
        row = {key: float(value) for key, value in self.rows_of("board.csv")[0].items()}
        for key, value in {"time_s": 1.5, "x_mm": -20, "y_mm": 10, "z_mm": -300, "qw": half, "qx": 0, "qz": -half}.items():
            self.assertAlmostEqual(row[key], value, 9)
        self.write("t.txt", "0 -1 0 1\n1 0 0 2\n0 0 2 3\n0 0 0 1\n")
        self.runs("convert", "t.txt", "back.txt", "--invert")
        self.assertEqual([[float(x) for x in line.split()] for line in self.read("back.txt").decode().splitlines()],
                         [[0, 1, 0, -2], [-1, 0, 0, 1], [0, 0, 0.5, -1.5], [0, 0, 0, 1]])
        self.write("p.csv", "x_mm,y_mm,z_mm\n1,2,3\n")
        self.refuses(["convert", "p.csv", "out.csv", "--invert"], 2, "p.csv: is ", "--invert needs poses or a transform")

    def test_what_cannot_be_is_refused_and_nothing_written(self):
        self.write("two.tsv", "Time\tleft\tState\tQ0\tQx\tQy\tQz\tTx\tTy\tTz\tright\tState\tQ0\tQx\tQy\tQz\tTx\tTy\tTz\n"
                              "1\tl\tOK\t1\t0\t0\t0\t1\t2\t3\tr\tOK\t1\t0\t0\t0\t4\t5\t6\n")
        self.refuses(["convert", "two.tsv", "out.csv"], 2, "two.tsv: is an export of NDI's programs of 2 tools side by side (left, right)", "--tool")
        self.write("p.csv", "x,y,z\n1,2,3\n")
        self.write("t.tum", "0 1 2 3 0 0 0 1\n0.1 1 2 3 0 0 0 1\n0.2 1 2 4 0 0 0 1\n")
        self.refuses(["convert", "t.tum", "out.csv", "--unit", "mm"], 2, "which has a unit of its own", "leave --unit out")
        # Rows of matrices need it even where nothing moves.
        self.write("turns.csv", "0,-1,0,0,1,0,0,0,0,0,1,0,0,0,0,1\n" * 3)
        self.refuses(["convert", "turns.csv", "out.csv"], 2, "their unit is needed: palpate convert --unit mm")
        self.runs("convert", "turns.csv", "turned.csv", "--unit", "mm")
        self.refuses(["convert", "t.tum", "out.odd"], 2, "its ending says no form; expected .csv, ", "--to with one of ")
        self.refuses(["convert", "p.csv", "out.csv"], 2, "p.csv: is a table of points without a unit; a unit is needed: palpate convert --unit mm, or m; or columns x_mm, y_mm, z_mm")
        self.refuses(["convert", "two.tsv", "out.json", "--tool", "left"], 2, "poses cannot be written as json, which holds a lens")
        self.refuses(["convert", "two.tsv", "out.dat"], 2, "out.dat: its ending says no form", ".csv")
        self.refuses(["convert", "t.tum", "./t.tum"], 2, "t.tum: is the file that is read", "another name is expected")
        self.refuses(["convert", "nowhere.txt", "out.csv"], 2, "nowhere.txt: no such file")
        self.assertEqual([name for name in os.listdir(self.folder) if name.startswith("out")], [])
        self.runs("convert", "two.tsv", "out.csv", "--tool", "right")
        self.assertEqual(float(self.rows_of("out.csv")[0]["x_mm"]), 4.0)

    def test_a_pivot_of_a_trajectory_is_that_of_the_table(self):
        draw = random.Random(3)
        rows = []
        for _ in range(60):
            q = [1.0] + [draw.uniform(-0.3, 0.3) for _ in range(3)]
            length = math.sqrt(sum(part * part for part in q))
            q = [part / length for part in q]
            turned_tip = rotated(q, (12.0, -20.0, 150.0))
            rows.append([pivot - part + draw.gauss(0.0, 0.1) for pivot, part in zip((100.0, 50.0, -30.0), turned_tip)] + q)
        table = "x_mm,y_mm,z_mm,qw,qx,qy,qz\n" + "".join(",".join(map(repr, row)) + "\n" for row in rows)
        self.write("table.csv", table)
        self.write("take.tum", "".join(" ".join(map(repr, [0.1 * i] + [1e-3 * mm for mm in row[:3]] + row[4:] + row[3:4])) + "\n"
                                       for i, row in enumerate(rows)))
        self.write("take.tsv", table.replace(",", "\t"))
        found = {}
        for name in ("table.csv", "take.tum", "take.tsv"):
            done = self.runs("calibrate", "pivot", "--poses", name, "--json", "-")
            found[name] = json.loads(done.out)
            self.assertEqual("TUM" in done.err, name == "take.tum")
        self.assertLess(math.dist(found["table.csv"]["tip_mm"], (12.0, -20.0, 150.0)), 0.3)
        for name in ("take.tum", "take.tsv"):
            self.assertLess(math.dist(found[name]["tip_mm"], found["table.csv"]["tip_mm"]), 1e-9)
            self.assertEqual(found[name]["poses"], 60)
        self.assertEqual(found["table.csv"]["warnings"], [])
        # The tracker stands a metre and a half away: turned round, that is where the tip would be.
        self.write("far.csv", "x_mm,y_mm,z_mm,qw,qx,qy,qz\n" + "".join(",".join(map(repr, [row[0] + 1400.0, *row[1:]])) + "\n" for row in rows))
        self.runs("convert", "far.csv", "turned.csv", "--invert")
        self.assertIn("Turn them round", " ".join(json.loads(self.runs("calibrate", "pivot", "--poses", "turned.csv", "--json", "-").out)["warnings"]))

    def test_a_pivot_of_matrices_is_that_of_the_table(self):
        with open(PIVOTS, encoding="utf-8") as file:
            rows = [row for row in csv.DictReader(file) if row["landmark"] == "1"]
        names = [f"m{r}{c}" for r in range(3) for c in range(4)]
        self.write("table.csv", ",".join(names) + "\n" + "".join(",".join(row[name] for name in names) + "\n" for row in rows))
        self.write("blocks.txt", "".join("".join(" ".join(row[f"m{r}{c}"] for c in range(4)) + "\n" for r in range(3)) + "0 0 0 1\n" for row in rows))
        tips = [json.loads(self.runs("calibrate", "pivot", "--poses", name, "--json", "-").out)["tip_mm"] for name in ("table.csv", "blocks.txt")]
        self.assertEqual(tips[0], tips[1])
        self.runs("convert", "blocks.txt", "again.csv")
        self.assertLess(math.dist(json.loads(self.runs("calibrate", "pivot", "--poses", "again.csv", "--json", "-").out)["tip_mm"], tips[0]), 1e-9)

    def test_a_plan_of_slicer_is_brought_to_the_desk(self):
        markups = {"markups": [{"type": "Fiducial", "coordinateSystem": "RAS",
                                "controlPoints": [{"label": label, "position": [-p[0], -p[1], p[2]]} for label, p in PLAN]}]}
        self.write("plan.mrk.json", json.dumps(markups))
        self.write("touched.csv", "label,x_mm,y_mm,z_mm\n" + "".join("{},{},{},{}\n".format(label, *turned(p)) for label, p in reversed(PLAN)))
        done = self.runs("calibrate", "points", "--from", "plan.mrk.json", "--to", "touched.csv", "--json", "-")
        self.assertIn("plan.mrk.json: markups of 3D Slicer (.mrk.json): RAS, turned into LPS, mm", done.err)
        found = json.loads(done.out)
        for got, wanted in zip(found["translation_mm"], (5.0, -7.0, 11.0)):
            self.assertAlmostEqual(got, wanted, 9)
        for row, wanted in zip(found["rotation"], ([0, -1, 0], [1, 0, 0], [0, 0, 1])):
            for got, one in zip(row, wanted):
                self.assertAlmostEqual(got, one, 12)

    def test_hidden_rows_of_a_table_are_left_out_and_told(self):
        self.write("table.csv", "time_s,x_mm,y_mm,z_mm,qw,qx,qy,qz\n0,1,2,3,1,0,0,0\n0.1,,,,,,,\n0.2,nan,nan,nan,nan,nan,nan,nan\n0.3,1,2,nan,1,0,0,0\n")
        done = self.run_program("calibrate", "pivot", "--poses", "table.csv")
        self.assertEqual(done.code, 2)
        self.assertIn("table.csv:5: z_mm is 'nan'", done.err)
        self.write("table.csv", "time_s,x_mm,y_mm,z_mm,qw,qx,qy,qz\n0,1,2,3,1,0,0,0\n0.1,,,,,,,\n0.2,nan,nan,nan,nan,nan,nan,nan\n")
        self.assertIn("table.csv: 2 rows left out in which the body was hidden, 1 taken", self.run_program("calibrate", "pivot", "--poses", "table.csv").err)


if __name__ == "__main__":
    unittest.main()
