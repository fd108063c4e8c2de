# SPDX-License-Identifier: BSD-2-Clause
"""Event channels of an MLCCA gateway, for programs in Python: verdicts with their reasons, and exceptions.

    with mlcca.Client() as client:
        stop = client.publisher("stop", Period="50ms")
        stop.on_exception = lambda exception: print(exception.cause.value, exception.text)
        print(stop.announce().state.value)
        while True:
            client.wait()

mlcca.aio has the same for asyncio. Events are sent and received by sockets of your own: libmlcca carries them, this
package does not yet.
"""
from mlcca.client import SOCKET, Channel, Client
from mlcca.types import Answer, Cause, ChannelException, Check, Delivery, State

__all__ = ["Answer", "Cause", "Channel", "ChannelException", "Check", "Client", "Delivery", "SOCKET", "State"]
