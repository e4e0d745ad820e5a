#!/usr/bin/env python3
"""An arm of Force Dimension's: the program loads a stand-in for the maker's library, whose device is moved, unplugged and switched off
through a file."""
import json
import os
import unittest

from cartesian_arm_rig import CartesianArmTest
from program import wait_until


class ForceDimension(CartesianArmTest):
    def setUp(self):
        super().setUp()
        self.environment.update(PALPATE_LIBDHD=os.environ["DHD_STUB"], DHD_STUB_STATE=self.state)
        self.stands()

    def holds(self, place):
        self.stands("place " + " ".join(f"{p:.6f}" for p in place))

    def later(self, physics, words):
        wait_until(lambda: physics.ended() or any(words in line for line in physics.lines()), f"it says '{words}'")
        self.assertFalse(physics.ended(), physics.lines())

    def test_what_happens_to_it_is_told_and_it_comes_back(self):
        self.mark_checked("forcedimension omega.3 1001", "peak_n = 1.0")
        physics = self.start_physics("--arm", "forcedimension", "--app", "touch", "--json", "physics.json")
        self.assertTrue(physics.says("omega.3 (serial 1001, 12.0 N), SDK 3.17.5"), physics.lines())
        self.stands("button")
        self.later(physics, "press its force button")
        self.stands("unplugged")
        self.later(physics, "omega.3 1001: ")
        wait_until(lambda: self.condition() == "safe: arm lost", "the status says that the arm is lost")
        self.stands("reset")
        self.later(physics, "put its handle to its rest place")
        self.stands()
        self.later(physics, "works again")
        self.stop(physics)
        figures = json.loads(self.read("physics.json"))["arm"]
        self.assertEqual((figures["driver"], figures["model"], figures["serial"], figures["watchdog"]), ("forcedimension", "omega.3", 1001, True))
        self.assertEqual(figures["times_lost"], 1)
        self.assertEqual(self.left_behind(), [])

    def test_a_checked_one_is_pushed_out_of_what_it_touches_and_never_too_hard(self):
        self.mark_checked("forcedimension omega.3 1001", "peak_n = 1.0")
        self.holds(self.over_the_pad(0.30))
        physics = self.start_physics("--arm", "forcedimension:1001", "--app", "touch", "--json", "physics.json")
        self.assertTrue(physics.says("forces stay below 1 N"), physics.lines())
        wait_until(lambda: self.condition() in ("ready", "running"), "forces are allowed")
        self.lower_through_the_pad(self.holds, lambda height: height <= -0.01)
        wait_until(lambda: self.condition().split(":")[0] in ("running", "degraded"), "it pushes")
        self.stop(physics)
        force = json.loads(self.read("physics.json"))["force"]
        self.assertGreater(force["peak_n"], 0.2)
        self.assertLessEqual(force["peak_n"], 1.0 + 1e-6)

    def check_forces(self, motors=""):
        """Its hand goes to each place that is asked for."""
        poses = ("0 0 0", "0.07 0 0")
        self.stands(f"hand {poses[0]} {motors}")
        check = self.start("calibrate", "forces", "--arm", "forcedimension", "--rig", self.rig, "--yes-held", "--json", "forces.json", "--poses", len(poses))
        for number, pose in enumerate(poses):
            wait_until(lambda n=number: check.ended() or any(f"pose {n + 1} of " in line for line in check.lines()), "a pose is asked for")
            self.stands(f"hand {pose} {motors}")
        return check.ends()

    def test_its_forces_are_checked_with_a_hand(self):
        for motors, verdict in (("axis 2", "axis mirrored"), ("exchanged 1 3", "axes exchanged")):
            done = self.check_forces(motors)
            self.assertEqual(done.code, 1, done)
            self.assertIn(f"forces stay off: {verdict}: ", done.lines[-1])
            self.assertEqual(json.loads(self.read("forces.json"))["verdict"], verdict)
            self.assertNotIn(b"[forces]", self.read("rig.toml"))
        done = self.check_forces()
        self.assertEqual(done.code, 0, done)
        self.assertIn("whether all axes are equally strong a hand cannot tell", done.out)
        result = json.loads(self.read("forces.json"))
        # Its axes are the same in all poses: an uneven hand looks like uneven motors (docs/theory/force-check.md).
        self.assertEqual((result["verdict"], result["ratios_told"], result["peak_n"]), ("agreed", False, 1.0))
        physics = self.start_physics("--arm", "forcedimension", "--app", "touch")
        self.assertTrue(physics.says("forces stay below 1 N"), physics.lines())
        wait_until(lambda: self.condition() in ("ready", "running"), "forces are allowed")
        self.stop(physics)

    def test_what_is_not_there_is_refused_in_words(self):
        physics = ["physics", "--rig", self.rig, "--seconds", "1", "--arm"]
        self.says_no(self.run_program(*physics, "forcedimension:7"), 1, "there is no device 7, but omega.3 1001")
        self.says_no(self.run_program(*physics, "forcedimension:x"), 2, "--arm", "forcedimension or forcedimension:SERIAL")
        self.stands("unplugged")
        self.says_no(self.run_program(*physics, "forcedimension"), 1, "there is no device", "switch it on")
        self.environment["PALPATE_LIBDHD"] = os.path.join(self.root, "libdhd.so")
        self.says_no(self.run_program(*physics, "forcedimension"), 1, "libdhd.so is not there", "install the maker's SDK")


if __name__ == "__main__":
    unittest.main()
