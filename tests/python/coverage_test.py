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

    def arms_held(self, **stated):
        """Each run another arm, calibrated with 40 places of its tip: the region of the tip where it was not trained, and of the gains."""
        random = np.random.default_rng(16)
        tips = gains = 0
        for _ in range(RUNS):
            arm = SimulatedArm(random)
            readings = arm.readings(40)
            samples = palpate.ArmSamples(readings, tips=arm.measured(readings), **stated)
            result = palpate.calibrate_arm(samples, "phantom-premium-1.5", free=["gains", "offsets"])
            unseen = arm.readings(1)
            error = (result.tips(unseen) - arm.tips(unseen))[0]
            tips += error @ np.linalg.solve(result.tip_covariances(unseen)[0], error) < CHI_SQUARE_95[3]
            at = [i for i, name in enumerate(result.order) if name.startswith("gain")]
            error = result.gains - arm.gains
            gains += error @ np.linalg.solve(result.covariance[np.ix_(at, at)], error) < CHI_SQUARE_95[3]
        print(f"arm, {', '.join(stated) or 'nothing'} stated: the tip's region held the truth in {tips}, the gains' in {gains} of {RUNS} runs")
        return tips, gains

    def test_of_an_arm_whose_tracker_has_no_systematic_error(self):
        for held in self.arms_held(covariances=np.tile(1e-8 * np.eye(3), (40, 1, 1)), systematic=np.zeros(40)):
            self.covers(held)

    def test_of_an_arm_whose_tracker_may_have_one(self):
        """There is none: the regions are wider than they had to be, and hold the truth no less often."""
        for held in self.arms_held():
            self.assertGreaterEqual(held, 0.95 * RUNS)


if __name__ == "__main__":
    unittest.main()
