#!/usr/bin/env python3
"""The application touch as a user meets it."""
import json
import unittest

from laboratory import LaboratoryTest

CUBE = """v 0 0 0\nv 60 0 0\nv 60 40 0\nv 0 40 0\nv 0 0 50\nv 60 0 50\nv 60 40 50\nv 0 40 50
f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 3 4 8 7\nf 1 5 8 4\nf 2 3 7 6\n"""


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

    def test_a_mesh_is_felt_and_shown_and_a_changed_file_is_noticed(self):
        mesh = self.write("cube.obj", CUBE)
        self.start_world()
        physics = self.start("physics", "--rig", self.rig, "--app", "touch", "--mesh", mesh, "--material", "soft-tissue")
        self.assertTrue(physics.says("12 triangles, 60 x 40 x 50 mm; 1 part, closed"), physics.lines())
        self.assertTrue(physics.says("answers graphics servers at"), physics.lines())
        graphics = self.start("graphics", "--rig", self.rig, "--player", "--seconds", "4", "--json", "shown.json")
        self.assertEqual(graphics.ends().code, 0, graphics.lines())
        self.assertGreater(json.loads(self.read("shown.json"))["exchange"]["frames"], 10)
        other = self.write("other.obj", CUBE.replace("50", "51"))
        self.says_no(self.run_program("graphics", "--rig", self.rig, "--mesh", other), 1, "is not the mesh that the physics server uses")

    def test_a_mesh_that_cannot_be_is_refused_with_the_remedy(self):
        mesh = self.write("cube.obj", CUBE)
        physics = ["physics", "--rig", self.rig, "--app", "touch"]
        self.says_no(self.run_program(*physics, "--mesh", mesh, "--unit", "m"), 2, "60000 x 40000 x 50000 mm", "5 to 500 mm", "--unit")
        self.says_no(self.run_program(*physics, "--mesh", self.write("words.obj", "no mesh at all")), 2, "is no mesh")
        self.says_no(self.run_program(*physics, "--mesh", "missing.stl"), 2, "missing.stl")
        self.says_no(self.run_program(*physics, "--unit", "m"), 2, "no mesh is named")
        self.says_no(self.run_program("physics", "--rig", self.rig, "--mesh", mesh), 2, "pingpong has no such option", "--app touch")
        self.says_no(self.run_program(*physics, "--material", "steel"), 2, "--material steel", "plain or bone or soft-tissue")
        world = self.write("soft.toml", "[touch]\nfriction = 0.5\nstatic_friction = 0.2\n")
        self.says_no(self.run_program(*physics, "--world", world), 2, "static_friction", "at least friction")
        self.says_no(self.run_program(*physics, "--world", self.write("stiff.toml", "[touch]\nstiffness_n_m = 5000\n")), 2, "stiffness_n_m", "800")

    def test_in_lockstep_the_mesh_is_read_too(self):
        lockstep = ["lockstep", "--app", "touch", "--seconds", "4", "--quiet"]
        self.says_no(self.run_program(*lockstep, "--mesh", "none.stl"), 2, "none.stl")
        self.runs(*lockstep, "--json", "organ.json")
        self.runs(*lockstep, "--mesh", self.write("cube.obj", CUBE), "--json", "cube.json")
        organ, cube = (json.loads(self.read(name))["force"]["peak_n"] for name in ("organ.json", "cube.json"))
        self.assertNotEqual(organ, cube)

    def test_settings_come_from_a_file_of_their_own_and_go_over_the_world_files(self):
        mesh = self.write("cube.obj", CUBE)
        self.start_world()
        world = self.write("soft.toml", "[touch]\nmesh = \"missing.stl\"\nunit = \"m\"\n")
        settings = self.write("mine.toml", "[touch]\nmesh = \"cube.obj\"\nunit = \"mm\"\nscale = 2.0\n")
        physics = self.start("physics", "--rig", self.rig, "--app", "touch", "--world", world, "--settings", settings)
        self.assertTrue(physics.says("cube.obj: 12 triangles, 120 x 80 x 100 mm"), physics.lines())
        self.assertTrue(physics.says("answers graphics servers at"), physics.lines())
        # An option goes over both.
        self.says_no(self.run_program("physics", "--rig", self.rig, "--app", "touch", "--settings", settings, "--mesh", mesh, "--unit", "m"), 2, "120000 x")
        for text, words in (("[touch]\nscal = 2.0\n", ("mine.toml:2", "scal")), ("[touch]\n\nscale = -1\n", ("mine.toml:3", "touch.scale")),
                            ("[camera]\nfx = 500.0\n", ("mine.toml:1", "camera")), ("[touch]\nstatic_friction = 0.1\n", ("mine.toml:2", "at least friction"))):
            self.says_no(self.run_program("physics", "--rig", self.rig, "--app", "touch", "--settings", self.write("mine.toml", text)), 2, *words)
        self.says_no(self.run_program("physics", "--rig", self.rig, "--settings", "nowhere.toml"), 2, "nowhere.toml")


if __name__ == "__main__":
    unittest.main()
