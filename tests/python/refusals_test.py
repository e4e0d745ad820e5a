#!/usr/bin/env python3
"""What makes no sense is refused before anything is computed, in words that name the argument and what is expected."""
import pathlib
import tempfile
import unittest

import numpy as np

import palpate
from simulated import matrices, simulated_pivot, turn

POSES, _ = simulated_pivot(np.random.default_rng(3), count=30)
PLACES = np.random.default_rng(4).uniform(-0.2, 0.2, (8, 3))
JOINTS = np.random.default_rng(5).uniform(-0.5, 0.5, (40, 3))


class Quantity:
    """A number with a unit, as libraries of units have it."""

    units = "millimeter"

    def __array__(self, dtype=None):
        return PLACES


class Refusals(unittest.TestCase):
    def refuses(self, kind, words, call, *arguments, **named):
        with self.assertRaises(kind) as caught:
            call(*arguments, **named)
        for word in words:
            self.assertIn(word, str(caught.exception))
        return caught.exception

    def test_wrong_shapes(self):
        pivot, points = palpate.calibrate_pivot, palpate.absolute_orientation
        self.refuses(ValueError, ["poses", "(30, 3)", "(N, 4, 4)", "metres"], pivot, POSES[:, :3, 3])
        self.refuses(ValueError, ["poses", "(0, 4, 4)"], pivot, POSES[:0])
        self.refuses(ValueError, ["poses", "rows are of unlike length"], pivot, [[[1.0]], [[1.0, 2.0]]])
        self.refuses(ValueError, ["to_points", "has 7 entries", "from_points has 8"], points, PLACES, PLACES[:7])
        self.refuses(ValueError, ["from_points", "(8, 2)", "(N, 3)"], points, PLACES[:, :2], PLACES)
        self.refuses(ValueError, ["time", "29", "30"], pivot, POSES, time=np.arange(29.0))
        self.refuses(ValueError, ["segments", "2", "30"], pivot, POSES, segments=["a", "b"])
        self.refuses(ValueError, ["corners[0]", "(54, 2)", "px"], palpate.calibrate_camera, np.zeros((5, 53, 2)), (640, 480))
        self.refuses(ValueError, ["hand", "eye", "one by one"], palpate.calibrate_hand_eye, POSES, POSES[:20])
        self.refuses(ValueError, ["joints", "4 columns", "3 joints"], palpate.calibrate_arm,
                     palpate.ArmSamples(np.zeros((8, 4)), tips=PLACES), "phantom-premium-1.5")

    def test_wrong_types(self):
        pivot = palpate.calibrate_pivot
        self.refuses(TypeError, ["poses is None", "(N, 4, 4)"], pivot, None)
        self.refuses(TypeError, ["poses", "complex128"], pivot, POSES.astype(complex))
        self.refuses(TypeError, ["poses", "<U"], pivot, POSES.astype(str))
        self.refuses(TypeError, ["poses", "bool"], pivot, POSES.astype(bool))
        self.refuses(ValueError, ["poses", "no numbers"], pivot, [[None] * 4] * 4)
        self.refuses(TypeError, ["time", "datetime64", "seconds"], pivot, POSES, time=np.arange(30).astype("datetime64[ms]"))
        self.refuses(TypeError, ["corners", "float64", "0 to 4"], palpate.calibrate_surface, PLACES, corners=np.ones(8))
        self.refuses(TypeError, ["samples", "ndarray", "ArmSamples"], palpate.calibrate_arm, JOINTS, "phantom-premium-1.5")
        self.refuses(TypeError, ["delay", "'0.1'", "seconds"], palpate.calibrate_hand_eye, POSES, POSES, delay="0.1")
        self.refuses(ValueError, ["method", "'best'", "algebraic, sphere, robust"], pivot, POSES, method="best")
        self.refuses(TypeError, ["path", "file"], palpate.read_poses, 7)
        # whole numbers and other floats are numbers
        self.assertIsInstance(palpate.absolute_orientation((1000 * PLACES).astype(int) / 1e3, PLACES.astype(np.float32)), palpate.Result)

    def test_wrong_units(self):
        far = POSES.copy()
        far[:, :3, 3] *= 1e3
        self.refuses(ValueError, ["poses", "metres", "millimetres?"], palpate.calibrate_pivot, far)
        self.refuses(ValueError, ["joints", "radians", "degrees?"], palpate.ArmSamples, np.degrees(JOINTS), tips=np.zeros((40, 3)))
        self.refuses(ValueError, ["time", "seconds", "nanoseconds?"], palpate.calibrate_pivot, POSES,
                     time=1_700_000_000_000_000_000 + 10_000_000 * np.arange(30))
        self.refuses(ValueError, ["square", "metres", "millimetres?"], palpate.calibrate_camera, np.zeros((5, 54, 2)), (640, 480), square=25)
        self.refuses(TypeError, ["from_points", "a unit of its own", "millimeter"], palpate.absolute_orientation, Quantity(), PLACES)

    def test_numbers_that_are_none(self):
        hole = POSES.copy()
        hole[7, 0, 3] = np.nan
        self.refuses(ValueError, ["poses[7, 0, 3] is nan", "finite"], palpate.calibrate_pivot, hole)

    def test_poses_that_are_none(self):
        self.refuses(ValueError, ["poses", "transposed?"], palpate.calibrate_pivot, POSES.transpose(0, 2, 1))
        mirrored = POSES.copy()
        mirrored[4, :3, 0] *= -1.0
        self.refuses(ValueError, ["hand[4]", "no rotation"], palpate.calibrate_hand_eye, mirrored, POSES)
        self.refuses(ValueError, ["quaternions[1]", "length 2"], palpate.poses_from_quaternions, [[0, 0, 0]] * 2,
                     [[1, 0, 0, 0], [2, 0, 0, 0]], "wxyz")
        self.refuses(ValueError, ["order", "'wzyx'", "wxyz, xyzw"], palpate.poses_from_quaternions, [[0, 0, 0]], [[1, 0, 0, 0]], "wzyx")

    def test_data_that_cannot_carry_an_answer(self):
        still = matrices(np.array([turn(np.array([1e-3 * i, 0, 0])) for i in range(30)]), np.zeros((30, 3)))
        refused = self.refuses(palpate.Refused, ["pivot", "turns by", "swing"], palpate.calibrate_pivot, still)
        self.assertEqual(refused.code, "unspecified")
        self.assertEqual(refused.reason, str(refused))
        self.assertTrue(refused.remedy.startswith("swing it further"), refused.remedy)
        line = np.outer(np.arange(6.0), [0.01, 0.02, 0.03])
        self.refuses(palpate.Refused, ["on a line", "beside"], palpate.absolute_orientation, line, line)
        self.refuses(palpate.Refused, ["hand-eye", "needed"], palpate.calibrate_hand_eye, still, still)

    def test_words_name_arguments_and_no_options(self):
        apart = self.refuses(palpate.Refused, ["estimate_delay=True"], palpate.calibrate_hand_eye, POSES, POSES,
                             hand_time=np.arange(30.0), eye_time=1000 + np.arange(30.0))
        self.assertNotIn("--", str(apart))
        self.refuses(ValueError, ["free=speed"], palpate.calibrate_arm,
                     palpate.ArmSamples(JOINTS, tips=np.random.default_rng(6).uniform(-0.1, 0.1, (40, 3))),
                     "phantom-premium-1.5", free=["speed"])

    def test_files(self):
        with tempfile.TemporaryDirectory() as folder:
            self.refuses((ValueError, FileNotFoundError), ["none.csv"], palpate.read_poses, pathlib.Path(folder) / "none.csv")
            odd = pathlib.Path(folder) / "odd.csv"
            odd.write_text("a,b\n1,2\n", encoding="ascii")
            self.refuses(ValueError, ["odd.csv"], palpate.read_poses, odd)
            self.refuses(ValueError, ["odd.csv"], palpate.Rig.load, odd)

    def test_results_cannot_be_changed_and_arguments_are_not(self):
        given = POSES.copy()
        result = palpate.calibrate_pivot(given)
        np.testing.assert_array_equal(given, POSES)
        self.assertTrue(given.flags.writeable)
        for array in (result.tip, result.covariance, result.residuals, result.inliers, result.pivots, result.tip_std):
            with self.assertRaises(ValueError):
                array[0] = 0
        with self.assertRaises(AttributeError):
            result.tip = None
        told = result.to_dict()
        told["tip_mm"].clear()
        self.assertEqual(len(result.to_dict()["tip_mm"]), 3)


if __name__ == "__main__":
    unittest.main()
