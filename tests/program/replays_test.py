#!/usr/bin/env python3
"""What an operator has said over an encrypted connection, said again by somebody who has only listened, or altered by somebody in the middle: no wish is
carried out twice, none that was not made, no state is believed twice, and the server goes on for the others."""
import contextlib
import socket
import threading
import unittest

import zmq

from guarded import GuardedServerTest, Peer
from program import free_port, wait_until

GREETING = 64


class Middle:
    """Between a client and the server, connection after connection: keeps what the client says; `alter(frames)`, where given, gets each frame that comes in
    the direction "up" or "down" after the handshake, and returns those that go on."""

    def __init__(self, port, up=None, down=None):
        self.port, self.alter, self.said = port, {"up": up, "down": down}, []
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.address = f"tcp://127.0.0.1:{self.listener.getsockname()[1]}"
        self.open = [self.listener]
        threading.Thread(target=self._accept, daemon=True).start()

    def close(self):
        for one in self.open:
            with contextlib.suppress(OSError):
                one.shutdown(socket.SHUT_RDWR)
            one.close()

    def _accept(self):
        while True:
            try:
                client = self.listener.accept()[0]
                server = socket.create_connection(("127.0.0.1", self.port))
            except OSError:
                return
            self.open += [client, server]
            self.said.append(bytearray())
            for way, source, sink in (("up", client, server), ("down", server, client)):
                threading.Thread(target=self._carry, args=(way, source, sink, self.said[-1]), daemon=True).start()

    def _carry(self, way, source, sink, said):
        waiting, greeting, alter, handshake = bytearray(), GREETING, self.alter[way], 2  # frames of the handshake each way
        try:
            while part := source.recv(65536):
                if way == "up":
                    said += part
                at_once = len(part) if not alter else min(greeting, len(part))
                sink.sendall(part[:at_once])  # of the greeting each side waits for the other's first bytes
                greeting -= at_once
                waiting += part[at_once:]
                while size := whole_frame(waiting):
                    one = bytes(waiting[:size])
                    del waiting[:size]
                    for altered in alter(one) if handshake <= 0 else (one,):
                        sink.sendall(altered)
                    handshake -= 1
        except OSError:
            pass
        for one in (source, sink):
            with contextlib.suppress(OSError):
                one.shutdown(socket.SHUT_RDWR)


def whole_frame(waiting):
    """Bytes of the frame that `waiting` begins with; 0: it is not whole."""
    if len(waiting) < 2:
        return 0
    size = 2 + waiting[1] if not waiting[0] & 2 else 9 + int.from_bytes(waiting[1:9], "big") if len(waiting) >= 9 else 1 << 62
    return size if len(waiting) >= size else 0


class Each:
    """Does something to every n-th frame."""

    def __init__(self, what, every=2):
        self.what, self.every, self.count, self.kept, self.done = what, every, 0, b"", 0

    def __call__(self, one):
        self.count += 1
        if self.count % self.every:
            hold = self.what == "swap" and self.count % self.every == self.every - 1
            self.kept = one
            return () if hold else (one,)
        self.done += 1
        return {"double": (one, one), "drop": (), "again": (one, self.kept), "cut": (one[:-5],), "swap": (one, self.kept), "flip": (one[:-3] + bytes((one[-3] ^ 1,)) + one[-2:],),
                "longer": (one[:1] + bytes((min(255, one[1] + 1),)) + one[2:] + b"x",)}[self.what]


