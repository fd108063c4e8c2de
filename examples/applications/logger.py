# SPDX-License-Identifier: BSD-2-Clause
"""Prints the events of channels, one in a line: when it came, from where, channel, octets; and what happens to the channels,
to the standard error. The same as logger.cc. Usage: logger.py SOCKET CHANNEL…"""
import sys

import mlcca

MOST_OCTETS = 16  # of an event that are printed


def follow(client, name):
    channel = client.subscriber(name)

    def on_event(event):
        octets = event.data[:MOST_OCTETS].hex() + ("…" if len(event.data) > MOST_OCTETS else "")
        print(f"{event.received_ns / 1e9:.6f} {event.network or 'here'} {name} {octets}", flush=True)

    def on_exception(exception):
        print(f"{name}: {exception.cause.value}: {exception.text}", file=sys.stderr, flush=True)

    channel.on_event, channel.on_exception = on_event, on_exception
    answer = channel.subscribe()
    print(f"{name}: {answer.state.value}, {answer.reason}", file=sys.stderr, flush=True)
    return channel


with mlcca.Client(sys.argv[1]) as client:
    channels = [follow(client, name) for name in sys.argv[2:]]
    while True:
        client.wait()
