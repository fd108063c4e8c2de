# SPDX-License-Identifier: BSD-2-Clause
"""Event channels of an MLCCA gateway, for programs in Python: verdicts with their reasons, events, and exceptions.

    with mlcca.Client() as client:
        stop = client.publisher("stop", Period="50ms")
        stop.on_exception = lambda exception: print(exception.cause.value, exception.text)
        print(stop.announce().state.value)
        while True:
            stop.publish(b"go")
            client.wait(0.05)

mlcca.aio has the same for asyncio. The sockets that carry the events are those of libmlcca.
"""
from mlcca.client import SOCKET, Channel, Client, PublisherChannel, SubscriberChannel
from mlcca.types import Answer, Cause, ChannelException, Check, Delivery, Event, Published, State

__all__ = ["Answer", "Cause", "Channel", "ChannelException", "Check", "Client", "Delivery", "Event", "Published",
           "PublisherChannel", "SOCKET", "State", "SubscriberChannel"]
