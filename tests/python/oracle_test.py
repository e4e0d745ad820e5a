#!/usr/bin/env python3
"""The package beside plain numpy: the same answers from the same numbers, without shared code."""
import pathlib
import unittest

import numpy as np

import palpate
from simulated import matrices, simulated_pivot, turn

DATA = pathlib.Path(__file__).parents[2] / "data"


def solved_pivot(poses):
    """Tip and pivot by linear least squares: R t - c = -p."""
    count = len(poses)
    design = np.hstack([poses[:, :3, :3].reshape(-1, 3), np.tile(-np.eye(3), (count, 1))])
    return np.linalg.lstsq(design, -poses[:, :3, 3].reshape(-1), rcond=None)[0]


def solved_motion(a, b):
    """Rotation and translation by the singular values of the cross-covariance (Kabsch)."""
    u, _, vt = np.linalg.svd((a - a.mean(0)).T @ (b - b.mean(0)))
    rotation = vt.T @ np.diag([1, 1, np.sign(np.linalg.det(vt.T @ u.T))]) @ u.T
    return rotation, b.mean(0) - rotation @ a.mean(0)


class Oracle(unittest.TestCase):
    def test_a_pivot_by_least_squares(self):
        poses, truth = simulated_pivot(np.random.default_rng(11))
        result = palpate.calibrate_pivot(poses)
        solved = solved_pivot(poses)
        np.testing.assert_allclose([*result.tip, *result.pivots[0]], solved, atol=1e-12)
        self.assertLess(np.abs(solved - truth).max(), 2e-4)

    def test_a_real_pivot_by_least_squares(self):
        poses = palpate.read_poses(DATA / "plus_eight_landmark_pivots" / "stylus_to_reference.csv", segments="landmark")
        label = next(segment for segment in poses.segments if segment is not None)
        first = np.array([segment == label for segment in poses.segments])
        self.assertGreater(first.sum(), 50)
        # Repeats count once: the solver beside it gets the poses without them, too.
        some = np.unique(np.asarray(poses)[first].reshape(-1, 16), axis=0).reshape(-1, 4, 4)
        result = palpate.calibrate_pivot(some)
        np.testing.assert_allclose([*result.tip, *result.pivots[0]], solved_pivot(some), atol=1e-10)

    def test_a_rigid_motion_by_singular_values(self):
        random = np.random.default_rng(12)
        a = random.uniform(-0.2, 0.2, (12, 3))
        b = a @ turn(np.array([0.3, -1.2, 0.7])).T + [0.1, -0.4, 0.9] + 1e-4 * random.standard_normal((12, 3))
        result = palpate.absolute_orientation(a, b)
        rotation, translation = solved_motion(a, b)
        np.testing.assert_allclose(result.rotation, rotation, atol=1e-12)
        np.testing.assert_allclose(result.translation, translation, atol=1e-12)
        np.testing.assert_allclose(result(a), a @ rotation.T + translation, atol=1e-12)

    def test_quaternions_in_either_order(self):
        vectors = np.array([[0.1, 0.2, 0.3], [0.5, -0.4, 2.2]])
        angles = np.linalg.norm(vectors, axis=1, keepdims=True)
        xyzw = np.hstack([np.sin(angles / 2) * vectors / angles, np.cos(angles / 2)])
        for order, quaternions in (("xyzw", xyzw), ("wxyz", np.roll(xyzw, 1, axis=1))):
            poses = palpate.poses_from_quaternions([[0, 0, 1], [0, 1, 0]], quaternions, order)
            np.testing.assert_allclose(np.asarray(poses)[:, :3, :3], [turn(vector) for vector in vectors], atol=1e-12)
            np.testing.assert_allclose(poses.quaternions("xyzw"), xyzw, atol=1e-12)
        back = palpate.Poses(np.asarray(poses))
        np.testing.assert_allclose(back.quaternions("wxyz"), poses.quaternions("wxyz"), atol=1e-12)

    def test_hand_eye_of_exact_poses(self):
        random = np.random.default_rng(13)
        camera, board = np.eye(4), np.eye(4)
        camera[:3, :3], camera[:3, 3] = turn(np.array([0.2, -0.1, 1.5])), (0.02, 0.05, -0.03)
        board[:3, :3], board[:3, 3] = turn(np.array([-1.0, 0.3, 0.2])), (0.3, -0.1, 0.8)
        hand = matrices(np.array([turn(vector) for vector in random.uniform(-0.8, 0.8, (60, 3))]), random.uniform(-0.3, 0.3, (60, 3)))
        eye = np.linalg.inv(board) @ hand @ camera
        eye[:, :3, 3] += 1e-5 * random.standard_normal((60, 3))
        result = palpate.calibrate_hand_eye(hand, eye)
        np.testing.assert_allclose(result.camera_in_marker, camera, atol=5e-5)
        np.testing.assert_allclose(result.board_in_world, board, atol=5e-5)


if __name__ == "__main__":
    unittest.main()
