#!/usr/bin/env python3
"""The program of PALPATE_PARTS=physics: its few commands, and none of the libraries that camera and graphics need."""
import subprocess
import unittest

from program import PROGRAM, ProgramTest


class PhysicsAlone(ProgramTest):
    def test_it_links_nothing_of_camera_and_graphics(self):
        linked = subprocess.run(["ldd", PROGRAM], stdout=subprocess.PIPE, text=True, check=True).stdout
        self.assertIn("libzmq", linked)
        for library in ("opencv", "libGL", "libEGL", "epoxy", "ceres"):
            self.assertNotIn(library, linked)

    def test_it_has_the_commands_of_its_machine_and_no_others(self):
        self.assertIn("pingpong", self.runs("apps").out)
        self.runs("keys", "new", "--keys", self.path("keys"))
        self.refuses(["demo"], 2, "no such command", "apps, physics, keys")

    def test_the_server_says_what_it_lacks(self):
        self.refuses(["physics", "--rig", "none.toml"], 2, "none.toml")
        self.refuses(["physics", "--rig", self.write("rig.toml", "rig_version = 1\n")], 1, "no arm calibration")


if __name__ == "__main__":
    unittest.main()
