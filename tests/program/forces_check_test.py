#!/usr/bin/env python3
"""The check of an arm's forces by the real program: in the laboratory, and on a stand-in for the maker's library, whose hand holds the
stylus and whose motors are wired wrongly through a file. Each tick has to come within 5 ms: on a busy machine pushes are broken off."""
import json
import signal
import unittest

from laboratory import StandInArmTest
from program import wait_until

POSES = ("0 0.2 0.1", "-0.5 0.5 0.1", "0.5 0.4 -0.2", "-0.5 0.0 -0.3", "0.5 0.1 0.3")


class ForcesCheck(StandInArmTest):
    def check(self, motors="", *options):
        """The check on the stand-in, the hand of which goes to each pose that is asked for."""
        poses = POSES[:2] if motors else POSES
        options = (*options, "--poses", len(poses))
        self.stands(f"hand {POSES[0]} {motors}")
        check = self.start("calibrate", "forces", "--arm", "openhaptics", "--rig", self.rig, "--yes-held", "--json", "forces.json", *options)
        for number, pose in enumerate(poses):
            wait_until(lambda n=number: check.ended() or any(f"pose {n + 1} of " in line for line in check.lines()), "a pose is asked for")
            self.stands(f"hand {pose} {motors}")
        return check.ends()

    def test_an_arm_that_is_well_is_checked_and_kept_in_the_rig(self):
        done = self.check("", "--dead-man", "1")
        self.assertEqual(done.code, 0, done)
        result = json.loads(self.read("forces.json"))
        self.assertEqual((result["verdict"], result["peak_n"], result["poses"]), ("agreed", 1.0, 5))
        shown = self.runs("rig", "show", self.rig).out
        self.assertIn("checked on openhaptics Simulated PHANToM 0042", shown)
        deviations = " ".join(f"{sd:.2f}" for sd in result["joint_gains_std"])
        self.assertRegex(shown, rf"joint gains .*  \+- {deviations}\n")
        physics = self.start_physics("--arm", "openhaptics")
        self.assertTrue(physics.says("only while button 1"), physics.lines())
        physics.send(signal.SIGTERM)
        self.assertEqual(physics.ends().code, 0)

    def test_a_faulty_arm_is_refused_by_name_and_loses_its_check(self):
        for motors, verdict in (("exchanged 2 3", "joints exchanged"),):
            done = self.check(motors)
            self.assertEqual(done.code, 1, done)
            self.assertIn(f"forces stay off: {verdict}: ", done.lines[-1])
            self.assertEqual(json.loads(self.read("forces.json"))["verdict"], verdict)
            self.assertNotIn(b"[forces]", self.read("rig.toml"))

    def test_in_the_laboratory_its_own_hand_holds_the_stylus(self):
        world = self.start_world()
        done = self.run_program("calibrate", "forces", "--arm", "lab", "--rig", self.rig, "--json", "forces.json")
        self.assertEqual(done.code, 0, done)
        self.assertEqual(json.loads(self.read("forces.json"))["verdict"], "agreed")
        world.send(signal.SIGTERM)
        world.ends()


if __name__ == "__main__":
    unittest.main()
