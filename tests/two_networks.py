#!/usr/bin/env python3
"""Whether this user, on this kernel, may make a network of its own with one end of a cable in it; else says why, and exits 1."""
import ctypes
import os
import socket
import struct
import sys

CLONE_NEWNET = 0x40000000
RTM_NEWLINK, NLM_F_REQUEST, NLM_F_ACK, NLM_F_CREATE = 16, 1, 4, 0x400
IFLA_LINKINFO, IFLA_INFO_KIND = 18, 1


def attribute(kind, value):
    return struct.pack("=HH", 4 + len(value), kind) + value + bytes(-len(value) % 4)


def main():
    libc = ctypes.CDLL(None, use_errno=True)
    if libc.unshare(CLONE_NEWNET) != 0:  # for as long as this process lives
        return f"this user may not make networks ({os.strerror(ctypes.get_errno())})"
    wish = bytes(16) + attribute(IFLA_LINKINFO, attribute(IFLA_INFO_KIND, b"veth"))
    header = struct.pack("=IHHII", 16 + len(wish), RTM_NEWLINK, NLM_F_REQUEST | NLM_F_ACK | NLM_F_CREATE, 1, 0)
    with socket.socket(socket.AF_NETLINK, socket.SOCK_RAW, 0) as link:
        link.send(header + wish)
        error = -struct.unpack_from("=i", link.recv(4096), 16)[0]
    return f"the kernel lays no cables (veth: {os.strerror(error)})" if error else None


sys.exit(main())
