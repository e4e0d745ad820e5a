#!/usr/bin/env python3
"""palpate status: a running system as a person and a program see it."""
import csv
import json
import threading
import time
import unittest

import zmq

from laboratory import LaboratoryTest
from program import wait_until


class Status(LaboratoryTest):
    def test_without_a_server_it_says_so(self):
        self.refuses(["status", "--connect", f"ipc://{self.root}/nobody.sock"], 1, "no physics server answers", "palpate physics")

    def test_loops_clients_and_exchange_of_a_running_system_are_shown(self):
        world, physics = self.start_world(), self.start_physics()
        # Its clock pretends to be 5 s ahead: that of the server is then 5 s behind.
        graphics = self.start_graphics("--disguise-offset-s", "5", "--out", "logs")
        seen = {}

        def screen():
            nonlocal seen
            seen = json.loads(self.runs("status", "--json", "-").out)
            return any(c["name"] == "graphics" and c["frames"] > 5 for c in seen["clients"])
        wait_until(screen, "the graphics server tells how it is doing")
        self.assertEqual([loop["name"] for loop in seen["loops"]], ["haptic", "physics"])
        for loop in seen["loops"]:
            self.assertGreater(loop["ticks"], 0)
            self.assertGreater(sum(loop["late_octaves_from_16_ns"]), 0)
            self.assertLessEqual(loop["late_us"]["p50"], loop["late_us"]["p99"])
        # On a busy machine the laboratory may stand still for milliseconds: forces are degraded then.
        self.assertIn(seen["loops"][0]["condition"].split(":")[0], ["ready", "running", "degraded"])
        self.assertEqual(seen["loops"][1]["condition"], "")
        shown = next(c for c in seen["clients"] if c["name"] == "graphics")
        self.assertEqual(shown["role"], "operator")
        self.assertGreater(shown["round_trip_us"]["median"], 0)
        self.assertAlmostEqual(shown["clock_offset_s"], -5.0, delta=0.1)  # one machine, one clock
        self.assertGreater(shown["clock_uncertainty_us"], 0)
        self.assertGreater(seen["service"]["requests"], 0)
        view = self.runs("status", "--once").out
        for words in ("pingpong at ipc://", "haptic loop", "forces ", "overruns", "under", "graphics     operator", "round trip", "states answered"):
            self.assertIn(words, view)
        self.assertRegex(view, r"clock -(5\.0|4\.9)\d+ s \+- ")
        self.assertNotIn("\x1b", view)
        self.assertEqual(self.runs("status").out.count(" at ipc://"), 1, "into a pipe goes one view")
        self.assertEqual(self.stop_in_order(graphics, physics, world), [[], [], []])
        # What it told meanwhile, beside its own log of each frame: a moment's count is that of some moment of the log.
        rows = list(csv.DictReader(self.read("logs", "realtime_frames.csv").decode().splitlines()))
        self.assertLessEqual(shown["frames"], len(rows))
        self.assertEqual(shown["late"], sum(int(row["late"]) for row in rows[:shown["frames"]]))
        # A picture counts once it is drawn, and may be held for some milliseconds before it is shown. The one
        # before it had been shown by then.
        since = float(rows[shown["frames"] - 2]["time_s"])
        self.assertLessEqual(shown["rate_hz"], 1.001 * shown["frames"] / since)
        self.assertGreater(shown["rate_hz"], 0)

    def test_a_reset_waits_for_what_its_key_may_do(self):
        """A server that tells how it is doing before it answers the first hello."""
        wire = self.wire_messages()
        socket = zmq.Context.instance().socket(zmq.ROUTER)
        self.addCleanup(socket.close, 0)
        socket.bind(f"ipc://{self.root}/slow.sock")
        over, wishes, told, silent = threading.Event(), [], [], False

        def answer(message):
            said = message.WhichOneof("body")
            if said == "status_request":
                told.append(time.monotonic())
                return wire.ToGraphics(protocol=2, status_reply=wire.StatusReply(
                    number=message.status_request.number, uptime_s=len(told), application="touch", controls=len(wishes)))
            if said == "hello" and len(told) >= 2 and not silent:
                return wire.ToGraphics(protocol=2, welcome=wire.Welcome(
                    session=7, role=wire.ROLE_OPERATOR, scene=wire.SceneDescription(application="touch", gravity_m_per_s2=[0, 0, -9.81], carried_offset_m=[0, 0, 0])))
            if said == "control_call":
                wishes.append(message.control_call.control)
                return wire.ToGraphics(protocol=2, control_reply=wire.ControlReply(number=message.control_call.number))
            return None

        def serve():
            while not over.is_set():
                if socket.poll(20):
                    peer, body = socket.recv_multipart()
                    if reply := answer(wire.ToPhysics.FromString(body)):
                        socket.send_multipart([peer, reply.SerializeToString()])
        server = threading.Thread(target=serve)
        server.start()
        try:
            view = self.runs("status", "--reset", "--connect", f"ipc://{self.root}/slow.sock").out
            silent = True
            self.refuses(["status", "--reset", "--connect", f"ipc://{self.root}/slow.sock"], 1, "has not said within 5 s what this machine's key may do")
        finally:
            over.set()
            server.join()
        self.assertIn("1 controls", view)
        self.assertEqual(set(wishes), {wire.CONTROL_RESET})


if __name__ == "__main__":
    unittest.main()
