# SPDX-License-Identifier: BSD-2-Clause
"""The rover's computer: it takes the scans of the lidar and states how fast the motors may turn, and prints when that changes.
While no scan comes the limit is 0: what is not seen is taken for an obstacle."""
import sys
import time

import mlcca

PERIOD = 0.05        # seconds, of "speed-limit" in the description
LONGEST_GAP = 0.3    # seconds without a scan
NEAR, FAR = 50, 200  # centimetres
FASTEST = 250        # of the motors


def limit_of(scan):
    """0 below NEAR, FASTEST from FAR on, and in between in proportion."""
    nearest = min(scan, default=0)
    return max(0, min(FASTEST, FASTEST * (nearest - NEAR) // (FAR - NEAR)))


with mlcca.Client(*sys.argv[1:]) as client:
    limit, seen = 0, 0.0

    def on_scan(event):
        global limit, seen
        limit, seen = limit_of(event.data), time.monotonic()

    def on_exception(exception):
        print(f"{exception.cause.value}: {exception.answer.reason}", flush=True)

    scans = client.subscriber("scan")
    scans.on_event, scans.on_exception = on_scan, on_exception
    limits = client.publisher("speed-limit", Period="50ms", Omission=2)
    limits.on_exception = on_exception
    print("scan:", scans.subscribe().state.value, flush=True)
    print("speed-limit:", limits.announce().state.value, flush=True)
    stated, due = None, time.monotonic()
    while True:
        now = limit if time.monotonic() - seen <= LONGEST_GAP else 0
        limits.publish(bytes([now]) + b"\xff" * 7)
        if now != stated:
            print("limit", now, flush=True)
        stated = now
        due = max(due + PERIOD, time.monotonic())
        while (left := due - time.monotonic()) > 0:
            client.wait(left)
