#!/usr/bin/env python3
"""NDI trackers: against a device and a client of the combined API, written from its published guides and sharing nothing with
the program."""
import bisect
import json
import math
import os
import re
import socket
import struct
import threading
import unittest

from ndi_words import bare, binary, checksum, columns_of, frame, frames_of, handles, handles_of, text
from poses_by_network import PosesByNetworkTest
from program import free_port, wait_until

DATA = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "data", "plus_eight_landmark_pivots")
RECORDING = os.path.join(DATA, "EightLandmarkPointsTrackedForPhantomRegistration.igs.mha")
UNTURNED = (1.0, 0.0, 0.0, 0.0)


def taken(socket_, count):
    data = b""
    while len(data) < count:
        piece = socket_.recv(count - len(data))
        if not piece:
            raise EOFError
        data += piece
    return data


def line_of(socket_):
    data = b""
    while not data.endswith(b"\r"):
        data += taken(socket_, 1)
    return data[:-1]


class Client:
    """Asks one thing after the other."""

    def __init__(self, port):
        self.socket = socket.create_connection(("127.0.0.1", port))
        self.socket.settimeout(60)

    def ask(self, words):
        self.socket.sendall(text(words))
        return bare(line_of(self.socket))

    def ask_bytes(self, words):
        self.socket.sendall(text(words))
        head = taken(self.socket, 6)
        start, size, said = struct.unpack("<HHH", head)
        assert (start, said) == (0xA5C4, checksum(head[:4])), head
        body = taken(self.socket, size)
        assert struct.unpack("<H", taken(self.socket, 2))[0] == checksum(body)
        return body

    def start(self):
        """The tools, by handle."""
        assert self.ask("INIT:") == "OKAY"
        assert self.ask("COMM:00000") == "OKAY"
        self.ask("VER:0")
        assert self.ask("PHSR:01") == "00"
        listed = self.ask("PHSR:02")
        found = [listed[i:i + 2] for i in range(2, len(listed), 5)]
        assert len(found) == int(listed[:2], 16)
        for handle in found:
            assert self.ask(f"PINIT:{handle}") == "OKAY"
            assert self.ask(f"PENA:{handle}D") == "OKAY"
        names = {int(handle, 16): self.ask(f"PHINF:{handle}0005")[33:].rstrip() for handle in found}
        assert self.ask("TSTART:") == "OKAY"
        return names


class Device:
    """Answers one client at a time; `poses(ask)` gives the body of the reply to BX2 or BX, or None where it is gone."""

    def __init__(self, test, port, with_time, poses, tools=("Probe",)):
        self.with_time, self.poses, self.tools = with_time, poses, tools
        self.commands, self.written = [], {}
        self.server = socket.create_server(("127.0.0.1", port))
        self.server.settimeout(60)
        self.wireless = 0
        test.addCleanup(self.server.close)
        threading.Thread(target=self.run, daemon=True).start()

    def run(self):
        try:
            peer, _ = self.server.accept()
            peer.settimeout(60)
            with peer:
                while True:
                    reply = self.answer(bare(line_of(peer)))
                    if reply is None:
                        return
                    peer.sendall(reply)
        except (EOFError, OSError):
            pass

    def answer(self, words):
        name, _, rest = words.partition(":")
        if name in ("BX", "BX2"):
            if name == "BX2" and not self.with_time:
                return text("ERROR01")
            body = self.poses()
            return body if body is None else binary(body)
        self.commands.append(words)
        if name == "PHSR":
            numbers = range(1, 1 + len(self.tools) + self.wireless)
            return text("00" if rest == "01" else f"{len(numbers):02X}" + "".join(f"{n:02X}001" for n in numbers))
        if name == "PHRQ":
            self.wireless += 1
            return text(f"{len(self.tools) + self.wireless:02X}")
        if name == "PVWR":
            self.written.setdefault(rest[:2], bytearray()).extend(bytes.fromhex(rest[6:]))
        if name == "PHINF":
            handle = int(rest[:2], 16)
            named = self.tools[handle - 1] if handle <= len(self.tools) else ""
            return text(f"02000000NDI         001{handle:08X}31{named:<20}")
        return text("OKAY")


