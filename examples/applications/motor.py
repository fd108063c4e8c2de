# SPDX-License-Identifier: BSD-2-Clause
"""A motor that runs as long as the heart-beat "stop" comes. It stops by itself when more events are missing than its
Omission allows, whatever becomes of the network, the gateway or the lever. The same as motor.cc."""
import sys
import time

import mlcca

LONGEST_SILENCE = 3 * 0.05 + 0.005  # (Omission + 1) * Period, and what the way may add; seconds


class Motor:
    def __init__(self):
        self.last, self.runs = 0.0, False

    def beat(self):
        self.last = time.monotonic()
        self.set(True)

    def check(self):
        """Called at least as often as the motor must react."""
        if time.monotonic() - self.last > LONGEST_SILENCE:
            self.set(False)

    def set(self, runs):
        if runs != self.runs:
            print("runs" if runs else "stops", flush=True)
        self.runs = runs


with mlcca.Client(*sys.argv[1:]) as client:
    motor = Motor()
    stop = client.subscriber("stop", Period="50ms", Omission=2)
    stop.on_event = lambda event: motor.beat()
    print("subscribed:", stop.subscribe().state.value, flush=True)
    while True:
        client.wait(0.01)
        motor.check()
