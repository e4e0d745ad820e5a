#!/usr/bin/env python3
"""Hand-eye from the board's corners: views joined to hand poses by stamps, by name and by order, and what is wrong named."""
import json
import math
import random
import unittest

from program import ProgramTest

FX, FY, CX, CY, WIDTH, HEIGHT = 560.0, 558.0, 319.5, 239.5, 640, 480
COLUMNS, ROWS, SQUARE_MM = 9, 6, 25.0
LATE_S = 0.03  # of the hand's clock


def times(a, b):
    """Product of quaternions w x y z."""
    return (a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3], a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
            a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1], a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0])


def conjugate(q):
    return (q[0], -q[1], -q[2], -q[3])


def turned(q, v):
    return times(times(q, (0.0, *v)), conjugate(q))[1:]


def rotation(x, y, z):
    angle = math.sqrt(x * x + y * y + z * z)
    k = math.sin(angle / 2) / angle
    return (math.cos(angle / 2), k * x, k * y, k * z)


def product(a, b):
    return (times(a[0], b[0]), tuple(s + t for s, t in zip(turned(a[0], b[1]), a[1])))


def inverse(a):
    q = conjugate(a[0])
    return (q, tuple(-s for s in turned(q, a[1])))


MOUNT = (rotation(0.3, -1.1, 0.4), (50.0, -30.0, 80.0))  # camera in marker, mm
BOARD = (rotation(-1.2, 0.4, 0.2), (200.0, -600.0, -1400.0))  # in World


def camera_board(t):
    q = rotation(0.5 * math.sin(1.1 * t), 0.5 * math.cos(0.9 * t), 0.4 * math.sin(0.7 * t) + 0.01)
    place = (40 * math.sin(1.3 * t), 30 * math.cos(1.7 * t), 500 + 50 * math.sin(0.5 * t))
    middle = turned(q, (100.0, 62.5, 0.0))
    return (q, tuple(p - m for p, m in zip(place, middle)))


def hand(t):
    return product(product(BOARD, inverse(camera_board(t))), inverse(MOUNT))


def pose_row(pose):
    return ",".join(f"{number:.9g}" for number in (*pose[1], *pose[0]))


class PixelHandEye(ProgramTest):
    def setUp(self):
        super().setUp()
        noise = random.Random(1)
        moments = [0.4 * i for i in range(40)]
        corners, named, stamps = [], [], []
        for i, t in enumerate(moments):
            q, place = camera_board(t)
            for k in range(COLUMNS * ROWS):
                x, y = k % COLUMNS, k // COLUMNS
                p = [s + o for s, o in zip(turned(q, (SQUARE_MM * x, SQUARE_MM * y, 0.0)), place)]
                u, v = FX * p[0] / p[2] + CX + noise.gauss(0, 0.1), FY * p[1] / p[2] + CY + noise.gauss(0, 0.1)
                corners.append(f"view{i:02}.png,{k},{x},{y},{u:.4f},{v:.4f},{WIDTH},{HEIGHT}")
            named.append(f"view{i:02}.png,{t},{pose_row(hand(t))}")
            stamps.append(f"view{i:02}.png,{t}")
        stream = [f"{0.01 * i + LATE_S},{pose_row(hand(0.01 * i))}" for i in range(-100, 1700)]
        header = "x_mm,y_mm,z_mm,qw,qx,qy,qz"
        self.write("corners.csv", "\n".join(["image,corner,board_x_squares,board_y_squares,u_px,v_px,width_px,height_px", *corners]) + "\n")
        self.write("named.csv", "\n".join([f"image,time_s,{header}", *reversed(named)]) + "\n")
        self.write("order.csv", "\n".join([header, *(row.split(",", 2)[2] for row in named)]) + "\n")
        self.write("stamps.csv", "\n".join(["image,time_s", *stamps]) + "\n")
        self.write("stream.csv", "\n".join([f"time_s,{header}", *stream]) + "\n")
        self.write("lens.json", json.dumps({"fx": FX, "fy": FY, "cx": CX, "cy": CY, "distortion": [0] * 5, "width_px": WIDTH, "height_px": HEIGHT}))

    def answer(self, *options):
        self.runs("calibrate", "hand-eye", "--corners", "corners.csv", "--board", "9x6", "--json", "result.json", *options)
        return json.loads(self.read("result.json"))

    def expect_mount(self, found):
        for value, truth, sd in zip(found["translation_mm"], MOUNT[1], found["std"]["translation_mm"]):
            self.assertLess(abs(value - truth), max(0.05, 5 * sd))
            self.assertLess(sd, 2.0)
        for value, truth in zip(found["rotation_qwxyz"], MOUNT[0]):
            self.assertAlmostEqual(value, truth, delta=2e-3)
        self.assertEqual(found["views"], 40)
        self.assertLess(found["rms_px"], 0.3)

    def test_views_belong_to_poses_by_name_by_order_and_by_stamps(self):
        lens = ("--lens", "lens.json")
        for options in (("--hand", "named.csv"), ("--hand", "order.csv"),
                        ("--hand", "stream.csv", "--stamps", "stamps.csv", "--delay-s", str(LATE_S))):
            with self.subTest(options):
                found = self.answer(*options, *lens)
                self.expect_mount(found)
                self.assertEqual(found["warnings"], [])
        found = self.answer("--hand", "stream.csv", "--stamps", "stamps.csv", "--estimate-delay", *lens)
        self.expect_mount(found)
        self.assertAlmostEqual(found["delay_s"], LATE_S, delta=5 * found["delay_std_s"])
        self.assertLess(found["delay_std_s"], 1e-3)

    def test_a_lens_that_is_not_given_is_found_too(self):
        found = self.answer("--hand", "named.csv")
        self.expect_mount(found)
        self.assertAlmostEqual(found["lens"]["fx"], FX, delta=5 * found["std"]["lens"][0])

    def test_what_is_wrong_is_named(self):
        command = ["calibrate", "hand-eye", "--json", "result.json", "--corners", "corners.csv"]
        lens = ["--lens", "lens.json"]
        self.refuses([*command, *lens], 2, "--hand")
        self.refuses([*command, *lens, "--hand", "named.csv", "--eye", "named.csv"], 2, "either --eye")
        self.refuses([*command, *lens, "--hand", "named.csv", "--estimate-delay"], 2, "--stamps")
        self.refuses([*command, *lens, "--hand", "stream.csv"], 2, "1800 poses", "40 images", "--stamps")
        self.refuses([*command, "--lens", "stamps.csv", "--hand", "named.csv"], 2, "stamps.csv")
        rows = self.read("order.csv").decode().splitlines()
        turned_round = [pose_row(inverse(hand(0.4 * i))) for i in range(40)]
        self.write("inverse.csv", "\n".join([rows[0], *turned_round]) + "\n")
        self.refuses([*command, *lens, "--hand", "inverse.csv"], 1, "other way round")
        forgotten = self.answer("--hand", "stream.csv", "--stamps", "stamps.csv", *lens)
        self.assertIn("--estimate-delay", " ".join(forgotten["warnings"]))
        squares = self.answer("--hand", "named.csv", "--square-mm", "30", *lens)
        self.assertIn("--square-mm", " ".join(squares["warnings"]))
        self.assertAlmostEqual(squares["board_scale"], 25 / 30, delta=0.01)


if __name__ == "__main__":
    unittest.main()
