#!/usr/bin/env python3
"""Servers that find no peer, or their address taken; and how they end when asked to."""
import json
import os
import re
import signal
import socket
import unittest

from laboratory import READY, UNPROTECTED, LaboratoryTest


class Servers(LaboratoryTest):
    def test_without_a_laboratory_no_server_starts(self):
        for command in ("physics", "graphics"):
            self.says_no(self.run_program(command, "--rig", self.rig, "--lab", "nowhere"), 1, "laboratory 'nowhere' is not there", "palpate world run")
        self.says_no(self.run_program("physics", "--rig", self.rig, "--lab", "../up"), 2, "'../up'", "letters, digits")

    def test_graphics_without_a_physics_server_gives_up_and_names_the_remedy(self):
        world = self.start_world()
        self.says_no(self.run_program("graphics", "--rig", self.rig, "--wait-s", "2"), 1, "no physics server answers at ipc://", "after 2 s", "start `palpate physics` first")
        self.assertEqual(self.stop_in_order(world), [[]])

    def test_graphics_can_be_stopped_while_it_waits_for_a_physics_server(self):
        self.start_world()
        graphics = self.start("graphics", "--rig", self.rig)
        self.catches(graphics, signal.SIGINT)
        graphics.send(signal.SIGINT)
        self.says_no(graphics.ends(), 1, "stopped before the physics server answered")

    def rig_with_table(self, name, change):
        """A copy of the rig whose table lies elsewhere: `change` of its first corner, or of its name, as the file has them."""
        text = self.read("rig.toml").decode()
        table = next(part for part in text.split("[[surface]]") if 'name = "table"' in part)
        return self.write(name, text.replace(table, change(table)))

    def rig_moved_by(self, mm):
        def moved(table):
            corner = re.search(r"corner_mm = \[([^\]]*)\]", table)
            x, y, z = (float(number) for number in corner.group(1).split(","))
            return table.replace(corner.group(0), f"corner_mm = [{x + mm}, {y}, {z}]")
        return self.rig_with_table(f"moved_by_{mm}.toml", moved)

    def rig_of_arm_longer_by(self, mm):
        """A copy of the rig whose arm, as calibrated, has a longer first link: by sin(0.5 rad) of it the tip is elsewhere."""
        before, part, after = self.read("rig.toml").decode().partition("\n[arm]\n")
        first, second = (float(number) for number in re.search(r"lengths_mm = \[([^\]]*)\]", after).group(1).split(","))
        return self.write(f"longer_by_{mm}.toml", before + part + re.sub(r"lengths_mm = \[[^\]]*\]", f"lengths_mm = [{first + mm}, {second}]", after, count=1))

    def test_graphics_with_another_rig_than_physics_is_refused_or_warned(self):
        self.start_world()
        self.start_physics()
        self.says_no(self.run_program("graphics", "--rig", self.rig_moved_by(300)), 1, "has another rig", "'table' lies 300 mm from where it lies here", "both servers need the same rig file")
        for rig, words in ((self.rig_moved_by(5), "'table' lies 5 mm"), (self.rig_with_table("desk.toml", lambda table: table.replace('"table"', '"desk"')), "'desk' is missing there, 'table' is missing here")):
            graphics = self.start("graphics", "--rig", rig)
            self.assertTrue(graphics.says(READY["graphics"]), graphics.lines())
            self.assertTrue(graphics.says(words + " from where it lies here; both servers need the same rig file" if "mm" in words else words), graphics.lines())
            self.stop_in_order(graphics)
        self.says_no(self.run_program("graphics", "--rig", self.rig_of_arm_longer_by(60)), 1, "has another rig", "put the tip 29 mm from where they do here")
        graphics = self.start("graphics", "--rig", self.rig_of_arm_longer_by(6))
        self.assertTrue(graphics.says("equal readings of the arm put the tip 3 mm from where they do here; both servers need the same rig file"), graphics.lines())
        self.stop_in_order(graphics)
        graphics = self.start_graphics()
        self.assertEqual(self.stop_in_order(graphics), [[]])

    def test_addresses_that_are_none_are_wrong_use(self):
        for command, option, address, words in (("physics", "--listen", "nonsense", "not an address"),
                                                ("graphics", "--connect", "tcp://localhost:99999", "a port from 1 to 65535"),
                                                ("graphics", "--connect", "udp://localhost:1", "expected ipc://PATH or tcp://HOST:PORT")):
            with self.subTest(address):
                self.says_no(self.run_program(command, "--rig", self.rig, option, address), 2, address, words)

    def test_a_second_laboratory_of_the_same_name_is_refused_and_the_first_goes_on(self):
        world = self.start_world()
        self.says_no(self.run_program("world", "run"), 1, "laboratory 'lab'", "address in use", "choose another name")
        other = self.start_world("--name", "other")
        self.assertEqual(self.stop_in_order(other, world), [[], []])
        self.assertEqual(self.left_behind(), [])

    def test_a_second_physics_server_is_refused_and_the_first_goes_on(self):
        world, physics, other = self.start_world(), self.start_physics(), self.start_world("--name", "other")
        self.says_no(self.run_program("physics", "--rig", self.rig), 1, "arm of laboratory 'lab'", "held by process", "stop it first")
        self.says_no(self.run_program("physics", "--rig", self.rig, "--lab", "other"), 1, "physics.sock", f"address in use by process {physics.process.pid}", "listen at another")
        self.assertEqual(self.stop_in_order(physics, world, other), [[], [], []])
        self.assertEqual(self.left_behind(), [])

    def test_an_address_that_another_program_has_is_refused(self):
        self.start_world()
        place = os.path.join(self.meeting, "palpate", "physics.sock")
        with socket.socket(socket.AF_UNIX) as unix, socket.socket() as tcp:
            unix.bind(place)
            unix.listen()
            tcp.bind(("127.0.0.1", 0))
            tcp.listen()
            self.says_no(self.run_program("physics", "--rig", self.rig), 1, place, "address in use")
            self.assertTrue(os.path.exists(place))
            address = f"tcp://127.0.0.1:{tcp.getsockname()[1]}"
            self.says_no(self.run_program("physics", "--rig", self.rig, "--insecure", "--listen", address), 1, address, "in use")
        os.remove(place)
        with open(place, "w", encoding="ascii") as file:
            file.write("letters of somebody")
        self.says_no(self.run_program("physics", "--rig", self.rig), 1, place, "is not a socket", "remove it")
        self.assertEqual(os.path.getsize(place), 19)

    def test_each_ends_in_order_at_ctrl_c_and_leaves_nothing_behind(self):  # killed_peers_test.py does so at SIGTERM
        world, physics, graphics = self.start_all()
        self.assertEqual(self.stop_in_order(graphics, physics, world, number=signal.SIGINT), [[], [], []])
        self.assertEqual(self.left_behind(), [])

    def test_figures_that_find_no_place_are_told_at_the_end(self):
        self.start_world()
        physics = self.start_physics("--seconds", "0.1", "--json", "/dev/full")
        done = physics.ends()
        self.assertEqual((done.code, done.out), (1, ""), done)
        self.assertIn("/dev/full", done.lines[-1])
        self.assertEqual(len([line for line in done.lines if UNPROTECTED not in line]), 2, done)

    def test_figures_whose_reader_stops_reading_keep_no_server_that_is_to_end(self):
        os.mkfifo(self.path("pipe"))
        reader = os.open(self.path("pipe"), os.O_RDONLY | os.O_NONBLOCK)
        self.addCleanup(os.close, reader)
        writer = os.open(self.path("pipe"), os.O_WRONLY | os.O_NONBLOCK)
        self.addCleanup(os.close, writer)
        with self.assertRaises(BlockingIOError):
            while True:
                os.write(writer, bytes(1))  # until nothing more fits
        self.start_world("--arm-only")
        physics = self.start_physics("--json", "pipe")
        physics.send(signal.SIGTERM)
        done = physics.ends()
        self.assertEqual(done.code, 1, done)
        self.assertIn("its reader takes nothing any more", done.lines[-1])

    def test_forces_that_load_can_delay_are_told_at_the_start(self):
        self.start_world()
        physics = self.start_physics("--seconds", "0.1", "--json", "figures.json")
        done = physics.ends()
        granted = json.loads(self.read("figures.json"))["haptic"]["scheduling"].startswith("SCHED_FIFO")
        self.assertEqual(any(UNPROTECTED in line for line in done.lines), not granted, done)


if __name__ == "__main__":
    unittest.main()
