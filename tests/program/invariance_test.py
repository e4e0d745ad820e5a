#!/usr/bin/env python3
"""The unit in the file, the sign of a quaternion and the order of rows change no answer by more than 1e-6 mm."""
import json
import math
import os
import random
import unittest

from program import ProgramTest

REAL = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "data", "ethz_handeye_primesense1")
BAR_MM = 1e-6


def product(a, b):
    (aw, ax, ay, az), (bw, bx, by, bz) = a, b
    return (aw * bw - ax * bx - ay * by - az * bz, aw * bx + ax * bw + ay * bz - az * by,
            aw * by - ax * bz + ay * bw + az * bx, aw * bz + ax * by - ay * bx + az * bw)


def turned(q, v):
    w, x, y, z = product(product(q, (0, *v)), (q[0], -q[1], -q[2], -q[3]))
    return (x, y, z)


def rotation(x, y, z):
    angle = math.sqrt(x * x + y * y + z * z)
    s = math.sin(angle / 2) / angle if angle else 0.5
    return (math.cos(angle / 2), s * x, s * y, s * z)


def file_of(poses, unit="mm", signs=False, order=None, time=True):
    """Poses (time, place in mm, quaternion) as text; numbers to 17 digits, so that only the unit rounds."""
    rows = [("time_s," if time else "") + f"x_{unit},y_{unit},z_{unit},qw,qx,qy,qz"]
    scale = 1.0 if unit == "mm" else 1e-3
    for i in order or range(len(poses)):
        t, place, q = poses[i]
        sign = -1.0 if signs and i % 2 else 1.0
        rows.append(",".join(repr(v) for v in ([t] if time else []) + [scale * v for v in place] + [sign * v for v in q]))
    return "\n".join(rows) + "\n"


def swings(chance, pivots):
    poses = []
    for s in range(pivots):
        for i in range(60):
            q = rotation(*(chance.gauss(0, 0.4) for _ in range(3)))
            tip = turned(q, (4.0, -18.0, -118.0))
            place = [100.0 * s + chance.gauss(0, 0.2) - v for v in tip]
            poses.append((0.05 * len(poses), place, q))
    return poses


def hand_and_eye(chance, count):
    hand, eye = [], []
    X, x = rotation(0.1, -0.2, 3.0), (12.0, -65.0, 34.0)
    for i in range(count):
        t = 0.1 * i
        q = rotation(0.3 * math.sin(1.7 * t), 0.35 * math.sin(1.1 * t + 1), 0.25 * math.sin(2.3 * t + 2))
        p = [100 * math.sin(0.9 * t), 50 * math.sin(1.3 * t), 60 * math.cos(0.7 * t)]
        hand.append((t, p, q))
        noise = rotation(*(chance.gauss(0, 0.002) for _ in range(3)))
        eye.append((t, [a + b + chance.gauss(0, 0.5) for a, b in zip(p, turned(q, x))], product(noise, product(q, X))))
    return hand, eye


