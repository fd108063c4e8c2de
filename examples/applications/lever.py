# SPDX-License-Identifier: BSD-2-Clause
"""The lever of an emergency stop: a program on the gateway that publishes the heart-beat "stop" every 50 ms, as long as the
lever is not pulled, and prints what is decided for it. The same as lever.cc."""
import sys
import time

import mlcca

PERIOD = 0.05  # seconds


def is_pulled():
    """Of the machine that this is to run on."""
    return False


def show(what, answer):
    print(f"{what}: {answer.state.value}, {answer.reason}", flush=True)


with mlcca.Client(*sys.argv[1:]) as client:
    stop = client.publisher("stop", Period="50ms", Omission=2)
    stop.on_exception = lambda exception: show(exception.cause.value, exception.answer)
    show("announced", stop.announce())
    due = time.monotonic()
    while True:
        # What is not granted is not sent: the machine stands still, and the exception says why.
        if not is_pulled():
            stop.publish(b"go")
        # A beat that is late is not caught up with: many at once would be more than is granted.
        due = max(due + PERIOD, time.monotonic())
        while (left := due - time.monotonic()) > 0:
            client.wait(left)
