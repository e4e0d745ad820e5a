#!/usr/bin/env python3
"""The demo across two hosts with a cable pulled: what the raw files say, what travelled over the cable, what is left behind."""
import collections
import csv
import ctypes
import json
import os
import signal
import socket
import threading
import unittest
import zlib

import raw_files
from program import PROGRAM, ProgramTest, wait_until, without_phases

CLONE_NEWNET = 0x40000000
PR_CAPBSET_DROP, CAP_SYS_ADMIN = 24, 21
ETH_P_ALL = 3
LIBC = ctypes.CDLL(None, use_errno=True)


def longest_gap(times):
    return max(later - earlier for earlier, later in zip(times, times[1:]))


class Tap(threading.Thread):
    """Keeps the bytes of every TCP segment on the cable, seen from the network of a process."""

    def __init__(self, pid):
        super().__init__(daemon=True)
        self.network = os.open(f"/proc/{pid}/ns/net", os.O_RDONLY)
        self.streams = collections.defaultdict(bytearray)  # by sender and ports; good enough to search in
        self.states = bytearray()  # segments as large as a state: of short ones most is the transport's own framing
        self.trouble = None
        self.done = threading.Event()
        self.ready = threading.Event()

    def run(self):
        # A network belongs to a thread: only this one goes there.
        if LIBC.setns(self.network, CLONE_NEWNET) != 0:
            self.trouble = os.strerror(ctypes.get_errno())
        os.close(self.network)
        if self.trouble is None:
            with socket.socket(socket.AF_PACKET, socket.SOCK_DGRAM, socket.htons(ETH_P_ALL)) as tap:
                tap.setsockopt(socket.SOL_SOCKET, 33, 1 << 24)  # SO_RCVBUFFORCE
                tap.settimeout(0.1)
                self.ready.set()
                while not self.done.is_set():
                    try:
                        packet, (device, protocol, *_) = tap.recvfrom(65536)
                    except OSError:
                        continue
                    if protocol == 0x0800 and packet[9] == socket.IPPROTO_TCP:
                        self.keep(device, packet)
        self.ready.set()

    def keep(self, device, packet):
        header = 4 * (packet[0] & 15)
        total = int.from_bytes(packet[2:4], "big")
        payload = packet[header + 4 * (packet[header + 12] >> 4):total]
        if len(payload) >= 300:
            self.states += payload
        self.streams[device, packet[12:20], packet[header:header + 4]] += payload

    def stop(self):
        self.done.set()
        self.join()
        return b"".join(bytes(stream) for stream in self.streams.values())


