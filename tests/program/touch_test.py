#!/usr/bin/env python3
"""The application touch as a user meets it."""
import json
import unittest

from laboratory import LaboratoryTest


class Touch(LaboratoryTest):
    def test_it_is_listed_and_served(self):
        self.assertIn("touch", self.runs("apps").out)
        self.start_world()
        physics = self.start("physics", "--rig", self.rig, "--app", "touch", "--seconds", "2", "--json", "figures.json")
        self.assertTrue(physics.says("answers graphics servers at"), physics.lines())
        self.assertEqual(physics.ends().code, 0)
        figures = json.loads(self.read("figures.json"))
        self.assertGreater(figures["physics"]["ticks"], 500)
        self.assertEqual(figures["force"]["blows"], 0)

    def test_a_demo_without_a_player_is_refused_at_once(self):
        self.says_no(self.run_program("demo", "--app", "touch", "--headless"), 1, "touch has no scripted player yet", "palpate physics --app touch")


if __name__ == "__main__":
    unittest.main()
