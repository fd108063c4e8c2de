# SPDX-License-Identifier: BSD-2-Clause
"""A program on the laptop that hears the emergency switch, and prints what it is told of its channel."""
import mlcca

with mlcca.Client() as client:
    switch = client.subscriber("emergency-switch", Period="50ms", Omission=2)
    switch.on_exception = lambda exception: print(f"brake: exception {exception.cause.value}: {exception.answer.reason}",
                                                  flush=True)
    answer = switch.subscribe()
    print(f"brake: subscribed: {answer.state.value}", flush=True)
    while True:
        client.wait()
