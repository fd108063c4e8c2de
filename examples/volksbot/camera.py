# SPDX-License-Identifier: BSD-2-Clause
"""camera.py CHANNEL: a camera of the demo, a program on the laptop. It publishes numbered packets of pictures, as often as
the attribute set allows that is granted, prints what it is told, and on SIGTERM how many packets it has published."""
import signal
import sys
import time

import mlcca

PERIODS = (0.016, 0.064)  # seconds, of each attribute set in the description, the preferred one first
name = sys.argv[1]
published = 0


def granted_set(answer):
    """The set in use; None: nothing is granted."""
    return max((d.attribute_set for d in answer.deliveries if d.granted), default=None)


def say(what, answer):
    which = granted_set(answer)
    use = "no pictures" if which is None else f"a packet every {PERIODS[which] * 1e3:.0f} ms"
    print(f"{name}: {what}: {use}", flush=True)


def end(*_):
    print(f"{name}: published {published}", flush=True)
    sys.exit(0)


signal.signal(signal.SIGTERM, end)
with mlcca.Client() as client:
    video = client.publisher(name)
    video.on_exception = lambda exception: say(f"exception {exception.cause.value}", exception.answer)
    say("announced", video.announce())
    due = time.monotonic()
    while True:
        which = granted_set(video.answer)
        if which is not None and video.publish(b"%07d" % published + bytes(1343)) is mlcca.Published.SENT:
            published += 1
        due = max(due + PERIODS[which or 0], time.monotonic())
        while (left := due - time.monotonic()) > 0:
            client.wait(left)
