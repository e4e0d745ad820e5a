"""Messages of VRPN as bytes, from its public description; nothing of the program."""
import struct

COOKIE = b"vrpn: ver. 07.36  0".ljust(24, b"\0")
POSE, PING, PONG = "vrpn_Tracker Pos_Quat", "vrpn_Base ping_message", "vrpn_Base pong_message"


def packed(sender, kind, payload=b"", us=0):
    head = struct.pack(">IIIiiI", 24 + len(payload), us // 1_000_000, us % 1_000_000, sender, kind, 0)
    return head + payload + bytes(-len(payload) % 8)


def named(kind, number, name):
    return packed(number, kind, struct.pack(">I", len(name) + 1) + name.encode() + b"\0")


def posed(sender, kind, us, sensor, place, turn=(0.0, 0.0, 0.0, 1.0)):
    return packed(sender, kind, struct.pack(">ii7d", sensor, -1, *place, *turn), us)
