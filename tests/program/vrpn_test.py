#!/usr/bin/env python3
"""Trackers over VRPN: against a peer of the same protocol, written from its public description and sharing nothing with the
program."""
import json
import math
import os
import re
import socket
import struct
import threading
import unittest

from poses_by_network import PosesByNetworkTest
from program import free_port, wait_until
from vrpn_words import COOKIE, PING, PONG, POSE, named, packed, posed

DATA = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "data", "plus_eight_landmark_pivots")
RECORDING = os.path.join(DATA, "EightLandmarkPointsTrackedForPhantomRegistration.igs.mha")
def taken(socket_, count):
    data = b""
    while len(data) < count:
        piece = socket_.recv(count - len(data))
        if not piece:
            raise EOFError
        data += piece
    return data


class Client:
    """Asks by a datagram, as the library's own clients do, and reads what comes."""

    def __init__(self, port):
        self.waits = socket.create_server(("127.0.0.1", 0))
        self.waits.settimeout(60)
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as asks:
            asks.sendto(f"127.0.0.1 {self.waits.getsockname()[1]}".encode() + b"\0", ("127.0.0.1", port))
        self.socket, _ = self.waits.accept()
        self.socket.settimeout(60)
        self.socket.sendall(COOKIE)
        self.cookie = taken(self.socket, 24)
        self.devices, self.types = {}, {}

    def next(self):
        """(device, type, microseconds, payload) of the next message that is no introduction."""
        while True:
            length, s, us, sender, kind, _ = struct.unpack(">IIIiiI", taken(self.socket, 24))
            size = length - 24
            payload = taken(self.socket, size + -size % 8)[:size]
            if kind in (-1, -2):
                name = payload[4:].split(b"\0")[0].decode()
                (self.devices if kind == -1 else self.types)[sender] = name
            elif kind >= 0:
                return self.devices[sender], self.types[kind], s * 1_000_000 + us, payload

    def close(self):
        self.socket.close()
        self.waits.close()


