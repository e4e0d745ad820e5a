#!/usr/bin/env python3
"""A physics server that means ill, as they meet it: scenes that name files, statuses that are none, and an attack while one is to end."""
import ctypes
import os
import signal
import time
import unittest

from believing import BelievingTest
from fake_server import ON_A_LINK, FakeServer, odd_status, odd_words, refusals, unasked
from program import free_port

SAYS_AGAIN_S = 10.0  # that a server refuses


class HostileWords(BelievingTest):
    def opened(self, path):
        """A question: has the file been opened meanwhile?"""
        libc = ctypes.CDLL(None, use_errno=True)
        watch = libc.inotify_init1(os.O_NONBLOCK)
        self.addCleanup(os.close, watch)
        self.assertGreaterEqual(libc.inotify_add_watch(watch, path.encode(), 0x20), 0)  # IN_OPEN

        def asked():
            try:
                return bool(os.read(watch, 4096))
            except BlockingIOError:
                return False
        return asked

    def test_scenes_name_no_files_that_are_none_and_over_a_network_none_at_all(self):
        self.start_world()
        scene, state = self.learn("--app", "touch")
        os.mkfifo(self.path("pipe.stl"))
        os.mkdir(self.path("folder"))
        self.write("solid.stl", "solid x\nendsolid x\n")
        watched = self.opened(self.path("solid.stl"))
        names = ["/etc/passwd", "../../../../../../etc/passwd", "/dev/zero", "/proc/self/mem", self.path("pipe.stl"), self.path("folder"), "x" * 512]
        running = []

        def start(name, network):
            server = FakeServer(self.wire, os.path.join(self.root, f"{len(running)}.sock"), self.wire.SceneDescription(), state)
            server.scene.CopyFrom(scene)
            server.scene.mesh.CopyFrom(self.wire.MeshAsset(file=name, hash="0" * 16, metres_per_unit=1e-3))
            address = f"tcp://127.0.0.1:{free_port()}" if network else f"ipc://{server.path}"
            self.addCleanup(server.start(address).stop)
            running.append((network, self.start("graphics", "--rig", self.rig, "--connect", address, *["--insecure"] * network)))
            return running[-1][1]
        for network in (True, False):
            start(self.path("solid.stl"), network).ends()
            self.assertEqual(watched(), not network)
        for name in names:
            for network in (True, False):
                start(name, network)
        for network, graphics in running:
            done = graphics.ends()
            lines = [line for line in done.lines if "neither encrypted nor guarded" not in line]
            self.assertIn(done.code, (1, 2), done)
            self.assertEqual(len(lines), 1, done)
            self.nothing_odd(done.err)
            if network:
                self.assertIn("copy it to this machine", lines[0])

    def test_status_ends_in_a_view_or_in_one_line_whatever_it_is_told(self):
        commands, running = (["--once"], ["--json", "-"], ["--reset"], []), []
        for attack in (*ON_A_LINK.values(), odd_words):
            for command in commands if attack in (odd_status, odd_words, unasked, refusals) else commands[:1]:
                server = FakeServer(self.wire, os.path.join(self.root, f"{len(running)}.sock"), self.wire.SceneDescription(), self.wire.WorldState())
                server.scene.gravity_m_per_s2.extend([0.0, 0.0, 0.0])
                server.scene.carried_offset_m.extend([0.0, 0.0, 0.0])
                server.attack = attack
                self.addCleanup(server.start().stop)
                running.append((attack.__name__, command, self.start("status", *command, "--connect", f"ipc://{server.path}")))
        time.sleep(2.0)  # of a live view
        for name, command, status in running:
            if not command:
                status.send(signal.SIGTERM)
            done = status.ends()
            with self.subTest(attack=name, command=command):
                self.assertIn(done.code, (0, 1), done)
                self.assertEqual(len(done.lines), done.code, done)
                self.assertLess(len(done.out), 1 << 20)
                self.nothing_odd(done.err + done.out)
                self.assertLess(max(map(len, done.out.splitlines()), default=0), 2000 if "--json" not in command else 1 << 20)

    def test_it_ends_when_told_to_during_an_attack(self):
        self.start_world()
        for name in ("nothing", "shapes_by_the_hundred", "old_states", "refusals"):
            graphics, server = self.begins("--picture-time", "predicted")
            begun = time.monotonic()
            server.attack = ON_A_LINK[name]
            self.goes_on(graphics, server)
            done = self.ends_at_once(graphics)
            told = sum("refuses: " in line for line in done.lines)  # refusals in other words each time
            self.assertLessEqual(told, 1 + (time.monotonic() - begun) // SAYS_AGAIN_S, done)
            self.assertEqual(told > 0, name == "refusals", done)
            server.stop()

if __name__ == "__main__":
    unittest.main()
