#!/usr/bin/env python3
"""Trackers over OpenIGTLink: a recording played and heard over sockets of this machine, and programs of others."""
import csv
import json
import os
import re
import signal
import socket
import struct
import subprocess
import unittest

from poses_by_network import PosesByNetworkTest
from program import free_port, wait_until

DATA = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "data", "plus_eight_landmark_pivots")
RECORDING = os.path.join(DATA, "EightLandmarkPointsTrackedForPhantomRegistration.igs.mha")
PEERS = os.environ.get("OPENIGTLINK_PEERS", "")  # folder of Debian's example programs, where they could be built


class TrackerTest(PosesByNetworkTest):
    def replay(self, *arguments):
        """A replay at a port of its choice; the process and its port."""
        running = self.start("tracker", "replay", RECORDING, "--listen", "0", *arguments)
        self.assertTrue(running.says("serving"), running.lines())
        return running, int(re.search(r" at 127\.0\.0\.1:(\d+)", running.lines()[-1]).group(1))


class Recording(TrackerTest):
    def test_heard_over_a_socket_it_has_the_same_pivot_as_the_file(self):
        replay, port = self.replay("--transform", "StylusToReference", "--speed", "50")
        listen = self.start("tracker", "listen", f"127.0.0.1:{port}", "--out", "heard.csv")
        self.assertTrue(listen.says("the server has gone"), listen.lines())
        self.assertIn("1000 poses published, 1000 messages sent to 1 client, 0 dropped", replay.ends().out)
        self.assertIn("StylusToReference    1000 poses", self.ends_at_ctrl_c(listen).out)

        # which poses rest in which landmark stands in the table that was made from the same recording
        with open(os.path.join(DATA, "stylus_to_reference.csv"), encoding="ascii") as file:
            landmarks = [row["landmark"] for row in csv.DictReader(file)]
        heard = self.rows("heard.csv")
        self.assertEqual(len(heard), len(landmarks))
        self.assertEqual(heard[0]["time_s"], "280.461142857")
        lines = self.read("heard.csv").decode().splitlines()
        self.write("labelled.csv", "\n".join(f"{line},{label}" for line, label in zip(lines, ["landmark", *landmarks])))
        self.runs("calibrate", "pivot", "--poses", "labelled.csv", "--segments", "landmark", "--json", "live.json")
        self.runs("calibrate", "pivot", "--poses", os.path.join(DATA, "stylus_to_reference.csv"), "--segments",
                  "landmark", "--json", "file.json")
        live, file = (json.loads(self.read(name)) for name in ("live.json", "file.json"))
        for a, b in zip(live["tip_mm"], file["tip_mm"]):
            self.assertAlmostEqual(a, b, delta=0.05)  # the table inverted matrices that are rotations to 3e-4 only

    def test_a_server_that_is_not_there_is_told_at_once(self):
        with socket.socket() as taken:
            taken.bind(("127.0.0.1", 0))  # and does not listen: nobody else gets the port
            listen = self.start("tracker", "listen", f"127.0.0.1:{taken.getsockname()[1]}")
            self.assertTrue(listen.says("nobody answers there yet; waiting for a server"), listen.lines())
            listen.send(signal.SIGINT)
            done = listen.ends()
            self.assertEqual(done.code, 1, done)
            self.assertIn("nobody answers there; an OpenIGTLink server is expected, start it", done.lines[-1])

    def test_all_transforms_loop_until_ctrl_c_and_a_listener_waits_for_the_servers_return(self):
        port = free_port()
        listen = self.start("tracker", "listen", f"127.0.0.1:{port}", "--tool", "StylusToTracker", "--out", "heard.csv")
        for times in (1, 2):
            replay = self.start("tracker", "replay", RECORDING, "--listen", port, "--loop", "--speed", "100")
            wait_until(lambda n=times: sum("connected" in line for line in listen.lines()) >= n or listen.ended(),
                       f"connected {times} times")
            self.assertTrue(listen.says("tool ReferenceToTracker"))
            self.assertTrue(listen.says("tool StylusToTracker"))
            self.assertIn("published", self.ends_at_ctrl_c(replay).out)
            wait_until(lambda n=times: sum("has gone" in line for line in listen.lines()) >= n or listen.ended(), "gone")
        self.ends_at_ctrl_c(listen)
        self.assertGreater(len(self.rows("heard.csv")), 0)

    def test_a_client_that_sends_nonsense_does_no_harm(self):
        replay, port = self.replay("--loop", "--transform", "StylusToTracker")
        with socket.create_connection(("127.0.0.1", port)) as browser:
            browser.sendall(b"GET / HTTP/1.1\r\nHost: here\r\nUser-Agent: a browser that took a wrong turn\r\n\r\n")
            try:
                while browser.recv(65536):  # until it is thrown out
                    pass
            except ConnectionResetError:
                pass
        listen = self.start("tracker", "listen", f"127.0.0.1:{port}", "--json", "figures.json")
        self.assertTrue(listen.says("tool StylusToTracker"))
        self.ends_at_ctrl_c(listen)
        self.assertGreater(json.loads(self.read("figures.json"))["tools"][0]["poses"], 0)
        self.ends_at_ctrl_c(replay)

    def test_a_server_that_sends_nonsense_is_told_of(self):
        with socket.create_server(("127.0.0.1", 0)) as server:
            port = server.getsockname()[1]
            listen = self.start("tracker", "listen", f"127.0.0.1:{port}", "--seconds", "600")
            connection = server.accept()[0]
            connection.sendall(b"SSH-2.0-OpenSSH_9.2p1 and more than a header's worth of other words\r\n")
            self.assertEqual(connection.makefile("rb").read(1), b"")
            connection.close()
            listen.send(signal.SIGINT)
            done = listen.ends()
        self.assertEqual(done.code, 1, done)
        self.assertIn("not OpenIGTLink", done.lines[-1])

    def test_what_cannot_be_is_refused_in_one_line(self):
        self.refuses(["tracker", "listen", "here:port"], 2, "HOST:PORT")
        self.refuses(["tracker", "listen", "127.0.0.1:1", "--out", "nowhere/poses.csv"], 2, "nowhere", "make it first")
        self.refuses(["tracker", "replay", "nothing.igs.mha"], 2, "nothing.igs.mha")
        self.refuses(["tracker", "replay", RECORDING, "--transform", "StylusToMoon"], 2, "StylusToMoon", "StylusToTracker")
        self.refuses(["tracker", "replay", RECORDING, "--listen", "0.0.0.0:0"], 2, "--insecure")
        self.refuses(["tracker", "replay", RECORDING, "--listen", "70000"], 2, "70000")
        self.refuses(["tracker", "replay", RECORDING, "--speed", "0"], 2, "--speed")
        with socket.create_server(("127.0.0.1", 0)) as taken:
            self.refuses(["tracker", "replay", RECORDING, "--listen", taken.getsockname()[1]], 1, "choose another port")
        nobody = self.run_program("tracker", "listen", f"127.0.0.1:{free_port()}", "--seconds", "0.5", "--out", "x.csv")
        self.assertEqual(nobody.code, 1, nobody)
        self.assertIn("nobody answers", nobody.lines[-1])
        self.assertEqual(self.files(), {})

    def test_a_tool_that_is_not_there_is_named_with_those_that_are(self):
        replay, port = self.replay("--transform", "StylusToTracker", "--loop")
        listen = self.start("tracker", "listen", f"127.0.0.1:{port}", "--tool", "Needle", "--out", "x.csv")
        self.assertTrue(listen.says("tool StylusToTracker"))
        listen.send(signal.SIGINT)
        done = listen.ends()
        self.assertEqual(done.code, 1, done)
        self.assertIn("no tool 'Needle' was heard; there were StylusToTracker", done.lines[-1])
        self.ends_at_ctrl_c(replay)


    def test_a_tool_that_is_not_heard_is_told_while_there_is_time(self):
        replay, port = self.replay("--loop")
        listen = self.start("tracker", "listen", f"127.0.0.1:{port}", "--tool", "StylusToReference", "--out", "x.csv")
        self.assertTrue(listen.says("warning: no tool 'StylusToReference' so far, but ReferenceToTracker, StylusToTracker"))
        self.assertFalse(listen.ended())
        listen.send(signal.SIGINT)
        self.assertEqual(listen.ends().code, 1)
        heard = self.start("tracker", "listen", f"127.0.0.1:{port}", "--tool", "StylusToTracker", "--seconds", "2", "--out", "y.csv")
        self.assertNotIn("so far", heard.ends().err)
        self.ends_at_ctrl_c(replay)

    def test_samples_of_an_arm_are_no_tool(self):
        self.runs("world", "sample", "arm", "--points", "20", "--out", "arm")
        self.refuses(["tracker", "replay", "arm/arm.csv"], 2, "arm.csv", "samples of an arm", "calibrate arm --samples")


