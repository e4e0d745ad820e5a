#!/usr/bin/env python3
"""The haptic loop beside crowds and floods at the server's ports: with real-time rights as in quiet, without them as beside the same
attackers at a listener of no concern to it, which take the same cores."""
import ctypes
import os
import resource
import statistics
import subprocess
import sys
import time
import unittest

from guarded import HERE, GuardedServerTest
from program import free_port

ATTACKS = (("strangers", 300, False), ("talking", 300, True), ("flood-1000", 30, True), ("flood-60000", 30, True), ("flood-hello", 8, True))
PAIRS = 5        # of each attack: at the server, at the listener
SECONDS = 2.0    # that a rate is taken over
KEPT = 0.95      # of the rate, at the median of the pairs
QUIET = 0.99
PR_CAPBSET_DROP, CAP_SYS_NICE = 24, 23


def without_rights():
    """What is started so gets no real-time scheduling, root's neither."""
    resource.setrlimit(resource.RLIMIT_RTPRIO, (0, 0))
    ctypes.CDLL(None).prctl(PR_CAPBSET_DROP, CAP_SYS_NICE, 0, 0, 0)


class AttackedLoops(GuardedServerTest):
    def setUp(self):
        super().setUp()
        self.admit("observer", self.guest, "guest")

    def serve(self, **how):
        """The server; whether it has real-time rights is what it says itself."""
        self.mark_checked("openhaptics Simulated PHANToM 0042", "peak_n = 1.0")
        physics = self.start("physics", "--rig", self.rig, "--listen", f"tcp://127.0.0.1:{self.port}", "--keys", self.keys, "--arm", "openhaptics", **how)
        self.assertTrue(physics.says("answers graphics servers at"), physics.lines())
        self.chief_in = self.peer(self.chief, self.port)
        self.status(self.chief_in)
        return physics, not any("without real-time rights" in line for line in physics.lines())

    def rate(self):
        """Of the haptic loop, Hz: the ticks among its deadlines, of which there are a thousand a second."""
        def count():
            loop = self.status(self.chief_in).loops[0]
            return loop.ticks, loop.missed
        ticks, missed = count()
        time.sleep(SECONDS)
        ticks, missed = (now - before for now, before in zip(count(), (ticks, missed)))
        return 1000.0 * ticks / (ticks + missed)

    def listener(self):
        """Takes whatever comes to the port it names and does nothing with it, behind the server's own key."""
        port = free_port()
        listening = subprocess.Popen([sys.executable, os.path.join(HERE, "idle_listener.py"), f"tcp://127.0.0.1:{port}", os.path.join(self.keys, "secret_key")],
                                     stdout=subprocess.PIPE, text=True)
        self.addCleanup(listening.stdout.close)
        self.addCleanup(listening.wait)
        self.addCleanup(listening.kill)
        self.assertEqual(listening.stdout.readline(), "there\n")
        return port

    def attacked(self, what, many, keyed, port):
        leave = self.crowd(what, many, f"tcp://127.0.0.1:{port}", *(self.with_keys(self.guest) if keyed else ()))
        time.sleep(0.3)
        rate = self.rate()
        leave()
        return rate

    def compare(self, beside, kept):
        """beside(attack): the rate that the one under attack is held against."""
        for attack in ATTACKS:
            pairs = [(self.attacked(*attack, self.port), beside(attack)) for _ in range(PAIRS)]
            ratio = statistics.median(here / there for here, there in pairs)
            figures = ", ".join(f"{here:.0f}/{there:.0f}" for here, there in pairs)
            print(f"{attack[0]} x {attack[1]}: {ratio:.3f} of the rate ({figures} Hz)", file=sys.stderr)
            with self.subTest(attack[0]):
                self.assertGreater(ratio, kept)

    def test_with_real_time_rights_attacks_are_not_felt(self):
        physics, protected = self.serve()
        if not protected:
            self.skipTest("this machine grants no real-time rights")
        self.compare(lambda attack: self.rate(), QUIET)
        self.stop_in_order(physics)

    def test_without_rights_attackers_cost_no_more_than_their_share_of_the_cores(self):
        physics, protected = self.serve(preexec_fn=without_rights)
        self.assertFalse(protected)
        port = self.listener()
        self.compare(lambda attack: self.attacked(*attack, port), KEPT)
        self.stop_in_order(physics)


if __name__ == "__main__":
    unittest.main()
