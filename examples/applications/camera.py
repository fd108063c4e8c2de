# SPDX-License-Identifier: BSD-2-Clause
"""A camera whose channel has two attribute sets: a picture every 20 ms, or every 80 ms where the networks carry no more. It
follows the exceptions "degraded" and "upgraded". The same as camera.cc."""
import sys
import time

import mlcca

PERIODS = (0.02, 0.08)  # seconds, of each attribute set in the description, the preferred one first
PICTURE = bytes(1000)


def period_of(answer):
    """Of the set in use; while nothing is granted nothing is sent, and the preferred one is as good as any."""
    return PERIODS[max((d.attribute_set for d in answer.deliveries if d.granted), default=0)]


with mlcca.Client(*sys.argv[1:]) as client:
    video = client.publisher("video")

    def on_exception(exception):
        print(f"{exception.cause.value}: {exception.answer.state.value}, every {period_of(exception.answer) * 1e3:.0f} ms",
              flush=True)

    video.on_exception = on_exception
    answer = video.announce()
    print(f"announced: {answer.state.value}, every {period_of(answer) * 1e3:.0f} ms", flush=True)
    due = time.monotonic()
    while True:
        video.publish(PICTURE)
        # A picture that is late is not caught up with: two at once would be more than is granted.
        due = max(due + period_of(video.answer), time.monotonic())
        while (left := due - time.monotonic()) > 0:
            client.wait(left)
