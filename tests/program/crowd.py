"""Many connections to a physics server at once, as a process of its own: crowd.py WHAT HOW_MANY ADDRESS [SERVER_KEY PUBLIC SECRET].

WHAT: strangers (bare connections that come again when they are cut off), silent (a key's, nothing is said), talking (they say Hello),
flood-BYTES (messages of that size as quickly as they go), flood-hello (the same with Hello). Says "there" once it has begun; until it is killed."""
import resource
import selectors
import socket
import struct
import sys
import time

import zmq


def hello(client):
    """ToPhysics {protocol: 2, hello {client, name: "crowd"}}, written by hand."""
    body = b"\x09" + struct.pack("<Q", client) + b"\x1a\x05crowd"
    return b"\x08\x02\x12" + bytes((len(body),)) + body


def strangers(many, host, port):
    waiting = selectors.DefaultSelector()

    def come():
        one = socket.socket()
        one.setblocking(False)
        one.connect_ex((host, port))
        waiting.register(one, selectors.EVENT_READ)
    for _ in range(many):
        come()
    print("there", flush=True)
    while True:
        for key, _ in waiting.select(1.0):
            try:
                gone = not key.fileobj.recv(4096)
            except OSError:
                gone = True
            if gone:
                waiting.unregister(key.fileobj)
                key.fileobj.close()
                time.sleep(0.001)
                come()


def peers(many, address, keys):
    context = zmq.Context()
    context.max_sockets = many + 8
    made = []
    for _ in range(many):
        peer = context.socket(zmq.DEALER)
        peer.linger, peer.immediate, peer.reconnect_ivl = 0, 1, 50
        if keys:
            peer.curve_serverkey, peer.curve_publickey, peer.curve_secretkey = (key.encode() for key in keys)
        peer.connect(address)
        made.append(peer)
    print("there", flush=True)
    return made


def send(peer, *frames):
    try:
        peer.send_multipart(frames, zmq.DONTWAIT)
        while peer.poll(0):
            peer.recv(zmq.DONTWAIT)
    except zmq.Again:
        return False
    return True


def main(what, many, address, *keys):
    resource.setrlimit(resource.RLIMIT_NOFILE, (resource.getrlimit(resource.RLIMIT_NOFILE)[1],) * 2)
    many = int(many)
    if what == "strangers":
        host, port = address.removeprefix("tcp://").split(":")
        strangers(many, host, int(port))
    made = peers(many, address, keys)
    while what in ("silent", "talking"):
        for client, peer in enumerate(made):
            if what == "talking":
                send(peer, hello(client + 1))
        time.sleep(0.2)
    text = hello(1) if what == "flood-hello" else b"x" * int(what.split("-")[1])
    while True:
        sent = False
        for peer in made:
            try:
                peer.send(text, zmq.DONTWAIT)
                sent = True
            except zmq.Again:
                continue
        if not sent:
            time.sleep(0.001)


main(*sys.argv[1:])
