#!/usr/bin/env python3
"""A hundred thousand calls, of which a third is refused, leave no memory behind."""
import contextlib
import os
import unittest

import numpy as np

import palpate
from simulated import simulated_pivot

CALLS = 100_000
WARM_UP = 5_000
MOST_KIB = 2048  # a hundred thousand objects of 21 bytes


def resident_kib():
    with open("/proc/self/statm", encoding="ascii") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE") // 1024


class Growth(unittest.TestCase):
    def test_of_many_calls(self):
        random = np.random.default_rng(7)
        points, line = random.uniform(-0.2, 0.2, (6, 3)), np.outer(np.arange(6.0), [0.01, 0.02, 0.03])
        poses = palpate.Poses(simulated_pivot(random, count=6)[0])

        def call(i):
            with contextlib.suppress(palpate.Refused):
                if i % 3 == 0:
                    palpate.absolute_orientation(line, line)
                elif i % 3 == 1:
                    palpate.absolute_orientation(points, points + 1e-4 * random.standard_normal((6, 3))).to_dict()
                else:
                    np.asarray(poses[i % 2:])

        for i in range(WARM_UP):
            call(i)
        before = resident_kib()
        for i in range(CALLS):
            call(i)
        self.assertLess(resident_kib() - before, MOST_KIB)


if __name__ == "__main__":
    unittest.main()
