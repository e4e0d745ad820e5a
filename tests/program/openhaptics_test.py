#!/usr/bin/env python3
"""The physics server with a real arm and no laboratory: the program loads a stand-in for the maker's library, whose device is
unplugged and overheated through a file."""
import json
import os
import signal
import unittest

from laboratory import READY, StandInArmTest
from program import wait_until


class OpenHaptics(StandInArmTest):
    def says_later(self, server, words):
        before = len(server.lines())
        wait_until(lambda: server.ended() or any(words in line for line in server.lines()[before:]),
                   f"the server says '{words}'; so far {server.lines()}")
        self.assertFalse(server.ended(), server.lines())

    def test_it_serves_without_a_laboratory_and_tells_of_its_arm(self):
        physics = self.start("physics", "--rig", self.rig, "--arm", "openhaptics", "--seconds", "1", "--json", "figures.json")
        self.assertTrue(physics.says(READY["physics"]), physics.lines())
        self.assertTrue(physics.says("Simulated PHANToM (serial 0042, 8.5 N)"))
        self.assertEqual(physics.ends().code, 0)
        figures = json.loads(self.read("figures.json"))
        self.assertEqual(figures["arm"]["driver"], "openhaptics")
        self.assertGreater(figures["arm"]["cycles"], 0)
        self.assertGreater(figures["haptic"]["ticks"], 0)
        self.assertEqual(self.left_behind(), [])

    def test_unplugging_and_warm_motors_are_told_in_words_and_survived(self):
        physics = self.start_physics("--arm", "openhaptics:Left")
        self.assertTrue(physics.says("serial 0042"))
        self.stands("unplugged")
        self.says_later(physics, "device 'Left': the connection to it broke (HD_COMM_ERROR")
        self.stands()
        self.says_later(physics, "works again")
        self.stands("warm")
        self.says_later(physics, "its motors are too warm (HD_WARM_MOTORS")
        self.stands()
        self.says_later(physics, "works again")
        physics.send(signal.SIGTERM)
        done = physics.ends()
        self.assertEqual(done.code, 0, done)
        self.assertEqual(self.left_behind(), [])

    def test_after_unplugging_forces_stay_off_until_an_operator_resets(self):
        self.mark_checked(self.ARM, "peak_n = 1.0")
        physics = self.start_physics("--arm", "openhaptics")
        self.assertTrue(physics.says("serial 0042"))

        def forces(*options):
            return json.loads(self.runs("status", "--json", "-", *options).out)["loops"][0]["condition"]
        self.stands("unplugged")
        wait_until(lambda: forces() == "safe: arm lost", "the status says that the arm is lost")
        self.stands()
        self.says_later(physics, "`palpate status --reset`")
        self.assertEqual(forces(), "safe: arm lost")
        forces("--reset")
        wait_until(lambda: forces().split(":")[0] in ("ready", "running", "degraded"), "forces are allowed again")
        physics.send(signal.SIGTERM)
        self.assertEqual(physics.ends().code, 0)

    def test_what_is_missing_is_named_with_its_remedy(self):
        arm = ("physics", "--rig", self.rig, "--arm")
        self.says_no(self.run_program(*arm, "phantom"), 2, "--arm", "'phantom'", "lab, openhaptics or openhaptics:NAME")
        self.says_no(self.run_program(*arm, "openhaptics:Middle"), 1, "device 'Middle'", "HD_DEVICE_FAULT", "; see that it has power")
        self.stands("unplugged")
        self.says_no(self.run_program(*arm, "openhaptics"), 1, "the default device", "does not answer", "cable")
        self.environment["PALPATE_LIBHD"] = self.path("libHD.so")
        self.says_no(self.run_program(*arm, "openhaptics"), 1, "libHD.so is not there", "install", "PALPATE_LIBHD")
        self.write("libHD.so", b"\x7fELF\x01" + bytes(60))
        self.says_no(self.run_program(*arm, "openhaptics"), 1, "32-bit")
        for kind, words in (("old", "lacks hdCheckCalibration"), ("lonely", "needs libPhantomIOLib42.so")):
            self.environment["PALPATE_LIBHD"] = os.path.join(os.path.dirname(os.environ["HD_STUB"]), "..", kind, "libHD.so")
            self.says_no(self.run_program(*arm, "openhaptics"), 1, words)

    def doctor(self, *options):
        done = self.run_program("doctor", "--keys", self.path("keys"), "--json", "-", *options)
        return {f["name"]: f for f in json.loads(done.out)["findings"] if f["area"] == "devices"}

    def test_doctor_knows_the_library_and_opens_the_arm_only_where_asked(self):
        found = self.doctor()
        self.assertEqual(found["haptic arm"]["verdict"], "ok")
        self.assertIn("OpenHaptics 3.4.0", found["haptic arm"]["value"])
        self.assertNotIn("arm", found)
        found = self.doctor("--arm", "openhaptics:Right")
        self.assertEqual(found["arm"]["value"], "Right: Simulated PHANToM, serial 0042, 8.5 N")
        self.stands("unplugged")
        found = self.doctor("--arm", "openhaptics")
        self.assertEqual(found["arm"]["verdict"], "in the way")
        self.assertIn("power", found["arm"]["remedy"])
        self.environment.update(PALPATE_LIBHD=self.path("none.so"), GTDD_HOME=self.path("none"))
        found = self.doctor()
        self.assertEqual((found["haptic arm"]["verdict"], found["arm settings"]["verdict"]), ("worth knowing",) * 2)
        found = self.doctor("--arm", "openhaptics")
        self.assertEqual((found["haptic arm"]["verdict"], found["arm settings"]["verdict"]), ("in the way",) * 2)
        self.refuses(["doctor", "--arm", "lab"], 2, "--arm", "'lab'", "openhaptics:NAME")


if __name__ == "__main__":
    unittest.main()
