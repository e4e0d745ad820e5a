#!/usr/bin/env python3
"""Guests that misbehave, loaded as plug-ins by the real physics server beside a simulated laboratory: the force goes within its
limits, who did it is named, and the server goes on or ends in words. A driver of the same plug-in writes down what the arm is
commanded (tests/hostile/hostile_guests.cpp)."""
import json
import os
import struct
import unittest

from laboratory import LaboratoryTest, READY
from program import wait_until

GUESTS = os.environ["HOSTILE_GUESTS"]
COMMANDED, LET_GO, WRONG = 0, 1, 2
PEAK_N, SLEW_N = 8.5, 3.0  # what such an arm gives at most; how much a command may differ from the one before


class HostileGuests(LaboratoryTest):
    def plays(self, application, said_when_wrong, arm="listened", ends=False):
        """Runs it until a guest has gone wrong and was named; the rows (s, N, kind) and how the server ended."""
        name = f"{application}.{arm.partition(':')[2]}.log"
        self.environment["PALPATE_HOSTILE_LOG"] = self.path(name)
        physics = self.start("physics", "--plugin", GUESTS, "--rig", self.rig, "--app", application, "--arm", arm)
        self.assertTrue(physics.says(READY["physics"]), physics.lines())
        self.assertTrue(physics.says(said_when_wrong), physics.lines())
        if not ends and not physics.ended():
            physics.send(15)
        done = physics.ends()
        rows = [row for row in struct.iter_unpack("3d", self.read(name)) if row[0] > 0.0]
        return rows, done

    def fades(self, rows):
        """Within limits before and after, to nothing, and for good."""
        at = next(i for i, row in enumerate(rows) if row[2] == WRONG)
        before = [force for _, force, kind in rows[:at] if kind == COMMANDED]
        after = [force for _, force, kind in rows[at:] if kind == COMMANDED]
        self.assertGreater(before[-1], 0.9, "it was felt")
        commands = before + after
        self.assertLess(max(commands), PEAK_N)
        self.assertLessEqual(max(abs(a - b) for a, b in zip(commands, commands[1:])), SLEW_N)
        forces = [force for force in after if force > 0.0]
        self.assertLess(len(forces), 60, "ticks with a force after it went wrong")
        self.assertTrue(all(force == 0.0 for force in after[len(forces):]), "it does not come back")
        if not after or len(after) == len(forces):
            self.assertTrue(any(kind == LET_GO for _, _, kind in rows[at:]), "the arm was let go")

    def test_each_loses_its_force_and_is_named_and_the_server_goes_on_or_ends_in_words(self):
        self.start_world()
        law, application = "the contact law of '{}'", "the application '{}'"
        for name, words, code in (("sleeper", law, 0), ("nan", law, 0), ("kilonewton", law, 0), ("thrower", application + " threw: no more levels", 1),
                                  ("hanger", law + " does not come back; the server ends", 1),
                                  ("staller", application + " does not come back; the server ends", 1),
                                  ("crasher", "crashed: " + law, -11)):
            with self.subTest(name):
                rows, done = self.plays(name, words.format(name), ends=code != 0 and name != "thrower")
                self.assertEqual(done.code, code, done)
                self.fades(rows)

    def test_a_driver_that_goes_wrong_loses_its_force_and_is_named(self):
        self.start_world()
        driver = "the arm's driver"
        for wrong, words, code in (("sleeps", driver, 0), ("throws", driver, 0), ("nan", driver, 0),
                                   ("hangs", driver + " does not come back; the server ends", 1), ("crashes", "crashed: " + driver, -11)):
            with self.subTest(wrong):
                rows, done = self.plays("steady", words, "listened:" + wrong, ends=code != 0)
                self.assertEqual(done.code, code, done)
                self.fades(rows)

    def test_a_server_that_is_asked_to_end_while_a_guest_hangs_ends_in_words(self):
        self.start_world()
        physics = self.start("physics", "--plugin", GUESTS, "--rig", self.rig, "--app", "staller", "--arm", "listened")
        self.assertTrue(physics.says("does not come back; forces are off"), physics.lines())
        physics.send(15)
        done = physics.ends()
        self.assertEqual(done.code, 1, done)
        self.assertIn("the application 'staller' does not come back; the server ends", done.err)

    def test_a_driver_that_goes_wrong_while_its_forces_are_checked(self):
        self.start_world()
        self.environment["PALPATE_HOSTILE_FELT_N"] = "0.01"  # nobody holds the stylus: a stronger push is broken off
        before = self.read("rig.toml")
        for wrong, words in (("throws", "the arm is gone"), ("hangs", "does not come back; nothing was changed")):
            with self.subTest(wrong):
                self.environment["PALPATE_HOSTILE_LOG"] = self.path(f"check.{wrong}.log")
                arm = "listened:" + wrong
                done = self.run_program("calibrate", "forces", "--plugin", GUESTS, "--rig", self.rig, "--arm", arm, "--yes-held")
                self.assertEqual(done.code, 1, done)
                self.assertIn(words, done.lines[-1])
                rows = [row for row in struct.iter_unpack("3d", self.read(f"check.{wrong}.log")) if row[0] > 0.0]
                at = next(i for i, row in enumerate(rows) if row[2] == WRONG)
                self.assertTrue(any(kind == LET_GO for _, _, kind in rows[at:]), "the arm was let go")
                self.assertFalse(any(force > 0.0 for _, force, _ in rows[at:]), "and not commanded again")
        self.assertEqual(self.read("rig.toml"), before)

    def test_what_became_of_one_that_threw_is_told_wherever_somebody_looks(self):
        self.start_world()
        self.environment["PALPATE_HOSTILE_LOG"] = self.path("told.log")
        physics = self.start("physics", "--plugin", GUESTS, "--rig", self.rig, "--app", "thrower", "--arm", "listened:", "--json", "figures.json")
        self.assertTrue(physics.says("threw: no more levels"), physics.lines())
        wait_until(lambda: "forces off: the application 'thrower' threw: no more levels" in self.runs("status", "--once").out, "the status tells it")
        self.assertIn("threw: no more levels", json.loads(self.runs("status", "--json", "-").out)["failure"])
        physics.send(15)
        self.assertEqual(physics.ends().code, 1)
        self.assertIn("threw: no more levels", json.loads(self.read("figures.json"))["application_failure"])

    def test_a_demo_of_one_without_a_player_is_refused_at_once(self):
        self.refuses(["--plugin", GUESTS, "demo", "--app", "thrower", "--headless"], 2, "has no scripted player")

    def test_one_that_throws_while_it_is_made_is_refused_by_name(self):
        self.says_no(self.run_program("physics", "--plugin", GUESTS, "--rig", self.rig, "--app", "stillborn"), 1,
                     "stillborn: no level is there; install one")


if __name__ == "__main__":
    unittest.main()
