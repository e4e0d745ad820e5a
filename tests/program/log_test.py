#!/usr/bin/env python3
"""The log file: what stands on standard error and more, with time and level, of a program and of those beside it."""
import re
import unittest

from laboratory import LaboratoryTest

LINE = re.compile(r"(\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d\.\d{3}[+-]\d\d:\d\d) (debug|info|warning|error) +(\S.*)")


class Log(LaboratoryTest):
    def logged(self, name="run.log"):
        """(time, level, text) of each line."""
        lines = self.read(name).decode().splitlines()
        found = [LINE.fullmatch(line) for line in lines]
        self.assertTrue(all(found), lines)
        return [match.groups() for match in found]

    def test_standard_error_stays_short_and_the_file_has_time_and_level(self):
        plain = self.run_program("rig", "show", "nowhere.toml")
        for arguments in (["--log", "run.log", "rig", "show", "nowhere.toml"], ["rig", "show", "nowhere.toml", "--log=run.log"]):
            done = self.run_program(*arguments)
            self.assertEqual((done.code, done.err, done.out), (plain.code, plain.err, plain.out))
        lines = self.logged()
        self.assertEqual([level for _, level, _ in lines], ["debug", "error"] * 2)
        self.assertEqual("palpate: " + lines[1][2], plain.lines[0])
        self.assertIn("palpate --log run.log rig show nowhere.toml", lines[0][2])

    def test_servers_share_a_file(self):
        self.environment["PALPATE_LOG"] = self.path("shared.log")
        world = self.start_world("--arm-only")
        physics = self.start_physics("--seconds", "0.5")
        told = physics.ends().lines
        world.send(2)
        told += world.ends().lines
        texts = ["palpate: " + text for _, level, text in self.logged("shared.log") if level != "debug"]
        self.assertEqual(sorted(texts), sorted(told))
        self.assertTrue(any("answers graphics servers" in text for text in texts), texts)
        self.assertTrue(any("are open" in text for text in texts), texts)

    def test_a_file_that_cannot_be_had_is_refused(self):
        self.refuses(["apps", "--log"], 2, "--log: a file is expected")
        self.refuses(["apps", "--log="], 2, "--log: a file is expected")
        self.refuses(["--log", "none/run.log", "apps"], 2, "none/run.log", "no folder")
        self.refuses(["--log", ".", "apps"], 2, "cannot be opened")

    def test_texts_of_others_steer_no_terminal(self):
        done = self.run_program("--log", "run.log", "rig", "show", "no\x1b[2Jwhere\u202e.toml")
        self.says_no(done, 2, "no?[2Jwhere?.toml")
        self.assertNotIn(b"\x1b", self.read("run.log"))
        self.assertNotIn("\u202e".encode(), self.read("run.log"))


if __name__ == "__main__":
    unittest.main()
