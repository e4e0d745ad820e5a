#!/usr/bin/env python3
"""The application palpation as a user meets it: served, shown, refused."""
import csv
import json
import os
import signal
import unittest

from laboratory import LaboratoryTest
from program import wait_until

# Coarse, so that it is made ready within seconds.
QUICK = "[palpation]\nelement_mm = 14.0\nnodules = [1, 1]\nnodule_seed = 3\n"


class Palpation(LaboratoryTest):
    def setUp(self):
        super().setUp()
        self.environment["XDG_CACHE_HOME"] = self.path("cache")

    def test_it_is_listed_served_and_shown_and_known_again(self):
        self.assertIn("palpation", self.runs("apps").out)
        self.start_world()
        settings = self.write("quick.toml", QUICK)
        before = None
        for known in (False, True):
            physics = self.start("physics", "--rig", self.rig, "--app", "palpation", "--settings", settings, "--json", "figures.json")
            self.assertTrue(physics.says("answers graphics servers at"), physics.lines())
            parts = sorted(os.listdir(self.path("cache", "palpate", "organs")))
            self.assertEqual([name.split("-")[0] for name in parts], ["body", "dent", "tip"])
            if known:
                self.assertEqual(parts, before)
            before = parts
            graphics = self.start("graphics", "--rig", self.rig, "--player", "--seconds", "6", "--json", "shown.json")
            self.assertEqual(graphics.ends().code, 0, graphics.lines())
            self.assertGreater(json.loads(self.read("shown.json"))["exchange"]["frames"], 1)
            physics.send(signal.SIGTERM)
            self.assertEqual(physics.ends().code, 0, physics.lines())
            self.assertEqual(json.loads(self.read("figures.json"))["force"]["blows"], 0)

    def test_what_cannot_be_is_refused_with_the_remedy(self):
        physics = ["physics", "--rig", self.rig, "--app", "palpation"]
        for text, words in (("nodules = [2, 1]\n", ("nodules", "the smaller number first")), ("nodules = [0.5, 1]\n", ("nodules", "whole numbers")),
                            ("poisson = 0.5\n", ("poisson", "0.49")), ("deepest_mm = 12.0\n", ("deepest_mm", "1.4 times tip_radius_mm")),
                            ("trainee_press_mm = 9.0\n", ("trainee_press_mm", "deepest_mm")), ("trainee_senses = \"perhaps\"\n", ("trainee_senses", "perhaps")),
                            ("mesh = \"missing.stl\"\n", ("missing.stl",))):
            settings = self.write("wrong.toml", "[palpation]\n" + text)
            self.says_no(self.run_program(*physics, "--settings", settings), 2, *words)
        self.says_no(self.run_program(*physics, "--unit", "m"), 2, "no mesh is named")

    def searches(self, file):
        return list(csv.DictReader(self.read(file).decode().splitlines()))

    def plays_until(self, searches, *options):
        """A session of the scripted trainee, until so many searches are kept in me.csv."""
        physics = self.start("physics", "--rig", self.rig, "--app", "palpation", "--learning", "me.csv", *options)
        self.assertTrue(physics.says("answers graphics servers at"), physics.lines())
        graphics = self.start("graphics", "--rig", self.rig, "--player", "--seconds", "120")
        wait_until(lambda: len(self.searches("me.csv")) >= searches, f"{searches} searches are kept", 100)
        for process in (graphics, physics):
            process.send(signal.SIGTERM)
            self.assertEqual(process.ends().code, 0, process.lines())

    def test_what_is_learned_is_kept_over_sessions_and_shown(self):
        self.start_world()
        # Searches so short that nothing is found: the staircase goes down.
        settings = self.write("short.toml", QUICK + 'difficulty = "staircase"\nlevel = 4\ntrial_s = 5.0\npause_s = 0.2\n')
        self.plays_until(2, "--settings", settings, "--record", "first.mcap")
        first = self.searches("me.csv")
        self.assertEqual([(row["session"], row["trial"], row["level"], row["found"]) for row in first[:2]], [("1", "1", "4", "0"), ("1", "2", "2", "0")])
        self.plays_until(len(first) + 1, "--settings", settings)
        second = self.searches("me.csv")[len(first)]
        self.assertEqual((second["session"], second["trial"], second["level"]), ("2", "1", first[-1]["level"]))
        self.assertAlmostEqual(float(second["seconds"]), 5.0, delta=0.1)

        # Executed again it is the same session, and nobody has searched once more.
        kept = self.read("me.csv")
        self.runs("replay", "first.mcap", "--verify", "--json", "again.json")
        self.assertTrue(json.loads(self.read("again.json"))["same"])
        self.assertEqual(self.read("me.csv"), kept)

        told = json.loads(self.runs("study", "learning", "--file", "me.csv", "--quiet", "--out", "study", "--json", "-").out)
        self.assertEqual([session["session"] for session in told["sessions"]], [1, 2])
        self.assertEqual(told["sessions"][0]["found"], 0)
        self.assertGreater(told["sessions"][0]["found_share_interval"][1], 0.2)
        self.assertIn(b"Level, search by search", self.read("study", "report.html"))

    def test_a_file_that_is_none_of_searches_is_refused_and_left_alone(self):
        physics = ["physics", "--rig", self.rig, "--app", "palpation"]
        self.write("other.csv", "time_s,x_mm\n1,2\n")
        self.says_no(self.run_program(*physics, "--learning", "other.csv"), 2, "other.csv", "session")
        settings = self.write("other.toml", '[palpation]\nlearning_file = "other.csv"\n')
        self.says_no(self.run_program(*physics, "--settings", settings), 1, "other.csv", "session")
        self.assertEqual(self.read("other.csv"), b"time_s,x_mm\n1,2\n")
        self.says_no(self.run_program(*physics, "--learning", "gone/me.csv"), 1, "gone", "create it first")
        self.says_no(self.run_program("study", "learning"), 2, "--file", "--learning FILE")
        self.says_no(self.run_program("study", "learning", "--file", "other.csv"), 2, "other.csv", "session")

    def test_its_study_tells_what_must_come_out(self):
        self.assertIn("--late-ms", self.runs("study", "palpation", "--help").out)
        self.says_no(self.run_program("study", "palpation", "--trials", "3"), 2, "trials", "10")
        self.says_no(self.run_program("study", "palpation", "--late-ms", "soon"), 2, "--late-ms soon", "a number")
        done = self.runs("study", "palpation", "--quick", "--quiet", "--trials", "40", "--searches", "200", "--out", "study", "--json", "study.json")
        self.assertEqual(done.err, "")
        told = json.loads(self.read("study.json"))
        self.assertEqual({one["name"] for one in told["experiments"]} - {"matter"},
                         {"depth", "size", "ratio", "late", "sessions", "sense-off", "staircase", "felt-late"})
        self.assertTrue(told["bars"][0]["met"], told["bars"][0])
        self.assertIn(b"What must come out", self.read("study", "report.html"))
        again = self.runs("study", "psychometric", "--trials", "study/palpation_answers.csv", "--guess", "0.5", "--by", "experiment,cell", "--json", "-")
        self.assertIn("depth", again.out)


if __name__ == "__main__":
    unittest.main()
