#!/usr/bin/env python3
"""An arm of Haply's, by a service written from its public description: what the physics server makes of it."""
import json
import math
import random
import signal
import socket
import threading
import time
import tomllib
import unittest

from cartesian_arm_rig import CartesianArmTest
from haply_service import Service
from program import free_port, wait_until
from vrpn_words import COOKIE, POSE, named, posed


class Haply(CartesianArmTest):
    def setUp(self):
        super().setUp()
        self.service = Service()
        self.addCleanup(self.service.close)
        self.uri = f"haply:@127.0.0.1:{self.service.port}"

    def test_an_arm_that_nobody_has_checked_is_given_none_and_its_loss_is_told(self):
        physics = self.start_physics("--arm", self.uri, "--app", "touch", "--json", "physics.json")
        self.assertTrue(physics.says("forces stay off: nobody has seen"), physics.lines())
        self.assertTrue(any("Inverse3 049D" in line for line in physics.lines()), physics.lines())
        middle, _ = self.table()
        self.service.move(middle)
        before = self.service.newest()[1]
        wait_until(lambda: self.service.newest()[1] > before + 300, "the exchange goes on")
        self.service.present = False
        wait_until(lambda: any("the arm 049D has gone" in line for line in physics.lines()), "it is told")
        self.service.present = True
        wait_until(lambda: any("works again" in line for line in physics.lines()), "it comes back")
        self.stop(physics)
        self.assertTrue(all(force == (0, 0, 0) for force in self.service.forces))
        figures = json.loads(self.read("physics.json"))["arm"]
        self.assertEqual((figures["driver"], figures["id"]), ("haply", "049D"))
        self.assertEqual(figures["config"]["filters"]["force_gate"]["gain"], 0.3)
        self.assertGreater(figures["exchanges"], 300)
        self.assertGreater(figures["round_trip_us"], 0)

    def test_a_checked_one_is_pushed_out_of_what_it_touches_and_never_too_hard(self):
        self.mark_checked("haply inverse3 049D", "peak_n = 1.0")
        _, up = self.table()
        self.service.move(self.over_the_pad(0.30))
        physics = self.start_physics("--arm", self.uri, "--app", "touch")
        self.assertTrue(physics.says("forces stay below 1 N"), physics.lines())
        wait_until(lambda: self.condition() in ("ready", "running"), "forces are allowed")
        self.lower_through_the_pad(self.service.move, lambda _: sum(f * u for f, u in zip(self.service.newest()[0], up)) > 0.2)
        self.stop(physics)
        sizes = [sum(f * f for f in force) ** 0.5 for force in self.service.forces]
        self.assertLessEqual(max(sizes), 1.0 + 1e-6)
        wait_until(lambda: self.service.newest()[0] == (0, 0, 0), "nothing is left of it")

    def test_it_is_calibrated_with_a_tracker_of_others_from_the_first_sample_to_the_rig(self):
        """A hand holds the arm in forty poses before a tracker that speaks VRPN: from a new rig to one that puts the tip where it is."""
        draw = random.Random(7)
        strain = 0.01  # the arm believes itself a hundredth larger along x

        def stated(p):
            return (p[0] / (1 + strain), p[1], p[2])
        base = (0.1, -0.2, 0.3)
        poses = [tuple(draw.uniform(-0.06, 0.06) for _ in range(3)) for _ in range(40)]
        port, done = free_port(), threading.Event()
        self.write("arm.toml", 'name = "delta"\ntype = "cartesian"\nrange_mm = [[-70, 70], [-70, 70], [-70, 70]]\n')
        self.runs("rig", "new", "delta.rig.toml", "--arm", "arm.toml")
        sample = self.start("sample", "arm", "--arm", self.uri, "--tracker", f"vrpn://127.0.0.1:{port}", "--tracker-tool", "tip_marker=Stylus",
                            "--rig", "delta.rig.toml", "--still-s", "0.2", "--out", "samples")

        def hold():
            """The marker sits on the tip, and turns with every pose."""
            with socket.create_server(("127.0.0.1", port)) as server:
                server.settimeout(60)
                peer, _ = server.accept()
                peer.sendall(COOKIE + named(-2, 0, POSE) + named(-1, 0, "Stylus"))
                for pose in poses:
                    self.service.move(stated(pose))
                    turn = [draw.uniform(-0.4, 0.4) for _ in range(3)]
                    size = math.hypot(*turn)
                    turned = (*(math.sin(size / 2) / size * t for t in turn), math.cos(size / 2))
                    until = time.monotonic() + 0.5
                    while time.monotonic() < until:
                        seen = [b + p + draw.gauss(0, 2e-5) for b, p in zip(base, pose)]
                        peer.sendall(posed(0, 0, time.monotonic_ns() // 1000, 0, seen, turned))
                        time.sleep(0.005)
                done.set()
                peer.close()
        hand = threading.Thread(target=hold)
        hand.start()
        wait_until(done.is_set, "all poses are held")
        sample.send(signal.SIGINT)
        ended = sample.ends()
        self.assertEqual(ended.code, 0, ended)
        hand.join()
        header = self.read("samples", "arm.csv").decode().splitlines()[0]
        self.assertTrue(header.startswith("arm_x_mm,arm_y_mm,arm_z_mm,"), header)
        self.runs("calibrate", "arm", "--samples", "samples/arm.csv", "--rig", "delta.rig.toml", "--json", "arm.json")
        figures = json.loads(self.read("arm.json"))
        self.assertEqual(figures["arm"], "delta")
        self.assertGreaterEqual(figures["samples"], 30)
        self.assertLess(figures["test_mean_mm"], 0.1)
        arm = tomllib.loads(self.read("delta.rig.toml").decode())["arm"]
        self.assertAlmostEqual(arm["correction_mm"][0], 70 * strain, delta=0.1)  # strain_xx, at the range's end
        for found, true in zip(arm["base"]["translation_mm"], base):
            self.assertAlmostEqual(found, 1000 * true, delta=0.2)

    def test_what_is_not_there_is_refused_in_words(self):
        physics = ["physics", "--rig", self.rig, "--seconds", "1", "--arm"]
        self.says_no(self.run_program(*physics, "haply:0000@127.0.0.1:%d" % self.service.port), 1, "has no Inverse3 0000", "plug the arm in")
        self.service.basis = "XZY"
        self.says_no(self.run_program(*physics, self.uri), 1, "keeps the axes XZY", "end other programs")
        self.service.close()
        self.says_no(self.run_program(*physics, self.uri), 1, "check that the service runs")
        self.says_no(self.run_program(*physics, "haply:"), 2, "--arm", "haply or haply:ID[@HOST:PORT]")


if __name__ == "__main__":
    unittest.main()
