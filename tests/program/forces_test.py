#!/usr/bin/env python3
"""No force on an arm that nobody has checked: the check in the laboratory and on a stand-in for the maker's library, whose hand holds
the stylus and whose motors are wired wrongly through a file; and what the physics server then allows."""
import json
import os
import re
import signal
import unittest

from laboratory import LaboratoryTest, READY
from program import wait_until

STUB = os.environ["HD_STUB"]
POSES = ("0 0.2 0.1", "-0.5 0.5 0.1", "0.5 0.4 -0.2", "-0.5 0.0 -0.3", "0.5 0.1 0.3")


class Forces(LaboratoryTest):
    def setUp(self):
        super().setUp()
        self.state = os.path.join(self.root, "state")
        self.environment.update(PALPATE_LIBHD=STUB, HD_STUB_STATE=self.state)
        self.environment.pop("GTDD_HOME", None)

    def stands(self, words):
        with open(self.state + ".new", "w", encoding="ascii") as file:
            file.write(words)
        os.replace(self.state + ".new", self.state)

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

    def test_an_unchecked_arm_has_no_force_and_a_checked_one_has_until_it_is_another(self):
        physics = self.start_physics("--arm", "openhaptics")
        self.assertTrue(physics.says("forces stay off: nobody has seen"), physics.lines())
        self.assertEqual(json.loads(self.runs("status", "--json", "-").out)["loops"][0]["condition"], "safe: arm not checked")
        physics.send(signal.SIGTERM)
        self.assertEqual(physics.ends().code, 0)
        self.assertIn("not checked", self.runs("rig", "show", self.rig).out)

        done = self.check("", "--dead-man", "1")
        self.assertEqual(done.code, 0, done)
        result = json.loads(self.read("forces.json"))
        self.assertEqual((result["verdict"], result["peak_n"], result["poses"]), ("agreed", 1.0, 5))
        self.assertIn("checked on openhaptics Simulated PHANToM 0042", self.runs("rig", "show", self.rig).out)

        physics = self.start_physics("--arm", "openhaptics")
        self.assertTrue(physics.says("forces stay below 1 N"), physics.lines())
        self.assertTrue(physics.says("only while button 1"), physics.lines())

        def condition():
            return json.loads(self.runs("status", "--json", "-").out)["loops"][0]["condition"]
        self.stands("button 1")
        wait_until(lambda: condition() == "running", "forces are allowed")
        self.stands("")
        wait_until(lambda: condition() == "degraded: button released", "the button counts")
        physics.send(signal.SIGTERM)
        self.assertEqual(physics.ends().code, 0)

        text = self.read("rig.toml")
        self.write("rig.toml", re.sub(r"(\[forces\][^\[]*?arm = )\S.*", r'\1"openhaptics Simulated PHANToM 0043"', text, count=1))
        physics = self.start_physics("--arm", "openhaptics")
        self.assertTrue(physics.says("forces stay off: since they were checked the arm has changed"), physics.lines())
        physics.send(signal.SIGTERM)
        self.assertEqual(physics.ends().code, 0)

    def test_a_faulty_arm_is_refused_by_name_and_loses_its_check(self):
        for motors, verdict in (("exchanged 2 3", "joints exchanged"),):
            done = self.check(motors)
            self.assertEqual(done.code, 1, done)
            self.assertIn(f"forces stay off: {verdict}: ", done.lines[-1])
            self.assertEqual(json.loads(self.read("forces.json"))["verdict"], verdict)
            self.assertNotIn("[forces]", self.read("rig.toml"))

    def test_in_the_laboratory_its_own_hand_holds_the_stylus(self):
        world = self.start_world()
        done = self.run_program("calibrate", "forces", "--arm", "lab", "--rig", self.rig, "--json", "forces.json")
        self.assertEqual(done.code, 0, done)
        self.assertEqual(json.loads(self.read("forces.json"))["verdict"], "agreed")
        world.send(signal.SIGTERM)
        world.ends()

    def test_wrong_use(self):
        arm = ["calibrate", "forces", "--rig", self.rig, "--arm"]
        self.says_no(self.run_program(*arm, "phantom"), 2, "--arm", "'phantom'")
        self.says_no(self.run_program(*arm, "openhaptics"), 2, "standard input is no terminal", "--key-button")
        self.says_no(self.run_program(*arm, "openhaptics", "--yes-held", "--weight-g", "500"), 2, "--weight-g")


if __name__ == "__main__":
    unittest.main()
