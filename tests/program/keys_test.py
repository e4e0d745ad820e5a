#!/usr/bin/env python3
"""Keys, and the servers that need them: two machines, each with its own folder of keys, over an encrypted connection."""
import json
import os
import unittest

from laboratory import LaboratoryTest
from program import free_port, wait_until


class Keys(LaboratoryTest):
    def setUp(self):
        super().setUp()
        self.here, self.there = self.path("here"), self.path("there")
        self.address = f"tcp://127.0.0.1:{free_port()}"

    def key(self, folder):
        return json.loads(self.runs("keys", "show", "--keys", folder, "--json", "-").out)["public_key"]

    def test_what_the_command_makes_is_private_and_replaced_only_when_asked(self):
        self.assertIn("keys authorize", self.runs("keys", "new", "--keys", self.here).out)
        self.assertEqual(os.stat(os.path.join(self.here, "secret_key")).st_mode & 0o777, 0o600)
        before = self.key(self.here)
        self.refuses(["keys", "new", "--keys", self.here], 1, "--force")
        self.assertEqual(self.key(self.here), before)
        self.runs("keys", "new", "--force", "--keys", self.here)
        self.assertNotEqual(self.key(self.here), before)
        with open(os.path.join(self.here, "secret_key"), encoding="ascii") as file:
            secret = file.read().split()[-1]
        self.assertNotIn(secret, self.runs("keys", "show", "--keys", self.here).out)

    def test_without_a_folder_named_keys_lie_where_settings_do(self):
        self.runs("keys", "new")
        self.assertTrue(os.path.isfile(os.path.join(self.environment["XDG_CONFIG_HOME"], "palpate", "secret_key")))

    def test_wrong_keys_roles_and_names_are_refused(self):
        self.runs("keys", "new", "--keys", self.here)
        key = self.key(self.here)
        self.refuses(["keys", "authorize", "nonsense", "--keys", self.here], 2, "nonsense", "40 characters")
        self.refuses(["keys", "authorize", key, "--role", "king", "--keys", self.here], 2, "king", "observer, graphics or operator")
        self.refuses(["keys", "authorize", key, "--name", "two\nlines", "--keys", self.here], 2, "--name")
        self.refuses(["keys", "revoke", "nobody", "--keys", self.here], 1, "nobody")
        self.refuses(["keys", "trust", f"ipc://{self.folder}/x", key, "--keys", self.here], 2, "only tcp://")
        self.refuses(["keys", "trust", "tcp://host:1", "short", "--keys", self.here], 2, "short")

    def test_a_server_or_client_without_keys_says_what_to_do(self):
        self.says_no(self.run_program("physics", "--rig", self.rig, "--listen", self.address, "--keys", self.here), 1, "palpate keys new")
        self.says_no(self.run_program("graphics", "--rig", self.rig, "--connect", self.address, "--keys", self.here), 1, "palpate keys new")
        self.runs("keys", "new", "--keys", self.here)
        self.says_no(self.run_program("graphics", "--rig", self.rig, "--connect", self.address, "--keys", self.here), 1, f"palpate keys trust {self.address}")

    def test_two_machines_that_know_each_other_play_and_a_revoked_one_is_turned_away(self):
        for folder in (self.here, self.there):
            self.runs("keys", "new", "--keys", folder)
        self.runs("keys", "authorize", self.key(self.there), "--role", "graphics", "--name", "screen", "--keys", self.here)
        self.runs("keys", "trust", self.address, self.key(self.here), "--keys", self.there)
        world = self.start_world()
        physics = self.start_physics("--listen", self.address, "--keys", self.here)
        graphics = self.runs("graphics", "--rig", self.rig, "--connect", self.address, "--keys", self.there, "--seconds", "1.5", "--json", "figures.json")
        self.assertGreater(json.loads(self.read("figures.json"))["sync"]["exchanges"], 0, graphics)
        self.runs("keys", "revoke", "screen", "--keys", self.here)
        turned_away = None

        def refused():  # the list is looked at twice a second
            nonlocal turned_away
            turned_away = self.run_program("graphics", "--rig", self.rig, "--connect", self.address, "--keys", self.there, "--seconds", "0.2")
            return "turns us away" in turned_away.err
        wait_until(refused, "the revoked key is turned away")
        self.says_no(turned_away, 1, "turns us away", "palpate keys authorize")
        said = self.stop_in_order(physics, world)
        self.assertTrue(any("key of this server " + self.key(self.here) in line for line in said[0]), said)

    def test_insecure_warns_on_both_sides(self):
        world = self.start_world()
        physics = self.start_physics("--listen", self.address, "--insecure")
        graphics = self.runs("graphics", "--rig", self.rig, "--connect", self.address, "--insecure", "--seconds", "1")
        self.assertTrue(any("warning" in line and self.address in line for line in graphics.lines), graphics)
        said = self.stop_in_order(physics, world)
        self.assertTrue(any("neither encrypted nor guarded" in line for line in said[0]), said)


if __name__ == "__main__":
    unittest.main()