class Vrpn(PosesByNetworkTest):
    def test_a_server_of_others_is_heard_and_heard_again_when_it_comes_back(self):
        port = free_port()
        listen = self.start("tracker", "listen", f"vrpn://127.0.0.1:{port}", "--tool", "Tracker0:1", "--out", "heard.csv", "--json", "heard.json")
        moment = 1_700_000_000_000_000
        for times in (1, 2):
            with socket.create_server(("127.0.0.1", port)) as server:
                server.settimeout(60)
                peer, _ = server.accept()
                self.assertRegex(taken(peer, 24), rb"^vrpn: ver\. 07\.\d\d  0\0*$")
                peer.sendall(COOKIE + named(-2, 4, "vrpn_Text Message") + named(-2, 7, POSE) + named(-1, 0, "Tracker0"))
                for i in range(50):
                    moment += 10_000
                    for sensor in (0, 1):
                        peer.sendall(posed(0, 7, moment, sensor, (0.001 * i, 0.1 * sensor, -1.5), (0.5, 0.5, 0.5, 0.5)))
                    peer.sendall(packed(0, 4, b"\0\0\0\0\0\0\0\0hello\0", moment))  # passed over
                wait_until(lambda: any("tool Tracker0:1" in line for line in listen.lines()), "heard")
                peer.close()
            wait_until(lambda n=times: sum("has gone" in line for line in listen.lines()) >= n, "gone")
        self.ends_at_ctrl_c(listen)
        rows = self.rows("heard.csv")
        self.assertEqual(len(rows), 100)
        self.assertEqual(rows[0]["time_s"], "1700000000.010000000")
        self.assertEqual([float(rows[3][key]) for key in ("x_mm", "y_mm", "z_mm", "qw", "qx")], [3.0, 100.0, -1500.0, 0.5, 0.5])
        told = json.loads(self.read("heard.json"))
        self.assertEqual((told["connections"], told["refused"], told["skipped"]), (2, 0, 100))

    def test_a_recording_is_served_to_a_client_of_others(self):
        replay = self.start("tracker", "replay", RECORDING, "--listen", "vrpn://0", "--transform", "StylusToReference", "--speed", "50")
        self.assertTrue(replay.says("serving"), replay.lines())
        port = int(re.search(r" at 127\.0\.0\.1:(\d+)", replay.lines()[-1])[1])
        client = Client(port)
        self.addCleanup(client.close)
        self.assertEqual(client.cookie[:14], b"vrpn: ver. 07.")
        heard = []
        try:
            while True:
                device, kind, us, payload = client.next()
                self.assertEqual((device, kind), ("StylusToReference", POSE))
                heard.append((us, struct.unpack(">ii7d", payload)))
        except EOFError:
            pass
        self.assertIn("0 dropped", replay.ends().out)
        self.runs("convert", RECORDING, "file.csv", "--transform", "StylusToReference")
        rows = self.rows("file.csv")
        self.assertEqual(len(heard), len(rows))
        for (us, numbers), row in zip(heard, rows):
            self.assertAlmostEqual(1e-6 * us, float(row["time_s"]), delta=1.1e-6)
            for value, key in zip(numbers[2:], ("x_mm", "y_mm", "z_mm", "qx", "qy", "qz", "qw")):
                self.assertAlmostEqual(value * (1000 if key.endswith("mm") else 1), float(row[key]), delta=1e-9 * 1000)

    def test_a_ping_is_answered_and_nonsense_does_no_harm(self):
        replay = self.start("tracker", "replay", RECORDING, "--listen", "vrpn://0", "--transform", "StylusToReference", "--loop")
        self.assertTrue(replay.says("serving"), replay.lines())
        port = int(re.search(r" at 127\.0\.0\.1:(\d+)", replay.lines()[-1])[1])
        with socket.create_connection(("127.0.0.1", port)) as browser:
            browser.sendall(b"GET / HTTP/1.1\r\nHost: here\r\nUser-Agent: a browser that took a wrong turn\r\n\r\n")
            browser.settimeout(60)
            while browser.recv(65536):
                pass
        client = Client(port)
        self.addCleanup(client.close)
        self.assertEqual(client.next()[:2], ("StylusToReference", POSE))
        client.socket.sendall(named(-1, 3, "StylusToReference") + named(-1, 4, "Nobody") + named(-2, 9, PING) + packed(4, 9) + packed(3, 9))
        wait_until(lambda: client.next()[:2] == ("StylusToReference", PONG), "a pong comes")
        self.ends_at_ctrl_c(replay)

    def test_a_constant_delay_of_the_stamps_is_found(self):
        """Poses stamped 20 ms late, against the same motion stamped in time: the delay to 0.2 ms."""
        port = free_port()
        listen = self.start("tracker", "listen", f"vrpn://127.0.0.1:{port}", "--out", "late.csv")

        def place(t):
            return tuple(0.05 * sum(math.sin(rate * t + 3 * rate + axis) for rate in (0.91, 2.23, 3.57, 5.49)) for axis in range(3))

        rows = []
        with socket.create_server(("127.0.0.1", port)) as server:
            server.settimeout(60)
            peer, _ = server.accept()
            taken(peer, 24)
            peer.sendall(COOKIE + named(-2, 0, POSE) + named(-1, 0, "Hand"))
            for i in range(2000):
                t = 100.0 + 0.01 * i
                rows.append(",".join(map(repr, [t, *(1000 * x for x in place(t)), 1.0, 0.0, 0.0, 0.0])))
                peer.sendall(posed(0, 0, round(1e6 * (t + 0.020)), 0, place(t)))
            threading.Event().wait(0.2)
            wait_until(lambda: listen.lines() and any("tool Hand" in line for line in listen.lines()), "heard")
            peer.close()
        wait_until(lambda: any("has gone" in line for line in listen.lines()), "gone")
        self.ends_at_ctrl_c(listen)
        self.write("true.csv", "time_s,x_mm,y_mm,z_mm,qw,qx,qy,qz\n" + "\n".join(rows) + "\n")
        self.runs("calibrate", "delay", "--from", "true.csv", "--to", "late.csv", "--json", "delay.json")
        self.assertAlmostEqual(json.loads(self.read("delay.json"))["delay_s"], 0.020, delta=0.0002)

    def test_what_cannot_be_is_refused(self):
        done = self.run_program("tracker", "listen", "vrpn://127.0.0.1:1", "--seconds", "1")
        self.assertEqual(done.code, 1, done)
        self.assertIn("nobody answers there; a VRPN server is expected", done.lines[-1])
        self.refuses(["tracker", "listen", "vrpn://"], 2, "a VRPN server")
        self.refuses(["tracker", "replay", RECORDING, "--listen", "vrpn://0.0.0.0:0"], 2, "VRPN protects nothing", "--insecure")


if __name__ == "__main__":
    unittest.main()
