#!/usr/bin/env python3
"""Files that other programs have written (data/foreign_files), against readers that share nothing with the program."""
import ast
import csv
import json
import math
import os
import re
import struct
import unittest

from program import ProgramTest

DATA = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "data")
FOREIGN = os.path.join(DATA, "foreign_files")


def text_of(name):
    with open(os.path.join(FOREIGN, name), encoding="latin-1", newline="") as file:
        return file.read().replace("\r\n", "\n")


def quaternion(m):
    """Of a matrix that is nearly a rotation: the eigenvector of its largest trace, by Shepperd's choice of the divisor."""
    squares = [1 + m[0][0] + m[1][1] + m[2][2], 1 + m[0][0] - m[1][1] - m[2][2], 1 - m[0][0] + m[1][1] - m[2][2], 1 - m[0][0] - m[1][1] + m[2][2]]
    k = squares.index(max(squares))
    rows = [[squares[0], m[2][1] - m[1][2], m[0][2] - m[2][0], m[1][0] - m[0][1]],
            [m[2][1] - m[1][2], squares[1], m[0][1] + m[1][0], m[0][2] + m[2][0]],
            [m[0][2] - m[2][0], m[0][1] + m[1][0], squares[2], m[1][2] + m[2][1]],
            [m[1][0] - m[0][1], m[0][2] + m[2][0], m[1][2] + m[2][1], squares[3]]]
    size = math.sqrt(sum(x * x for x in rows[k]))
    return [x / size for x in rows[k]]


def product(a, b):
    return [[sum(x * y for x, y in zip(row, column)) for column in zip(*b)] for row in a]


def inverse(m):
    """Of a rigid motion."""
    R = [[m[k][i] for k in range(3)] for i in range(3)]
    return [R[i] + [-sum(R[i][k] * m[k][3] for k in range(3))] for i in range(3)] + [[0, 0, 0, 1]]


def tum():
    for line in text_of("tum_rpg_vislam.txt").splitlines():
        t, x, y, z, qx, qy, qz, qw = map(float, line.split())
        yield t, 1000 * x, 1000 * y, 1000 * z, qw, qx, qy, qz


def wave(sensor):
    """Columns by their places: the time, then for each sensor its name, the state, Q0 Qx Qy Qz Tx Ty Tz."""
    rows = list(csv.reader(text_of("ndi_wave_15_sensors.tsv").splitlines(), delimiter="\t"))
    at = next(i for i, cell in enumerate(rows[0]) if cell.strip() == sensor)
    state = next(i for i in range(at, len(rows[0])) if rows[0][i].strip() == "State")
    for row in rows[1:]:
        values = [float(x) for x in row[state + 1:state + 8]]
        if row[state].strip() == "OK" and all(abs(v) < 1e20 for v in values):
            yield float(row[0]), *values[4:7], *values[:4]


def aurora(letter):
    lines = text_of("ndi_aurora_4_sensors.csv").splitlines()
    begin = next(i for i, line in enumerate(lines) if line.startswith("Sample:"))
    names = lines[begin].split(",")
    at = names.index(f"X{letter}")
    for line in lines[begin + 1:]:
        cells = line.split(",")
        values = [float(x) for x in cells[at:at + 7]]
        if any(values):
            yield float(cells[1]) * 3600 + float(cells[2]) * 60 + float(cells[3]) + float(cells[4]) / 1000, *values


def odometry():
    rows = csv.DictReader(text_of("ros_odometry_quoted.csv").splitlines(), skipinitialspace=True)
    for row in rows:
        cell = {key.strip(): value for key, value in row.items() if key}
        place, turn = ([float(cell[f".pose.pose.{what}.{axis}"]) for axis in axes] for what, axes in (("position", "xyz"), ("orientation", "wxyz")))
        secs = [key for key in cell if key.endswith("stamp.secs")]
        t = float(cell[secs[0]]) + 1e-9 * float(cell[secs[0].replace("secs", "nsecs")]) if secs else None
        yield t, *(1000 * x for x in place), *turn


def sequence(name, wanted):
    """`wanted`: names and whether they are turned round, the last one first applied."""
    frames = {}
    for number, key, value in re.findall(r"^Seq_Frame(\d+)_(\w+?) ?:?= ?(.*)$", text_of(name), re.M):
        frames.setdefault(int(number), {})[key] = value.strip()
    for _, frame in sorted(frames.items()):
        if any(frame.get(f"{one}TransformStatus", "OK") != "OK" for one, _ in wanted):
            continue
        whole = [[float(i == k) for k in range(4)] for i in range(4)]
        for one, turned in wanted:
            numbers = [float(x) for x in frame[f"{one}Transform"].split()]
            m = [numbers[4 * i:4 * i + 4] for i in range(4)]
            whole = product(whole, inverse(m) if turned else m)
        yield float(frame["Timestamp"]), *(whole[i][3] for i in range(3)), *quaternion(whole)


POSES = {
    "tum_rpg_vislam.txt": (None, tum),
    "ndi_wave_15_sensors.tsv": ("B5-03859-P02-CH1", lambda: wave("B5-03859-P02-CH1")),
    "ros_odometry_quoted.csv": (None, odometry),
    "plus_prostate_tracker.igs.mha": (None, lambda: sequence("plus_prostate_tracker.igs.mha", [("ToolToTracker", False)])),
    "plus_nwire_cropped.igs.mha": ("ProbeToReference", lambda: sequence("plus_nwire_cropped.igs.mha", [("ReferenceToTracker", True), ("ProbeToTracker", False)])),
    "plus_nwire_freehand.igs.nrrd": ("ProbeToReference", lambda: sequence("plus_nwire_freehand.igs.nrrd", [("ReferenceToTracker", True), ("ProbeToTracker", False)])),
}


