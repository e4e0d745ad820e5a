#!/usr/bin/env python3
"""No force on an arm that nobody has checked: what the physics server allows on a stand-in for the maker's library. The check itself,
which needs ticks that come in time, is tried in forces_check_test.py."""
import json
import signal
import unittest

from laboratory import StandInArmTest
from program import wait_until


class Forces(StandInArmTest):
    def condition(self):
        return json.loads(self.runs("status", "--json", "-").out)["loops"][0]["condition"]

    def stop(self, physics):
        physics.send(signal.SIGTERM)
        self.assertEqual(physics.ends().code, 0)

    def test_an_unchecked_arm_has_no_force(self):
        physics = self.start_physics("--arm", "openhaptics")
        self.assertTrue(physics.says("forces stay off: nobody has seen"), physics.lines())
        self.assertEqual(self.condition(), "safe: arm not checked")
        self.stop(physics)
        self.assertIn("not checked", self.runs("rig", "show", self.rig).out)

    def test_a_checked_one_has_while_its_button_is_held(self):
        self.mark_checked(self.ARM, "peak_n = 1.0", "dead_man_button = 1")
        self.assertIn("checked on " + self.ARM, self.runs("rig", "show", self.rig).out)
        physics = self.start_physics("--arm", "openhaptics")
        self.assertTrue(physics.says("forces stay below 1 N"), physics.lines())
        self.assertTrue(physics.says("only while button 1"), physics.lines())
        self.stands("button 1")
        wait_until(lambda: self.condition() in ("ready", "running"), "forces are allowed")
        self.stands("")
        wait_until(lambda: self.condition() == "degraded: button released", "the button counts")
        self.stop(physics)

    def test_a_server_that_is_to_be_armed_gives_no_force_before(self):
        self.mark_checked(self.ARM, "peak_n = 1.0")
        physics = self.start_physics("--arm", "openhaptics", "--disarmed")
        self.assertTrue(physics.says("until somebody arms them: palpate status --reset"), physics.lines())
        self.assertEqual(self.condition(), "safe: not armed")
        self.runs("status", "--reset")
        wait_until(lambda: self.condition() in ("ready", "running"), "forces are armed")
        self.stop(physics)

    def test_the_check_of_another_arm_permits_nothing(self):
        self.mark_checked("openhaptics Simulated PHANToM 0043", "peak_n = 1.0")
        physics = self.start_physics("--arm", "openhaptics")
        self.assertTrue(physics.says("forces stay off: since they were checked the arm has changed"), physics.lines())
        self.assertEqual(self.condition(), "safe: arm not checked")
        self.stop(physics)

    def test_wrong_use(self):
        arm = ["calibrate", "forces", "--rig", self.rig, "--arm"]
        self.says_no(self.run_program(*arm, "phantom"), 2, "--arm", "'phantom'")
        self.says_no(self.run_program(*arm, "openhaptics"), 2, "standard input is no terminal", "--key-button")
        self.says_no(self.run_program(*arm, "openhaptics", "--yes-held", "--weight-g", "500"), 2, "--weight-g")


if __name__ == "__main__":
    unittest.main()
