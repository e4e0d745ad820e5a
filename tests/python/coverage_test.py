#!/usr/bin/env python3
"""The regions that a result states hold the truth as often as they say: 95 % ellipsoids in 93 to 97 % of 1000 runs."""
import unittest

import numpy as np

import palpate
from simulated import SimulatedArm, simulated_pivot, turn

RUNS = 1000
CHI_SQUARE_95 = {3: 7.8147, 6: 12.5916}


class Coverage(unittest.TestCase):
    def covers(self, held):
        self.assertGreaterEqual(held, 0.93 * RUNS)
        self.assertLessEqual(held, 0.97 * RUNS)

    def pivots_held(self, **options):
        random = np.random.default_rng(14)
        held = 0
        for _ in range(RUNS):
            poses, truth = simulated_pivot(random, count=120)
            result = palpate.calibrate_pivot(poses, **options)
            error = np.array([*result.tip, *result.pivots[0]]) - truth
            held += error @ np.linalg.solve(result.covariance, error) < CHI_SQUARE_95[6]
        return held

    def test_of_a_pivot_whose_poses_err_independently(self):
        self.covers(self.pivots_held(shared_errors=False))

    def test_of_a_pivot_that_allows_for_shared_errors(self):
        """There are none: the regions are wider than they had to be, and hold the truth no less often."""
        self.assertGreaterEqual(self.pivots_held(), 0.95 * RUNS)

    def test_of_a_rigid_motion(self):
        random = np.random.default_rng(15)
        rotation, translation = turn(np.array([0.3, -1.2, 0.7])), np.array([0.1, -0.4, 0.9])
        held = 0
        for _ in range(RUNS):
            a = random.uniform(-0.2, 0.2, (40, 3))
            b = a @ rotation.T + translation + 1e-4 * random.standard_normal((40, 3))
            result = palpate.absolute_orientation(a, b)
            error = result.translation - translation
            held += error @ np.linalg.solve(result.covariance[3:, 3:], error) < CHI_SQUARE_95[3]
        self.covers(held)

    def test_of_an_arms_tip_where_it_was_not_trained(self):
        """Each run another arm, calibrated with 40 places of its tip; the region of the tip at one reading that it has not seen."""
        random = np.random.default_rng(16)
        held = joints_held = 0
        for _ in range(RUNS):
            arm = SimulatedArm(random)
            readings = arm.readings(40)
            samples = palpate.ArmSamples(readings, tips=arm.measured(readings))
            result = palpate.calibrate_arm(samples, "phantom-premium-1.5", free=["gains", "offsets"])
            unseen = arm.readings(1)
            error = (result.tips(unseen) - arm.tips(unseen))[0]
            held += error @ np.linalg.solve(result.tip_covariances(unseen)[0], error) < CHI_SQUARE_95[3]
            gains = [i for i, name in enumerate(result.order) if name.startswith("gain")]
            error = result.gains - arm.gains
            joints_held += error @ np.linalg.solve(result.covariance[np.ix_(gains, gains)], error) < CHI_SQUARE_95[3]
        print(f"arm: the tip's region held the truth in {held}, the gains' in {joints_held} of {RUNS} runs")
        self.covers(held)
        self.covers(joints_held)


if __name__ == "__main__":
    unittest.main()