class Invariance(ProgramTest):
    def answer(self, *arguments):
        self.runs(*arguments, "--json", "result.json")
        return json.loads(self.read("result.json"))

    def alike(self, answers, *keys):
        for name, answer in answers.items():
            for key in keys:
                first = next(iter(answers.values()))[key]
                self.assertLess(max(abs(a - b) for a, b in zip(first, answer[key])), BAR_MM, f"{name}: {key}")

    def test_a_pivot(self):
        chance = random.Random(1)
        poses = swings(chance, 1)
        shuffled = list(range(len(poses)))
        chance.shuffle(shuffled)
        forms = {"mm": {}, "m": {"unit": "m"}, "signs": {"signs": True}, "order": {"order": shuffled}}
        for method in ("algebraic", "robust", "sphere"):
            answers = {}
            for name, how in forms.items():
                self.write("poses.csv", file_of(poses, **how))
                answers[name] = self.answer("calibrate", "pivot", "--poses", "poses.csv", "--method", method)
            # without noise in it the answer would be the same whatever the method did with the rows
            self.assertGreater(answers["mm"]["rms_mm"], 0.05)
            self.alike(answers, "tip_mm", "pivot_mm", "tip_std_mm")

    def test_points(self):
        chance = random.Random(2)
        q = rotation(0.3, 1.1, -0.4)
        a = [[chance.gauss(0, 100) for _ in range(3)] for _ in range(12)]
        b = [[v + chance.gauss(0, 1) + 50 for v in turned(q, p)] for p in a]
        order = list(range(12))
        chance.shuffle(order)

        def text(points, unit, order):
            scale = 1.0 if unit == "mm" else 1e-3
            return f"x_{unit},y_{unit},z_{unit}\n" + "".join(",".join(repr(scale * v) for v in points[i]) + "\n" for i in order)
        answers = {}
        for name, ua, ub, rows in (("mm", "mm", "mm", range(12)), ("m", "m", "m", range(12)), ("both", "mm", "m", range(12)), ("order", "mm", "mm", order)):
            self.write("a.csv", text(a, ua, rows))
            self.write("b.csv", text(b, ub, rows))
            answers[name] = self.answer("calibrate", "points", "--from", "a.csv", "--to", "b.csv")
            answers[name]["turn"] = [v for row in answers[name]["rotation"] for v in row]
            answers[name]["std_mm"] = answers[name]["std"]["translation_mm"]
        self.assertGreater(answers["mm"]["fre_rms_mm"], 0.3)
        self.alike(answers, "translation_mm", "turn", "std_mm")

    def test_hand_and_eye(self):
        chance = random.Random(3)
        for count in (20, 150):
            hand, eye = hand_and_eye(chance, count)
            shuffled = list(range(count))
            chance.shuffle(shuffled)
            for time in (True, False):
                answers = {}
                for name, how in {"mm": {}, "m": {"unit": "m"}, "signs": {"signs": True}, "order": {"order": shuffled}}.items():
                    self.write("hand.csv", file_of(hand, time=time, **how))
                    self.write("eye.csv", file_of(eye, time=time, **how))
                    answers[name] = self.answer("calibrate", "hand-eye", "--hand", "hand.csv", "--eye", "eye.csv")
                self.assertGreater(answers["mm"]["translation_residual_median_mm"], 0.2)
                self.alike(answers, "translation_mm", "rotation_qwxyz")

    def test_a_real_hand_and_eye_with_its_delay(self):
        hand = os.path.join(REAL, "2017-04-09-18-13-10_vicon_prime_sense.csv")
        with open(os.path.join(REAL, "2017-04-09-18-13-10_W_camera_rgb_image_raw.csv"), encoding="utf-8") as file:
            rows = file.read().splitlines()
        chance = random.Random(4)
        mixed = rows[:]
        chance.shuffle(mixed)
        flipped = [",".join(r.split(",")[:4] + [repr(-float(v)) for v in r.split(",")[4:]]) for r in rows]
        answers = {}
        for name, lines in {"as it is": rows, "order": mixed, "signs": flipped}.items():
            self.write("eye.csv", "\n".join(lines) + "\n")
            answers[name] = self.answer("calibrate", "hand-eye", "--hand", hand, "--eye", "eye.csv", "--estimate-delay")
        self.alike(answers, "translation_mm", "rotation_qwxyz")

    def test_a_surface(self):
        chance = random.Random(5)
        corners = [(0, 0, 0), (750, 0, 0), (750, 1000, 0), (0, 1000, 0)]
        touched = [(c + 1, [v + chance.gauss(0, 0.3) for v in corners[c]]) for c in range(4) for _ in range(3)]
        order = list(range(12))
        chance.shuffle(order)
        answers = {}
        for name, unit, rows in (("mm", "mm", range(12)), ("m", "m", range(12)), ("order", "mm", order)):
            scale = 1.0 if unit == "mm" else 1e-3
            self.write("points.csv", f"corner,x_{unit},y_{unit},z_{unit}\n" + "".join(
                f"{touched[i][0]}," + ",".join(repr(scale * v) for v in touched[i][1]) + "\n" for i in rows))
            answer = self.answer("calibrate", "surface", "--points", "points.csv")
            answers[name] = {"corners": [v for c in answer["corners_mm"] for v in c], "std": answer["std"]["translation_mm"]}
        self.alike(answers, "corners", "std")


if __name__ == "__main__":
    unittest.main()