class ProgramsOfOthers(TrackerTest):
    """Debian's examples of the OpenIGTLink library, which nobody of this project wrote."""

    def peer(self, name, *arguments):
        with open(os.path.join(self.logs, name), "wb") as log:
            process = subprocess.Popen([os.path.join(PEERS, "igtl_peer_" + name), *map(str, arguments)],
                                       stdin=subprocess.DEVNULL, stdout=log, stderr=log)
        self.addCleanup(process.wait)
        self.addCleanup(process.kill)
        return process

    def said(self, name):
        with open(os.path.join(self.logs, name), encoding="utf-8") as log:
            return log.read()

    def listen_to(self, port, tools):
        listen = self.start("tracker", "listen", f"127.0.0.1:{port}", "--tool", tools[0], "--out", "heard.csv")
        for tool in tools:
            self.assertTrue(listen.says("tool " + tool), listen.lines())
        self.ends_at_ctrl_c(listen)
        return self.rows("heard.csv")

    def test_their_tracker_is_heard(self):
        port = free_port()
        server = self.peer("TrackerServer", port, 100)
        heard = self.listen_to(port, ["Tracker"])
        server.kill()
        server.wait()
        self.assertGreater(len(heard), 0)
        # It prints each matrix it sends; the first one, to what it prints of a number.
        matrix = [[float(x) for x in line.split(",")] for line in self.said("TrackerServer").splitlines()[1:4]]
        for axis, row in zip("xyz", matrix):
            self.assertAlmostEqual(float(heard[0][f"{axis}_mm"]), row[3], delta=1e-3)
        w, x, y, z = (float(heard[0]["q" + part]) for part in "wxyz")
        self.assertAlmostEqual(1 - 2 * (y * y + z * z), matrix[0][0], delta=1e-5)
        self.assertAlmostEqual(2 * (x * y - w * z), matrix[0][1], delta=1e-5)
        self.assertAlmostEqual(2 * (x * z + w * y), matrix[0][2], delta=1e-5)
        self.assertAlmostEqual(2 * (y * z - w * x), matrix[1][2], delta=1e-5)

    def test_their_tracking_data_server_starts_at_our_request(self):
        port = free_port()
        self.peer("TrackingDataServer", port)
        self.listen_to(port, ["Channel 0", "Channel 1", "Channel 2"])
        self.assertIn("Received a STT_TDATA", self.said("TrackingDataServer"))

    def test_their_client_reads_what_we_serve(self):
        replay, port = self.replay("--transform", "StylusToReference", "--speed", "100")
        client = self.peer("ReceiveClient", "127.0.0.1", port)
        self.assertEqual(replay.ends().code, 0)
        client.wait(240)
        said = self.said("ReceiveClient")
        self.assertEqual(said.count("Receiving TRANSFORM"), 1000)
        matrices = re.findall(r"=+\n((?:[^=\n]+\n){4})", said)
        self.assertEqual(len(matrices), 1000)
        with open(os.path.join(DATA, "stylus_to_reference.csv"), encoding="ascii") as file:
            for row, text in zip(csv.DictReader(file), matrices):
                numbers = [[float(x) for x in line.split(",")] for line in text.splitlines()]
                for r in range(3):
                    for c in range(4):
                        # the recording's matrices are rotations to 3e-4 only; we send the nearest ones
                        self.assertAlmostEqual(numbers[r][c], float(row[f"m{r}{c}"]), delta=0.2 if c == 3 else 1e-3)
        seconds, fraction = re.search(r"Time stamp: (\d+)\.(\d{9})", said).groups()
        self.assertAlmostEqual(int(seconds) + int(fraction) * 1e-9, 280.4611428572264, delta=1e-7)