class TwoHosts(ProgramTest):
    def children(self, demo):
        """Processes that the demo started: {role: pid}."""
        found = {}
        for pid in filter(str.isdigit, os.listdir("/proc")):
            try:
                with open(f"/proc/{pid}/cmdline", encoding="utf-8") as file:
                    words = file.read().split("\0")
                if words[0] == os.path.realpath(PROGRAM) and f"demo-{demo.process.pid}" in words:
                    found[words[1]] = int(pid)
            except (OSError, UnicodeDecodeError):
                pass  # it has ended meanwhile
        return found

    def start_demo(self, *options):
        """A demo whose physics server is there, with a tap on the cable; and which interfaces its network has."""
        demo = self.start("demo", "--quick", "--seconds", "1", "--two-hosts", *options, "--out", "report")
        wait_until(lambda: demo.ended() or "physics" in self.children(demo), f"physics runs; so far {demo.lines()}")
        self.assertFalse(demo.ended(), demo.lines())
        tap = Tap(self.children(demo)["physics"])
        tap.start()
        self.addCleanup(tap.done.set)
        tap.ready.wait()
        self.assertIsNone(tap.trouble)
        return demo, tap

    def rows(self, name):
        with open(self.path("report", "raw", name), encoding="utf-8", newline="") as file:
            return list(csv.DictReader(file))

    def test_the_cut_is_in_the_raw_files_both_sides_are_back_within_a_second_and_nothing_plain_travels(self):
        self.leave_keys_of_a_killed_demo()
        demo, tap = self.start_demo()
        networks = {part: os.readlink(f"/proc/{pid}/ns/net") for part, pid in self.children(demo).items()}
        wait_until(lambda: demo.ended() or "graphics" in self.children(demo), "graphics runs")
        networks.update((part, os.readlink(f"/proc/{pid}/ns/net")) for part, pid in self.children(demo).items())
        self.assertEqual(networks["world"], os.readlink("/proc/self/ns/net"))
        self.assertEqual(len(set(networks.values())), 3, networks)
        with open(f"/proc/{self.children(demo)['physics']}/net/dev", encoding="ascii") as file:
            interfaces = {line.split(":")[0].strip(): line.split(":")[1].split() for line in file.readlines()[2:]}
        self.assertIn("cable", interfaces)
        self.assertEqual([name for name, counts in interfaces.items() if name != "cable" and counts[0] != "0"], [])

        done = demo.ends()
        self.assertEqual(done.code, 0, done)
        sent = tap.stop()
        self.nothing_left_behind(demo)

        events = {row["event"]: float(row["time_s"]) for row in self.rows("realtime_network.csv")}
        pulled, plugged = events["cable pulled"], events["cable plugged in"]
        self.assertGreaterEqual(plugged - pulled, 3.0)
        self.assertLess(plugged - pulled, 10.0)  # the demo itself has to get a turn

        frames = [(float(row["time_s"]), row["late"] == "0") for row in self.rows("realtime_frames.csv")]
        loops = [{key: float(value) for key, value in row.items()} for row in self.rows("realtime_loops.csv")]
        # A second, and what the machine at its busiest kept from either process at a stretch.
        stall = max(longest_gap([t for t, _ in frames]), longest_gap([row["time_s"] for row in loops]))
        a_second, quiet = 1.0 + 2 * stall, pulled + 0.2 + stall
        self.assertLess(events["physics server gone"] - pulled, a_second)
        self.assertLess(events["physics server back"] - plugged, a_second)
        # An answer that came just before the cable was pulled is still drawn.
        self.assertFalse(any(answered for t, answered in frames if quiet < t < plugged))
        self.assertTrue(any(quiet < t < plugged for t, _ in frames))
        self.assertTrue(any(answered for t, answered in frames if t < pulled))
        back = next(t for t, answered in frames if t > plugged and answered)
        self.assertLess(back - plugged, a_second)

        silent = [row["requests"] for row in loops if quiet < row["time_s"] < plugged]
        self.assertEqual(len(set(silent)), 1, "questions came through a pulled cable")
        answers = next(row["time_s"] for row in loops if row["time_s"] > plugged and row["requests"] > silent[-1])
        self.assertLess(answers - plugged, a_second)
        self.assertTrue(any(row["clients"] == 0 for row in loops if pulled < row["time_s"] < plugged))
        self.assertTrue(any(row["clients"] == 1 for row in loops if row["time_s"] > answers))
        # The loop goes on: as many ticks as milliseconds, but for what a busy machine takes from it.
        during = [row for row in loops if pulled < row["time_s"] < plugged]
        ticks = sum(during[-1][f"haptic_{count}"] - during[0][f"haptic_{count}"] for count in ("ticks", "missed"))
        self.assertAlmostEqual(ticks, 1000 * (during[-1]["time_s"] - during[0]["time_s"]), delta=100 + 2000 * stall)

        told = json.loads(self.read("report", "summary.json"))["realtime"]["network"]
        self.assertTrue(told["encrypted"])
        self.assertAlmostEqual(told["cut_for_s"], plugged - pulled, places=6)
        self.assertAlmostEqual(told["gone_after_s"], events["physics server gone"] - pulled, places=6)
        self.assertAlmostEqual(told["replies_after_s"], back - plugged, places=6)
        self.assertAlmostEqual(told["answers_after_s"], answers - plugged, places=6)
        self.assertEqual(told["cut"]["late"], sum(not answered for t, answered in frames if pulled <= t < plugged))
        self.assertIn(b"a cable pulled", self.read("report", "report.html"))
        raw_files.check(self, self.path("report"))

        self.assertGreater(len(sent), 20000)
        self.assertIn(b"CURVE", sent)  # named in the first, plain bytes of every connection: the tap does see
        for word in self.words():
            self.assertNotIn(word, sent)
        self.assertGreater(self.left_by_packing(tap), 0.9)  # what is encrypted cannot be packed

    def test_without_keys_the_same_words_can_be_read_on_the_cable(self):
        demo, tap = self.start_demo("--insecure")
        wait_until(lambda: demo.ended() or any(word in stream for stream in map(bytes, list(tap.streams.values()))
                                               for word in self.words()), "one of the words has been seen on the cable")
        self.assertFalse(demo.ended(), demo.lines())
        wait_until(lambda: demo.ended() or len(tap.states) > 20000, "some states have been sent")
        self.assertNotIn(b"CURVE", tap.stop())
        self.assertLess(self.left_by_packing(tap), 0.8)
        demo.send(signal.SIGINT)
        self.says_no(without_phases(demo.ends()), 1, "demo: stopped before its end")
        self.nothing_left_behind(demo)

    def words(self):
        """What stands in plain letters in the messages: who says hello, and which application is played."""
        return b"graphics", b"pingpong"

    def left_by_packing(self, tap):
        """How much of the states is left when they are packed."""
        return len(zlib.compress(bytes(tap.states), 9)) / len(tap.states)

    def leave_keys_of_a_killed_demo(self):
        gone = self.start("apps")
        gone.ends()
        place = os.path.join(self.meeting, "palpate")
        os.mkdir(place, 0o700)
        os.mkdir(os.path.join(place, f"demo-{gone.process.pid}.keys"), 0o700)

    def nothing_left_behind(self, demo):
        self.assertEqual(self.children(demo), {})
        place = os.path.join(self.meeting, "palpate")
        self.assertEqual([name for name in os.listdir(place) if not name.endswith(".lock")], [])
        with open("/proc/net/dev", encoding="ascii") as file:
            self.assertNotIn("cable", [line.split(":")[0].strip() for line in file])


class WithoutRights(ProgramTest):
    def test_a_user_who_may_not_make_networks_is_told_what_to_do_before_anything_is_calibrated(self):
        def give_up_the_right():
            LIBC.prctl(PR_CAPBSET_DROP, CAP_SYS_ADMIN)  # who does not have it need not give it up
        self.refuses(["demo", "--quick", "--two-hosts", "--out", "report"], 1, "may not make networks", "as root", "unshare", before=give_up_the_right)

    def test_insecure_belongs_to_two_hosts(self):
        self.assertEqual(self.run_program("demo", "--insecure").code, 2)


if __name__ == "__main__":
    unittest.main()
