#!/usr/bin/env python3
"""What a server can do to a graphics server below any message: ZMTP by hand over TCP."""
import struct
import time
import unittest

from believing import MOST_GROWTH_MIB, BelievingTest
from fake_server import RawServer, frame
from program import free_port, resident_mib, wait_until


def trickle(server, connection):
    welcome = frame(0, server.welcome)
    while not server.over.is_set():
        for byte in welcome:
            connection.sendall(bytes((byte,)))
            if server.over.wait(0.02):
                return


def no_end(server, connection):
    part = frame(1, bytes(60000))
    for _ in range(5000):
        if server.over.is_set():
            return
        connection.sendall(part)


def no_end_of_small_parts(server, connection):
    parts = 1000 * frame(1, b"")
    for _ in range(3000):
        if server.over.is_set():
            return
        connection.sendall(parts)


def lying_length(server, connection):
    connection.sendall(b"\x02" + struct.pack("!Q", 2**63 - 1) + bytes(1 << 20))
    server.over.wait(0.3)


def signs_of_life(server, connection):
    while not server.over.is_set():
        connection.sendall(2000 * frame(4, b"\x04PING\0\0"))


def odd_commands(server, connection):
    connection.sendall(frame(4, b"\x05ERROR\x03\x1b[m") + frame(4, b"\xffx") + frame(4, b"") + frame(0xff, b"x"))
    server.over.wait(0.1)


def a_flood_and_gone(server, connection):
    """What ends libzmq 4.3.4 where its queue is full: signs of life behind many messages, and the connection's end."""
    messages = (65, 100, 129, 700, 3000)[server.connections % 5]
    connection.sendall(messages * frame(0, b"x") + 200 * frame(4, b"\x04PING\0\0"))
    server.over.wait((0.0, 0.01)[server.connections % 2])


RAW = (a_flood_and_gone, trickle, no_end, no_end_of_small_parts, lying_length, signs_of_life, odd_commands)


class HostileWire(BelievingTest):
    def test_a_graphics_server_goes_on_whatever_comes_over_its_connection(self):
        self.start_world()
        port = free_port()
        address = f"tcp://127.0.0.1:{port}"
        graphics, server = self.begins("--insecure", address=address)
        before = resident_mib(graphics.process.pid)
        for attack in RAW:
            server.stop()
            raw = RawServer(port, attack)
            raw.welcome = server.welcome().SerializeToString()
            wait_until(lambda raw=raw: raw.connections or graphics.ended(), "it connects again")
            most, until = 0.0, time.monotonic() + 1.5
            while time.monotonic() < until and not graphics.ended():
                most = max(most, resident_mib(graphics.process.pid))
                time.sleep(0.01)
            raw.stop()
            self.assertFalse(graphics.ended(), f"{attack}: {graphics.lines()}")
            self.assertLess(most, before + MOST_GROWTH_MIB, attack)
            server.start(address)
            self.recovers(graphics, server, attack)
        self.ends_at_once(graphics)


if __name__ == "__main__":
    unittest.main()
