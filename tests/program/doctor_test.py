#!/usr/bin/env python3
"""palpate doctor: what it says of a machine whose folders, keys and servers are ours to arrange. Rights, drawing and clocks are
as the machine that runs the tests has them."""
import json
import os
import shutil
import socket
import unittest

from laboratory import LaboratoryTest
from program import free_port, wait_until

VERDICTS = ("ok", "worth knowing", "in the way")


class Doctor(LaboratoryTest):
    def setUp(self):
        super().setUp()
        self.keys = self.path("keys")

    def look(self, *options):
        """The findings, having checked what holds of any."""
        before = self.files()
        keys = () if "--keys" in options else ("--keys", self.keys)
        done = self.run_program("doctor", "--json", "-", *keys, *options)
        self.assertEqual(self.files(), before, "changes nothing")
        result = json.loads(done.out)
        found = result["findings"]
        for finding in found:
            self.assertEqual(sorted(finding), ["area", "name", "remedy", "value", "verdict"])
            self.assertIn(finding["verdict"], VERDICTS)
            self.assertEqual(finding["verdict"] == "ok", finding["remedy"] == "", finding)
        blocked = [f for f in found if f["verdict"] == "in the way"]
        self.assertEqual(result["in_the_way"], len(blocked))
        self.assertEqual(done.code, 1 if blocked else 0, done)
        if blocked:
            for finding in blocked:
                self.assertIn(f"{finding['area']} {finding['name']}", done.lines[-1])
        return found

    def about(self, found, area, name):
        return next(f for f in found if (f["area"], f["name"]) == (area, name))

    def verdict(self, found, area, name):
        return self.about(found, area, name)["verdict"]

    def finds(self, words, area, name, *options):
        """What a busy machine may say late: a server answers when it is its turn."""
        wait_until(lambda: words in self.about(self.look(*options), area, name)["value"], f"doctor finds '{words}'")

    def key(self, folder):
        return json.loads(self.runs("keys", "show", "--keys", folder, "--json", "-").out)["public_key"]

    def test_the_version_names_commit_and_compiler(self):
        said = self.runs("--version").out.strip()
        self.assertRegex(said, r"^palpate \d+\.\d+\.\d+ \(([0-9a-f]{7,}(-dirty)?|commit not known), (Clang|GNU) [\d.]+.*\)$")
        self.assertIn(said.removeprefix("palpate "), self.about(self.look(), "libraries", "palpate")["value"])

    def test_every_area_has_its_lines_and_nothing_is_left_behind(self):
        found = self.look()
        areas = {finding["area"] for finding in found}
        self.assertEqual(areas, {"real time", "clock", "sockets", "keys", "graphics", "desktop", "libraries", "devices", "space"})
        self.assertEqual(os.listdir(self.meeting), [])
        self.assertFalse(os.path.exists(self.keys))
        lines = self.run_program("doctor", "--keys", self.keys, "--json", "findings.json").out.splitlines()
        self.assertEqual(len(lines), len(found))
        self.assertEqual(len(json.loads(self.read("findings.json"))["findings"]), len(found))
        self.assertTrue(all(line.startswith(VERDICTS) for line in lines), lines)

    def test_run_folder_open_to_others_and_a_dead_servers_socket(self):
        place = os.path.join(self.meeting, "palpate")
        os.mkdir(place, 0o700)
        with socket.socket(socket.AF_UNIX) as dead:
            dead.bind(os.path.join(place, "physics.sock"))
        found = self.look()
        self.assertEqual(self.verdict(found, "sockets", "run folder"), "ok")
        self.assertIn("physics.sock", self.about(found, "sockets", "leftovers")["value"])
        self.assertEqual(os.listdir(place), ["physics.sock"])
        os.chmod(place, 0o755)
        self.assertEqual(self.verdict(self.look(), "sockets", "run folder"), "in the way")

    def test_something_that_listens_and_does_not_answer_is_in_the_way(self):
        place = os.path.join(self.meeting, "palpate")
        os.mkdir(place, 0o700)
        with socket.socket(socket.AF_UNIX) as stranger:
            stranger.bind(os.path.join(place, "physics.sock"))
            stranger.listen(8)
            self.assertEqual(self.verdict(self.look(), "sockets", "physics server"), "in the way")

    def test_keys_missing_spoilt_and_open_to_others(self):
        address = f"tcp://127.0.0.1:{free_port()}"
        self.assertEqual(self.verdict(self.look(), "keys", "pair"), "ok")
        found = self.look("--listen", address)
        self.assertEqual(self.verdict(found, "keys", "pair"), "in the way")
        self.assertIn("palpate keys new", self.about(found, "keys", "pair")["remedy"])
        self.runs("keys", "new", "--keys", self.keys)
        found = self.look("--listen", address)
        self.assertEqual(self.verdict(found, "keys", "pair"), "ok")
        self.assertIn(self.key(self.keys), self.about(found, "keys", "pair")["value"])
        self.assertEqual(self.verdict(found, "keys", "admitted"), "worth knowing")
        self.assertEqual(self.verdict(found, "listen", address), "ok")
        self.runs("keys", "authorize", self.key(self.keys), "--role", "operator", "--keys", self.keys)
        with open(os.path.join(self.keys, "authorized_keys"), "a", encoding="ascii") as file:
            file.write("king nobody\n")
        found = self.look()
        self.assertIn("1 as operator", self.about(found, "keys", "admitted")["value"])
        self.assertIn("'king' is no role", self.about(found, "keys", "line")["value"])
        os.chmod(os.path.join(self.keys, "secret_key"), 0o644)
        os.chmod(os.path.join(self.keys, "authorized_keys"), 0o666)
        found = self.look()
        self.assertIn("chmod 600", self.about(found, "keys", "pair")["remedy"])
        self.assertEqual(self.verdict(found, "keys", "pair"), "in the way")
        self.assertEqual(self.verdict(found, "keys", "admitted"), "in the way")

    def test_a_physics_server_is_found_at_the_default_address_and_at_its_own(self):
        self.runs("keys", "new", "--keys", self.keys)
        address = f"tcp://127.0.0.1:{free_port()}"
        self.start_world()
        local = self.start_physics()
        self.finds("answers at", "sockets", "physics server")
        self.finds("open: lab", "sockets", "laboratory")
        self.stop_in_order(local)
        self.start_physics("--listen", address, "--keys", self.keys)
        self.finds("with the key of this machine listens", "listen", address, "--listen", address)
        client = self.path("client")
        self.runs("keys", "new", "--keys", client)
        self.runs("keys", "trust", address, self.key(self.keys), "--keys", client)
        at_client = ("keys", "server", "--keys", client)
        self.finds("does not admit", *at_client)
        self.runs("keys", "authorize", self.key(client), "--role", "observer", "--keys", self.keys)
        self.finds("lets us be observer", *at_client)
        self.runs("keys", "trust", address, self.key(client), "--keys", client)
        self.finds("another key", *at_client)
        shutil.rmtree(self.keys)
        self.runs("keys", "new", "--keys", self.keys)
        self.assertEqual(self.verdict(self.look("--listen", address), "listen", address), "in the way")

    def test_an_address_that_is_none_is_wrong_use_and_one_not_ours_in_the_way(self):
        self.refuses(["doctor", "--listen", "physics"], 2, "not an address")
        self.refuses(["doctor", "--listen", "tcp://host"], 2, "tcp://HOST:PORT")
        self.assertEqual(self.verdict(self.look("--listen", "tcp://192.0.2.1:5555"), "listen", "tcp://192.0.2.1:5555"), "in the way")
        self.assertEqual(self.verdict(self.look("--listen", "ipc:///tmp/x.sock"), "listen", "ipc:///tmp/x.sock"), "in the way")


if __name__ == "__main__":
    unittest.main()