if not PEERS:  # they could not be built (tests/CMakeLists.txt)
    del ProgramsOfOthers


class Bytes(TrackerTest):
    def test_a_listener_written_from_the_specification_reads_the_first_message(self):
        replay, port = self.replay("--transform", "StylusToTracker")
        with socket.create_connection(("127.0.0.1", port)) as client:
            bytes_ = client.makefile("rb").read(58 + 48)
        version, kind, device, stamp, size, crc = struct.unpack(">H12s20sQQQ", bytes_[:58])
        self.assertEqual((version, kind.rstrip(b"\0"), device.rstrip(b"\0"), size), (1, b"TRANSFORM", b"StylusToTracker", 48))
        self.assertAlmostEqual(stamp / 2**32, 280.4611428572264, delta=1e-8)
        check = 0
        for byte in bytes_[58:]:
            check ^= byte << 56
            for _ in range(8):
                check = (check << 1 ^ (0x42F0E1EBA9EA3693 if check >> 63 else 0)) & 0xFFFFFFFFFFFFFFFF
        self.assertEqual(check, crc)
        m = struct.unpack(">12f", bytes_[58:])
        for number, expected in zip(m, (0.68393111, 0.52706214, 0.50467402, 0.36068214, 0.35705162, -0.86174114,
                                        -0.63429507, 0.77138259, 0.05420607, 315.55283, 9.82265625, -36.0536133)):
            self.assertAlmostEqual(number, expected, delta=3e-4)  # the file's matrix is a rotation to 3e-4 only
        self.ends_at_ctrl_c(replay)


if __name__ == "__main__":
    unittest.main()