class Replays(GuardedServerTest):
    def controls(self):
        """Wishes that the server has carried out."""
        asking = self.peer(self.chief, self.port)
        controls = self.status(asking).controls
        asking.socket.close()
        return controls

    def operator(self, address):
        peer = Peer(self.wire, address, self.server_key, self.chief)
        self.addCleanup(peer.socket.close)
        return peer

    def wishes(self, operator, number, longest_s=5.0):
        """Whether the wish was answered."""
        operator.say(hello=self.wire.Hello(client=77, name="chief"))
        operator.say(control_call=self.wire.ControlCall(client=77, number=number, control=self.wire.CONTROL_RESET))
        while heard := operator.hears(longest_s):
            if heard.WhichOneof("body") == "control_reply":
                return True
        return False

    def say_again(self, recorded):
        """The whole, and pieces of it."""
        for piece in (recorded, recorded[:GREETING], recorded[GREETING:], recorded[:len(recorded) // 2], recorded + recorded[GREETING:], recorded[:GREETING] + recorded[-200:]):
            with socket.create_connection(("127.0.0.1", self.port)) as connection, contextlib.suppress(OSError):
                parts, rest = [piece[:GREETING]], piece[GREETING:]
                while size := whole_frame(rest):
                    parts.append(rest[:size])
                    rest = rest[size:]
                for part in (*parts, rest):  # each as it came, with time for an answer
                    connection.sendall(part)
                    connection.settimeout(0.05)
                    with contextlib.suppress(TimeoutError):
                        connection.recv(65536)

    def recording(self):
        """What an operator says with a wish; the wish has been carried out."""
        middle = Middle(self.port)
        self.addCleanup(middle.close)
        operator = self.operator(middle.address)
        before = self.controls()
        self.assertTrue(self.wishes(operator, 1))
        wait_until(lambda: self.controls() == before + 1, "the wish is carried out")
        return operator, bytes(middle.said[-1])

    def test_a_recording_carries_nothing_out(self):
        physics = self.start_server()
        operator, recorded = self.recording()
        before = self.controls()
        self.say_again(recorded)
        self.assertEqual(self.controls(), before, "while its client is there")
        operator.socket.close()
        self.say_again(recorded)
        self.assertEqual(self.controls(), before, "when its client has gone")
        self.stop_in_order(physics)
        self.port = free_port()
        physics = self.start_physics("--listen", f"tcp://127.0.0.1:{self.port}", "--keys", self.keys, "--arm", "openhaptics")
        self.say_again(recorded)
        self.assertEqual(self.controls(), 0, "to another life of the server")
        self.stop_in_order(physics)

    def test_who_is_in_the_middle_carries_out_nothing_and_shows_nothing_twice(self):
        physics = self.start_server()
        watching = self.comes_in(self.screen)
        for what in ("double", "again", "swap", "drop", "cut", "flip", "longer"):
            up, down = Each(what), Each(what)
            for alter in ({"up": up}, {"down": down}):
                before = self.controls()
                middle = Middle(self.port, **alter)
                operator = self.operator(middle.address)
                seen = []
                for number in range(1, 5):
                    operator.say(hello=self.wire.Hello(client=1000, name="chief"))
                    operator.say(control_call=self.wire.ControlCall(client=1000 + before, number=number, control=self.wire.CONTROL_RESET))
                    operator.say(state_request=self.wire.StateRequest(number=number, time_ns=1))
                    while heard := operator.hears(0.05):
                        if heard.WhichOneof("body") == "state_reply":
                            seen.append(heard.state_reply.number)
                operator.socket.close()
                middle.close()
                with self.subTest(what=what, way=list(alter)):
                    self.assertGreater(up.done + down.done, 0)
                    self.assertLessEqual(self.controls(), before + 4)
                    self.assertEqual(sorted(set(seen)), sorted(seen))
                    self.assertTrue(self.serves(watching, 5.0))
        self.assertFalse(physics.ended(), physics.lines())
        self.stop_in_order(physics)

    def test_without_encryption_the_same_recording_is_heard(self):
        """Else the tests above would show nothing."""
        self.mark_checked("openhaptics Simulated PHANToM 0042", "peak_n = 1.0")
        start = ("--listen", f"tcp://127.0.0.1:{self.port}", "--insecure", "--arm", "openhaptics")

        def plain(address):
            peer = Peer.__new__(Peer)
            peer.wire, peer.socket = self.wire, zmq.Context.instance().socket(zmq.DEALER)
            peer.socket.linger, peer.socket.sndtimeo = 0, 200
            peer.socket.connect(address)
            self.addCleanup(peer.socket.close)
            return peer
        self.peer = lambda pair, port: plain(f"tcp://127.0.0.1:{port}")
        self.operator = plain
        physics = self.start_physics(*start)
        _, recorded = self.recording()
        physics.remove()
        self.port = free_port()
        physics = self.start_physics("--listen", f"tcp://127.0.0.1:{self.port}", *start[2:])
        self.say_again(recorded)
        wait_until(lambda: self.controls() > 0, "the wish is carried out again")


if __name__ == "__main__":
    unittest.main()
