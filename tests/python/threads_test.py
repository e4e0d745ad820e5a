#!/usr/bin/env python3
"""Other threads run while a calibration solves; nothing is printed, and no library loaded that is not needed."""
import os
import subprocess
import sys
import threading
import time
import unittest

import numpy as np

import palpate
from simulated import simulated_pivot


class Threads(unittest.TestCase):
    def test_another_thread_goes_on_during_a_solve(self):
        """Without the lock the other thread counts all the while; with it, it stands still from the call to its end."""
        poses, _ = simulated_pivot(np.random.default_rng(1), count=4000)
        counted, asked, done = [0], threading.Event(), threading.Event()

        def count():
            asked.wait()
            while not done.is_set():
                counted[0] += 1
                time.sleep(0)  # gives the lock to who waits for it

        interval = sys.getswitchinterval()
        sys.setswitchinterval(5.0)  # until then nobody is made to give the lock away
        self.addCleanup(sys.setswitchinterval, interval)
        stood = palpate.Poses(poses)
        thread = threading.Thread(target=count, daemon=True)
        thread.start()
        asked.set()
        palpate.calibrate_pivot(stood)
        during = counted[0]
        done.set()
        sys.setswitchinterval(interval)
        thread.join()
        self.assertGreater(during, 0)

    def test_solves_side_by_side_agree(self):
        poses, _ = simulated_pivot(np.random.default_rng(2))
        alone = palpate.calibrate_pivot(poses).to_dict()
        together = [None] * 4

        def solve(i):
            together[i] = palpate.calibrate_pivot(poses).to_dict()

        threads = [threading.Thread(target=solve, args=(i,)) for i in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(together, [alone] * 4)

    def test_nothing_is_printed(self):
        script = "import numpy, palpate; from simulated import simulated_pivot;" \
                 "palpate.calibrate_pivot(simulated_pivot(numpy.random.default_rng(1))[0])\n" \
                 "try: palpate.absolute_orientation(numpy.zeros((5, 3)), numpy.zeros((5, 3)))\nexcept palpate.Refused: pass"
        done = subprocess.run([sys.executable, "-c", script], capture_output=True, check=True, cwd=os.path.dirname(__file__))
        self.assertEqual((done.stdout, done.stderr), (b"", b""))

    def test_opencv_and_protobuf_are_not_loaded_for_a_pivot(self):
        script = "import palpate; print(open('/proc/self/maps').read())"
        done = subprocess.run([sys.executable, "-c", script], capture_output=True, check=True, text=True)
        self.assertIn("_core", done.stdout)
        for library in ("opencv", "protobuf", "zmq", "libGL"):
            self.assertNotIn(library, done.stdout)


if __name__ == "__main__":
    unittest.main()
