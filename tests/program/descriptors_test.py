#!/usr/bin/env python3
"""A physics server that has no descriptor left, or a few: what observers do then, and a key taken out, does not end it."""
import os
import resource
import subprocess
import sys
import time
import unittest

import zmq

from keys_test import free_port
from laboratory import LaboratoryTest
from program import wait_until

HERE = os.path.dirname(os.path.abspath(__file__))
SOON_S = 2.0  # until observers are served again once there are descriptors; a new connection takes a tenth of it


class Peer:
    """A socket with a key of its own that speaks to the server's."""

    def __init__(self, wire, address, server_key, pair):
        self.wire, self.socket = wire, zmq.Context.instance().socket(zmq.DEALER)
        self.socket.linger, self.socket.sndtimeo = 0, 200
        self.socket.curve_publickey, self.socket.curve_secretkey = pair
        self.socket.curve_serverkey = server_key
        self.socket.connect(address)

    def say(self, **body):
        try:
            self.socket.send(self.wire.ToPhysics(protocol=2, **body).SerializeToString())
        except zmq.Again:  # no connection: it was turned away
            pass

    def hears(self, longest_s):
        """The next message as it came, or None where none comes in time."""
        return self.wire.ToGraphics.FromString(self.socket.recv()) if self.socket.poll(int(1000 * longest_s)) else None


class Descriptors(LaboratoryTest):
    def setUp(self):
        super().setUp()
        subprocess.run(["protoc", f"-I{HERE}/../../proto", f"--python_out={self.root}", "palpate.proto"], check=True)
        sys.path.append(self.root)
        self.addCleanup(sys.path.remove, self.root)
        import palpate_pb2
        self.wire, self.keys, self.port = palpate_pb2, self.path("keys"), free_port()
        self.environment.update(PALPATE_LIBHD=os.environ["HD_STUB"], HD_STUB_STATE=os.path.join(self.root, "state"))
        self.runs("keys", "new", "--keys", self.keys)
        with open(os.path.join(self.keys, "secret_key"), encoding="ascii") as file:
            self.server_key = next(word for line in file if line[0] != "#" for word in line.split() if len(word) == 40).encode()
        self.chief, self.screen, self.guest = (self.pair() for _ in range(3))
        self.admit("operator", self.chief, "chief")
        self.admit("graphics", self.screen, "screen")
        self.number = 0

    def pair(self):
        while (pair := zmq.curve_keypair())[0].startswith(b"-"):  # like an option of the command
            pass
        return pair

    def admit(self, role, pair, name):
        self.runs("keys", "authorize", pair[0].decode(), "--role", role, "--name", name, "--keys", self.keys)

    def peer(self, pair, port):
        peer = Peer(self.wire, f"tcp://127.0.0.1:{port}", self.server_key, pair)
        self.addCleanup(peer.socket.close)
        return peer

    def observer(self, pair):
        return self.peer(pair, self.port + 1)

    def serves(self, observer, patience_s):
        """A state that was asked for now comes in time; what was under way before is passed over."""
        while observer.hears(0.0):
            pass
        until = time.monotonic() + patience_s
        while time.monotonic() < until:
            observer.say(subscribe=self.wire.Subscribe(rate_hz=100))
            heard = observer.hears(0.2)
            if heard and heard.WhichOneof("body") == "state_reply":
                return True
        return False

    def comes_in(self, pair):
        """An observer that is served, as soon as the server has seen that its key is admitted."""
        served = []

        def tries():
            observer = self.observer(pair)
            if self.serves(observer, 0.4):
                served.append(observer)
            return served
        wait_until(tries, "a key that has been admitted is served")
        return served[0]

    def loops(self, asking):
        """Ticks of haptic and physics loop, and whether forces are as they should be."""
        self.number += 1
        asking.say(status_request=self.wire.StatusRequest(number=self.number))
        heard = asking.hears(10.0)
        self.assertIsNotNone(heard, "the server answers")
        loops = heard.status_reply.loops
        return [loop.ticks for loop in loops], loops[0].condition

    def does_not_notice(self, physics, harm):
        """For each number of descriptors around those in use: harm(observer of a guest) and what it did to the others."""
        asking, staying = self.peer(self.chief, self.port), self.comes_in(self.screen)
        process = physics.process.pid
        before = resource.prlimit(process, resource.RLIMIT_NOFILE)
        for more in range(-3, 4):
            few = f"with {more:+d} descriptors beside those in use"
            self.admit("observer", self.guest, "guest")
            guest = self.comes_in(self.guest)
            used = len(os.listdir(f"/proc/{process}/fd"))
            resource.prlimit(process, resource.RLIMIT_NOFILE, (used + more, before[1]))
            harm(guest)
            self.assertFalse(physics.ended(), f"{few}: {physics.lines()}")
            ticks, condition = self.loops(asking)
            wait_until(lambda: all(b > a + 100 for a, b in zip(ticks, self.loops(asking)[0])), f"the loops go on {few}")
            self.assertIn(condition.split(":")[0], ("ready", "running", "degraded"), few)
            self.assertTrue(self.serves(staying, SOON_S), few)
            resource.prlimit(process, resource.RLIMIT_NOFILE, before)
            coming = self.observer(self.screen)
            self.assertTrue(self.serves(coming, SOON_S), f"a new observer is served after a limit {few}")
            guest.socket.close()
            coming.socket.close()

    def start_server(self):
        self.mark_checked("openhaptics Simulated PHANToM 0042", "peak_n = 1.0")
        physics = self.start_physics("--listen", f"tcp://127.0.0.1:{self.port}", "--keys", self.keys, "--arm", "openhaptics")
        self.addCleanup(lambda: self.assertIn(physics.process.poll(), (None, 0), physics.lines()))
        return physics

    def test_a_key_that_is_taken_out_loses_its_states_and_nobody_else_does(self):
        physics = self.start_server()

        def revoke(guest):
            self.runs("keys", "revoke", "guest", "--keys", self.keys)
            wait_until(lambda: not self.serves(guest, 0.5), "the guest gets no more states")
        self.does_not_notice(physics, revoke)
        self.stop_in_order(physics)

    def test_an_observer_that_floods_the_server_does_not_end_it(self):
        physics = self.start_server()

        def flood(guest):
            for i in range(3000):
                try:
                    guest.socket.send(b"x" * (i % 400), zmq.DONTWAIT)
                    guest.say(subscribe=self.wire.Subscribe(rate_hz=i % 1100))
                except zmq.Again:
                    guest.hears(0.01)
            guest.socket.send(b"x" * 60000)
            topics = zmq.Context.instance().socket(zmq.SUB)  # as observers of earlier releases did
            topics.linger, topics.curve_serverkey = 0, self.server_key
            topics.curve_publickey, topics.curve_secretkey = self.guest
            for i in range(100):
                topics.subscribe(b"%d" % i + b"x" * 2000)
            topics.connect(f"tcp://127.0.0.1:{self.port + 1}")
            topics.poll(300)
            topics.close()
        self.does_not_notice(physics, flood)
        self.stop_in_order(physics)


if __name__ == "__main__":
    unittest.main()
