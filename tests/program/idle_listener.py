"""A listener behind a key that takes what comes and does nothing with it: idle_listener.py ADDRESS SECRET_KEY_FILE. Says "there" once it listens."""
import sys

import zmq
import zmq.auth.thread


def main(address, secret_file):
    with open(secret_file, encoding="ascii") as file:
        words = [word for line in file if line[0] != "#" for word in line.split() if len(word) == 40]
    context = zmq.Context()
    context.max_sockets = 1000
    gate = zmq.auth.thread.ThreadAuthenticator(context)
    gate.start()
    gate.configure_curve(domain="*", location=zmq.auth.CURVE_ALLOW_ANY)
    listening = context.socket(zmq.ROUTER)
    listening.curve_server, listening.curve_publickey, listening.curve_secretkey = True, *(word.encode() for word in words)
    listening.maxmsgsize = 65536
    listening.bind(address)
    print("there", flush=True)
    while True:
        listening.recv_multipart(copy=False)


main(*sys.argv[1:])