class ForeignFiles(ProgramTest):
    def converted(self, name, out, *options):
        self.runs("convert", os.path.join(FOREIGN, name), out, *options)
        with open(self.path(out), encoding="utf-8") as file:
            return file.read()

    def same_poses(self, text, wanted, turn=1e-6, place=1e-6):
        rows, wanted = list(csv.reader(text.splitlines()))[1:], list(wanted)
        self.assertEqual(len(rows), len(wanted))
        self.assertGreaterEqual(len(rows), 10)
        for row, one in zip(rows, wanted):
            if one[0] is not None:
                self.assertAlmostEqual(float(row[0]), one[0], delta=1e-6)
            numbers = [float(x) for x in row[1:]]
            for a, b in zip(numbers, one[1:4]):
                self.assertAlmostEqual(a, b, delta=place + 1e-9 * abs(b))
            size = math.sqrt(sum(q * q for q in one[4:]))
            self.assertAlmostEqual(abs(sum(a * b for a, b in zip(numbers[3:], one[4:]))) / size, 1.0, delta=turn)

    def test_poses(self):
        for name, (tool, wanted) in POSES.items():
            with self.subTest(name):
                # Matrices of a real tracker are rotations to some 1e-4: what is nearest is a choice, and a chain has it twice.
                rough = name.startswith("plus_")
                self.same_poses(self.converted(name, "out.csv", *(["--tool", tool] if tool else [])), wanted(), 1e-6, 0.5 if rough else 1e-6)

    def test_one_of_several_sensors_is_named_first(self):
        for name, several in (("ndi_aurora_4_sensors.csv", "4 tools"), ("ndi_wave_15_sensors.tsv", "15 tools"), ("plus_nwire_cropped.igs.mha", "several transforms")):
            with self.subTest(name):
                self.refuses(["convert", os.path.join(FOREIGN, name), "none.csv"], 2, name, several)
        done = self.run_program("convert", os.path.join(FOREIGN, "ndi_aurora_4_sensors.csv"), "none.csv")
        names = re.search(r"side by side \(([^)]*)\)", done.err)[1].split(", ")
        seen = 0
        for letter, name in zip("abcd", names):
            wanted = list(aurora(letter))
            if len(wanted) < 10:
                continue
            seen += 1
            self.same_poses(self.converted("ndi_aurora_4_sensors.csv", "out.csv", "--tool", name), wanted)
        self.assertGreater(seen, 0)

    def test_lenses(self):
        for name in ("plus_surface_book_crlf.yml", "plus_realsense.yml"):
            with self.subTest(name):
                lens, text = json.loads(self.converted(name, "lens.json")), text_of(name)
                numbers = [[float(x) for x in re.findall(r"[-+.\deE]+", part) if re.search(r"\d", x)] for part in re.findall(r"data: \[(.*?)\]", text, re.S)]
                self.assertEqual([lens["fx"], lens["cx"], lens["fy"], lens["cy"]], [numbers[0][i] for i in (0, 2, 4, 5)])
                self.assertEqual(lens["distortion"], numbers[1])
        with open(os.path.join(FOREIGN, "npy_intrinsics_fortran.npy"), "rb") as file:
            raw = file.read()
        length = struct.unpack("<H", raw[8:10])[0]
        head = ast.literal_eval(raw[10:10 + length].decode().strip())
        numbers = struct.unpack("<9d", raw[10 + length:])
        self.assertTrue(head["fortran_order"])
        lens = json.loads(self.converted("npy_intrinsics_fortran.npy", "lens.json"))
        self.assertEqual([lens["fx"], lens["fy"], lens["cx"], lens["cy"]], [numbers[0], numbers[4], numbers[6], numbers[7]], "columns first")

    def test_a_fisheye_of_kalibr_is_one_of_two(self):
        path = os.path.join(FOREIGN, "kalibr_euroc_camchain.yaml")
        self.refuses(["convert", path, "lens.json"], 2, "cam0, cam1", "--tool")
        self.runs("convert", path, "lens.json", "--tool", "cam1")
        lens = json.loads(self.read("lens.json"))
        camera = open(path, encoding="ascii").read().partition("\ncam1:")[2]
        numbers = [float(word) for key in ("distortion_coeffs", "intrinsics")
                   for word in re.search(rf"{key}: \[([^\]]*)\]", camera).group(1).split(",")]
        self.assertEqual(lens["lens"], "fisheye")
        self.assertEqual([*lens["distortion"], lens["fx"], lens["fy"], lens["cx"], lens["cy"]], numbers)

    def test_calibrations_take_them(self):
        done = self.runs("calibrate", "delay", "--from", os.path.join(FOREIGN, "tum_rpg_vislam.txt"), "--to", self.half_a_second_late())
        # Poses 1.5 s apart: their own motion is all that tells.
        self.assertAlmostEqual(float(re.search(r"delay +([0-9.]+)", done.out)[1]), 0.5, delta=0.05)

    def half_a_second_late(self):
        rows = [line.split() for line in text_of("tum_rpg_vislam.txt").splitlines()]
        return self.write("late.txt", "".join(" ".join([repr(float(row[0]) + 0.5), *row[1:]]) + "\n" for row in rows))


if __name__ == "__main__":
    unittest.main()