class Ndi(PosesByNetworkTest):
    def serve(self, *options):
        replay = self.start("tracker", "replay", RECORDING, "--listen", "ndi://0", *options)
        self.assertTrue(replay.says("serving"), replay.lines())
        return replay, int(re.search(r" at 127\.0\.0\.1:(\d+)", replay.lines()[-1])[1])

    def test_a_device_of_others_is_heard_and_heard_again_when_it_comes_back(self):
        port = free_port()
        listen = self.start("tracker", "listen", f"ndi://127.0.0.1:{port}", "--tool", "Probe", "--out", "heard.csv", "--json", "heard.json")
        count, moment = 0, 1_700_000_000_000_000_000

        def poses():
            """Each frame three times, as a client asks faster than a device measures."""
            nonlocal count
            count += 1
            n = count // 3
            if n > limit:
                return None
            place = (float(n), 100.0, -1500.0)
            return frame(n, moment + 10_000_001 * n, [(1, (0.5, 0.5, 0.5, 0.5), place), (2, None, None)])

        for limit in (50, 100):
            device = Device(self, port, True, poses, ("Probe", "Head"))
            wait_until(lambda n=limit: sum("has gone" in line for line in listen.lines()) >= n // 50, "gone")
            self.assertEqual(device.commands, ["INIT:", "PHSR:01", "PHSR:02", "PINIT:01", "PINIT:02", "PHSR:03", "PENA:01D", "PENA:02D",
                                               "PHINF:010005", "PHINF:020005", "TSTART:"])
            device.server.close()
        self.ends_at_ctrl_c(listen)
        rows = self.rows("heard.csv")
        self.assertEqual(len(rows), 101)  # from 0
        self.assertEqual(rows[1]["time_s"], "1700000000.010000001")
        self.assertEqual([float(rows[3][key]) for key in ("x_mm", "y_mm", "z_mm", "qw", "qx")], [3.0, 100.0, -1500.0, 0.5, 0.5])
        told = json.loads(self.read("heard.json"))
        self.assertEqual((told["connections"], told["refused"], told["bad_crc"], told["lost"]), (2, 0, 0, 0))
        self.assertEqual({tool["name"]: (tool["poses"] > 0, tool["unseen"] > 0) for tool in told["tools"]}, {"Probe": (True, False), "Head": (False, True)})

    def test_an_older_device_and_a_wireless_tool_with_its_file(self):
        port = free_port()
        with open(self.path("needle.rom"), "wb") as file:
            file.write(bytes(range(256)) * 3)
        frames = iter(range(10**9))
        device = Device(self, port, False, lambda: handles(next(frames) // 5, [(1, None, None), (2, UNTURNED, (1.0, 2.0, 3.0))]))
        listen = self.start("tracker", "listen", f"ndi://127.0.0.1:{port}/{self.path('needle.rom')}", "--tool", "needle", "--json", "heard.json")
        wait_until(lambda: any("tool needle (without time stamps" in line for line in listen.lines()), "heard")
        done = self.ends_at_ctrl_c(listen)
        self.assertEqual(bytes(device.written["02"]), bytes(range(256)) * 3)
        wait_until(lambda: device.commands[-1] == "TSTOP:", "tracking is stopped")
        tools = {tool["name"]: tool for tool in json.loads(self.read("heard.json"))["tools"]}
        self.assertGreater(tools["needle"]["poses"], 0, done)
        self.assertGreater(tools["Probe"]["unseen"], 0)

    def test_a_recording_is_served_to_a_client_of_others(self):
        replay, port = self.serve("--transform", "StylusToReference", "--transform", "StylusToTracker", "--speed", "40")
        client = Client(port)
        self.addCleanup(client.socket.close)
        names = client.start()
        self.assertEqual(names, {1: "StylusToReference", 2: "StylusToTracker"})
        heard, newest = {1: {}, 2: {}}, {}
        try:
            while True:
                for _, ns, tools in frames_of(client.ask_bytes("BX2:--6d=tools")):
                    for handle, numbers in tools.items():
                        if numbers is not None:
                            heard[handle][ns] = newest[handle] = numbers
                for others in (handles_of(client.ask_bytes("BX:0001")), columns_of(client.ask("TX:0001"))):
                    for handle, (numbers, _) in others.items():
                        if numbers is not None:
                            newest.setdefault(("as they are told otherwise", handle), []).append(numbers)
        except (EOFError, OSError):
            pass
        self.assertIn("0 dropped", replay.ends().out)
        for handle, name in names.items():
            self.runs("convert", RECORDING, "file.csv", "--transform", name)
            rows = [[float(row[key]) for key in ("qw", "qx", "qy", "qz", "x_mm", "y_mm", "z_mm")] for row in self.rows("file.csv")]
            stamps = [round(1e9 * float(row["time_s"])) for row in self.rows("file.csv")]
            # The first ones came before it had asked for any.
            self.assertGreater(len(heard[handle]), 0.8 * len(rows))
            first = min(heard[handle])
            self.assertEqual(len(heard[handle]), sum(stamp >= first - 1000 for stamp in stamps))
            for ns, numbers in heard[handle].items():
                after = bisect.bisect(stamps, ns - 1000)
                self.assertLess(abs(stamps[after] - ns), 1000)
                row = rows[after]
                for value, wanted, near in zip(numbers, row, (1e-7,) * 4 + (1e-4,) * 3):  # float32
                    self.assertAlmostEqual(value, wanted, delta=near)
            for numbers in newest["as they are told otherwise", handle][::20]:  # hundredths of a millimetre in text
                self.assertLess(min(max(abs(a - b) for a, b in zip(numbers, row)) for row in rows), 0.0051)

    def test_what_is_none_of_it_does_no_harm(self):
        replay, port = self.serve("--transform", "StylusToReference", "--loop")
        with socket.create_connection(("127.0.0.1", port)) as browser:
            browser.sendall(b"GET / HTTP/1.1\r\nHost: here\r\nUser-Agent: a browser that took a wrong turn\r\n\r\n")
            browser.settimeout(60)
            try:
                while browser.recv(65536):
                    pass
            except ConnectionResetError:
                pass
        client = Client(port)
        self.addCleanup(client.socket.close)
        self.assertEqual(client.ask("HELLO:"), "ERROR01")
        client.socket.sendall(b"INIT:0000\r")
        self.assertEqual(bare(line_of(client.socket)), "ERROR04")
        self.assertEqual(client.ask("TX:0001"), "ERROR0C")
        self.assertEqual(client.start(), {1: "StylusToReference"})
        wait_until(lambda: any(tools.get(1) for _, _, tools in frames_of(client.ask_bytes("BX2:--6d=tools"))), "poses come")
        self.ends_at_ctrl_c(replay)

    def test_a_constant_delay_of_the_stamps_is_found(self):
        """Poses stamped 20 ms late, against the same motion stamped in time: the delay to 0.2 ms."""
        port = free_port()

        def place(t):
            return tuple(50 * sum(math.sin(rate * t + 3 * rate + axis) for rate in (0.91, 2.23, 3.57, 5.49)) for axis in range(3))

        steps = iter(range(2001))
        rows = []

        def poses():
            i = next(steps)
            if i == 2000:
                return None
            t = 100.0 + 0.01 * i
            rows.append(",".join(map(repr, [t, *place(t), *UNTURNED])))
            return frame(i + 1, round(1e9 * (t + 0.020)), [(1, UNTURNED, place(t))])

        device = Device(self, port, True, poses)
        listen = self.start("tracker", "listen", f"ndi://127.0.0.1:{port}", "--out", "late.csv")
        wait_until(lambda: any("has gone" in line for line in listen.lines()), "gone")
        self.ends_at_ctrl_c(listen)
        self.assertEqual(device.commands[-1], "TSTART:")
        self.write("true.csv", "time_s,x_mm,y_mm,z_mm,qw,qx,qy,qz\n" + "\n".join(rows) + "\n")
        self.runs("calibrate", "delay", "--from", "true.csv", "--to", "late.csv", "--json", "delay.json")
        self.assertAlmostEqual(json.loads(self.read("delay.json"))["delay_s"], 0.020, delta=0.0002)

    def test_what_cannot_be_is_refused(self):
        done = self.run_program("tracker", "listen", "ndi://127.0.0.1:1", "--seconds", "1")
        self.assertEqual(done.code, 1, done)
        self.assertIn("nobody answers there; an NDI tracker is expected", done.lines[-1])
        self.refuses(["tracker", "listen", "ndi://"], 2, "an NDI tracker")
        self.refuses(["tracker", "listen", "ndi://127.0.0.1/nowhere.rom"], 2, "nowhere.rom")
        self.refuses(["tracker", "replay", RECORDING, "--listen", "ndi://0.0.0.0:0"], 2, "NDI protects nothing", "--insecure")
        port = free_port()
        device = Device(self, port, True, lambda: None)
        device.answer = lambda words: text("ERROR15")
        done = self.run_program("tracker", "listen", f"ndi://127.0.0.1:{port}", "--seconds", "2")
        self.assertEqual(done.code, 1, done)
        self.assertIn("INIT: ERROR15, it cannot initialize itself", done.lines[-1])


if __name__ == "__main__":
    unittest.main()
