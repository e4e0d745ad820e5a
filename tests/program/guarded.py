"""A physics server behind keys, and peers of it that speak its messages by themselves, for the tests of ill will."""
import os
import subprocess
import sys
import time

import zmq

from laboratory import LaboratoryTest
from program import free_port, wait_until

HERE = os.path.dirname(os.path.abspath(__file__))


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


class GuardedServerTest(LaboratoryTest):
    def setUp(self):
        super().setUp()
        self.wire, self.keys, self.port = self.wire_messages(), self.path("keys"), free_port()
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

    def status(self, asking, within_s=10.0):
        """How the server is; asked again and again, as a client does: a busy server may end a connection that is new."""
        until = time.monotonic() + within_s
        while time.monotonic() < until:
            self.number += 1
            asking.say(status_request=self.wire.StatusRequest(number=self.number))
            if heard := asking.hears(min(0.5, within_s)):
                return heard.status_reply
        return self.fail(f"the server does not answer within {within_s} s")

    def loops(self, asking):
        """Ticks of haptic and physics loop, and whether forces are as they should be."""
        loops = self.status(asking).loops
        return [loop.ticks for loop in loops], loops[0].condition

    def start_server(self):
        self.mark_checked("openhaptics Simulated PHANToM 0042", "peak_n = 1.0")
        physics = self.start_physics("--listen", f"tcp://127.0.0.1:{self.port}", "--keys", self.keys, "--arm", "openhaptics")
        self.addCleanup(lambda: self.assertIn(physics.process.poll(), (None, 0), physics.lines()))
        return physics

    def crowd(self, what, many, address, *keys):
        crowd = subprocess.Popen([sys.executable, os.path.join(HERE, "crowd.py"), what, str(many), address, *keys], stdout=subprocess.PIPE, text=True)

        def leave():
            crowd.kill()
            crowd.wait()
            crowd.stdout.close()
        self.addCleanup(leave)
        self.assertEqual(crowd.stdout.readline(), "there\n")
        return leave

    def with_keys(self, pair):
        return [key.decode() for key in (self.server_key, *pair)]
