#!/usr/bin/env python3
"""What a connection can do to the physics server below any library: ZMTP 3.1 (ZeroMQ RFC 37) by hand, over the private socket."""
import os
import socket
import struct
import unittest

from laboratory import LaboratoryTest


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
