#!/usr/bin/env python3
"""What a connection can do to the physics server below any library: ZMTP 3.1 (ZeroMQ RFC 37) by hand, over the private socket."""
import os
import socket
import struct
import unittest

from laboratory import LaboratoryTest
from program import resident_mib, wait_until


def frame(flags, body):
    return bytes((flags, len(body))) + body


def command(name, data):
    return frame(4, bytes((len(name),)) + name + data)


def greeted(path):
    """A connection that passes for a DEALER's."""
    peer = socket.socket(socket.AF_UNIX)
    peer.settimeout(10.0)
    peer.connect(path)
    peer.sendall(b"\xff" + bytes(8) + b"\x7f\x03\x01" + b"NULL".ljust(20, b"\0") + bytes(32))
    greeting = b""
    while len(greeting) < 64:
        greeting += peer.recv(64 - len(greeting))
    peer.sendall(command(b"READY", b"\x0bSocket-Type" + struct.pack("!I", 6) + b"DEALER"))
    peer.recv(4096)
    return peer


class HostilePeers(LaboratoryTest):
    def test_a_message_without_an_end_leaves_no_memory_behind(self):
        self.environment.update(PALPATE_LIBHD=os.environ["HD_STUB"], HD_STUB_STATE=os.path.join(self.root, "state"))
        physics = self.start_physics("--arm", "openhaptics")
        place = os.path.join(self.meeting, "palpate", "physics.sock")
        before = resident_mib(physics.process.pid)
        for _ in range(2):
            peer = greeted(place)
            part = b"\x03" + struct.pack("!Q", 4000) + bytes(4000)  # more follow
            try:
                while resident_mib(physics.process.pid) < before + 256:
                    peer.sendall(200 * part)
            except OSError:
                pass  # on a slow machine its signs of life have gone unanswered for too long, and the server has ended it
            peer.close()
            self.assertFalse(physics.ended(), physics.lines())
            wait_until(lambda: resident_mib(physics.process.pid) < before + 96, "the memory comes back")  # malloc keeps up to 64
        self.stop_in_order(physics)

    def test_many_messages_signs_of_life_and_gone_do_not_end_the_server(self):
        self.environment.update(PALPATE_LIBHD=os.environ["HD_STUB"], HD_STUB_STATE=os.path.join(self.root, "state"))
        physics = self.start_physics("--arm", "openhaptics")
        place = os.path.join(self.meeting, "palpate", "physics.sock")
        for path in (place, place + ".states"):
            for count in (10, 100, 700, 3000):
                for _ in range(10):
                    peer = greeted(path)
                    peer.setblocking(False)
                    # One write, so that the end of the connection is there before the messages have been read.
                    peer.send(frame(0, b"x") * count + command(b"PING", b"\0\0") * 200)
                    peer.close()
                    self.assertFalse(physics.ended(), f"{path}, {count} messages: {physics.lines()}")
        self.runs("status", "--once")
        self.stop_in_order(physics)


if __name__ == "__main__":
    unittest.main()
