#!/usr/bin/env python3
"""The examples, as a reader would run them, with Debian's Python and its packages."""
import os
import subprocess
import unittest

from laboratory import LaboratoryTest

EXAMPLES = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "examples")


class Examples(LaboratoryTest):
    def test_the_watcher_in_python_sees_the_scene_and_the_states(self):
        world, physics = self.start_world(), self.start_physics()
        with open(os.path.join(EXAMPLES, "watch.py"), encoding="utf-8") as file:
            self.assertLess(len(file.readlines()), 40)
        done = subprocess.run(["/usr/bin/python3", os.path.join(EXAMPLES, "watch.py"), f"ipc://{self.meeting}/palpate/physics.sock", "20"],
                              stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=120, check=False, env=self.environment)
        self.assertEqual((done.returncode, done.stderr), (0, ""), done)
        scene, moment, *states = done.stdout.splitlines()
        self.assertEqual(scene, "pingpong: table, wall; we are ROLE_OPERATOR")
        self.assertRegex(moment, "^20 ms ago: tick [1-9][0-9]*, ANSWER_(EXACT|INTERPOLATED)$")
        ticks = [int(line.split()[0]) for line in states]
        self.assertEqual(len(ticks), 20)
        self.assertEqual(ticks, sorted(set(ticks)))
        self.assertEqual(self.stop_in_order(physics, world), [[], []])


if __name__ == "__main__":
    unittest.main()
