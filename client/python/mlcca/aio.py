# SPDX-License-Identifier: BSD-2-Clause
"""The client for asyncio: announce() is awaited, and events and exceptions are iterated over."""
from __future__ import annotations

import asyncio
import time
from typing import AsyncIterator, Optional

from mlcca.client import SOCKET
from mlcca.session import LONGER, Part, ProtocolError, Role, Session, shortened
from mlcca.types import Answer, ChannelException, Event, EventData, Published, State

LATE = 0.2  # s; a loop that calls a timer later than this was blocked


class Channel:
    """The common base of publishers and subscribers."""

    def __init__(self, client: "Client", part: Part) -> None:
        self._client = client
        self._part = part

    @property
    def answer(self) -> Answer:
        """The latest known decision."""
        return self._part.answer

    async def exceptions(self) -> AsyncIterator[ChannelException]:
        """Yields exceptions without end. At most 256 are kept until they are taken; then Cause.LAGGED is reported."""
        while True:
            while self._part.waits():
                yield self._part.take_exception()
            await self._client._changed()

    def close(self) -> None:
        """Ends the channel: it is not announced any more."""
        self._client._forget(self._part)


class PublisherChannel(Channel):
    """The publisher of an event channel; made by Client.publisher()."""

    async def announce(self) -> Answer:
        """Announces the publisher, like mlcca.PublisherChannel.announce()."""
        return await self._client._take_up(self._part)

    def publish(self, event: EventData) -> Published:
        """Sends an event without waiting, like mlcca.PublisherChannel.publish()."""
        return self._client._session.sockets.publish(self._part.number, event)


class SubscriberChannel(Channel):
    """The subscriber of an event channel; made by Client.subscriber()."""

    async def subscribe(self) -> Answer:
        """Announces the subscriber, like mlcca.PublisherChannel.announce()."""
        return await self._client._take_up(self._part)

    async def events(self) -> AsyncIterator[Event]:
        """Yields events without end. At most 1,024 are kept until they are taken; further ones are lost, see `lost`."""
        while True:
            while self._part.events:
                yield self._part.events.popleft()
            await self._client._changed()

    @property
    def lost(self) -> int:
        """How much was lost, including events that were not taken in time; see mlcca.SubscriberChannel.lost."""
        return self._client._session.sockets.lost_of(self._part.number) + self._part.untaken


class Client:
    """A connection to mlccad, used as `async with Client() as client`: a task of the running loop maintains it.

    The arguments have the same meaning as for mlcca.Client.
    """

    def __init__(self, path: str = SOCKET, *, patience: float = 10, first_retry: float = 0.1, longest_retry: float = 1,
                 answers_within: float = 5) -> None:
        self._path, self._patience = path, patience
        self._first_retry, self._longest_retry = first_retry, max(first_retry, longest_retry)
        self._session = Session(answers_within)
        self._writer: Optional[asyncio.StreamWriter] = None
        self._task: Optional[asyncio.Task[None]] = None
        self._change = asyncio.Event()
        self._wanted = asyncio.Event()  # set when something is announced
        self._hurry = asyncio.Event()   # set when somebody waits for a connection
        self._again: Optional[asyncio.TimerHandle] = None  # timer to ask again for channels that failed
        self._supervision: Optional[asyncio.TimerHandle] = None
        self._losses = 0

    def publisher(self, channel: str, name: str = "", **stated: int | str) -> PublisherChannel:
        """Makes a publisher, like mlcca.Client.publisher()."""
        return PublisherChannel(self, Part(channel, Role.PUBLISHER, name, stated))

    def subscriber(self, channel: str, name: str = "", **stated: int | str) -> SubscriberChannel:
        """Makes a subscriber, like mlcca.Client.subscriber()."""
        return SubscriberChannel(self, Part(channel, Role.SUBSCRIBER, name, stated))

    @property
    def lost(self) -> int:
        """How much was lost of all channels, including events that were not taken in time; see mlcca.Client.lost."""
        return self._session.losses

    async def __aenter__(self) -> "Client":
        asyncio.get_running_loop().add_reader(self._session.sockets.fileno(), self._take_events)
        self._task = asyncio.create_task(self._run())
        return self

    async def __aexit__(self, *_: object) -> None:
        assert self._task is not None
        self._task.cancel()
        await asyncio.gather(self._task, return_exceptions=True)
        asyncio.get_running_loop().remove_reader(self._session.sockets.fileno())
        self._session.sockets.close()

    async def _take_up(self, part: Part) -> Answer:
        self._session.add(part)
        part.lost = False
        losses = self._losses
        if self._writer:
            self._session.ask_again(part)
            self._send()
        self._wanted.set()
        self._hurry.set()
        try:
            async with asyncio.timeout(self._patience):
                while self._losses == losses and (part.asked != 0 or not self._writer):
                    await self._changed()
        except TimeoutError:
            part.lost = True  # so that an answer that comes later is reported
            part.answer = Answer(State.NO_DAEMON, f"no answer from mlccad within {self._patience:g} s")
        return part.answer

    def _forget(self, part: Part) -> None:
        self._session.remove(part)

    def _take_events(self) -> None:
        self._session.take_events()
        self._wake()

    async def _changed(self) -> None:
        await self._change.wait()

    def _wake(self) -> None:
        """Wakes all that wait for a change; each checks whether it concerns them."""
        self._change.set()
        self._change = asyncio.Event()

    def _send(self) -> None:
        if self._writer and self._session.out:
            self._writer.write(bytes(self._session.out))
            self._session.out.clear()

    def _ask_failed(self) -> None:
        self._again = None
        if self._writer:
            self._session.ask_failed()
            self._send()

    def _ask_failed_in(self, seconds: float) -> None:
        """Asks once, even if it is called several times, and not later than planned before."""
        loop = asyncio.get_running_loop()
        if self._again is not None:
            if self._again.when() <= loop.time() + seconds:
                return
            self._again.cancel()
        self._again = loop.call_later(seconds, self._ask_failed)

    def _supervise_later(self) -> None:
        due = self._session.due
        if due is not None and self._supervision is None:
            self._supervision = asyncio.get_running_loop().call_later(max(due - time.monotonic(), 0), self._supervise, due)

    def _supervise(self, due: float) -> None:
        self._supervision = None
        if time.monotonic() - due > LATE:  # the loop was late itself: what has come is received first
            self._supervision = asyncio.get_running_loop().call_later(LATE / 2, self._supervise, time.monotonic() + LATE / 2)
            return
        if self._session.supervise():
            self._wake()
        self._send()
        self._supervise_later()

    def _supervise_no_more(self) -> None:
        if self._supervision is not None:
            self._supervision.cancel()
        self._supervision = None

    async def _pause(self, seconds: float) -> None:
        try:
            async with asyncio.timeout(seconds):
                await self._hurry.wait()
        except TimeoutError:
            pass

    async def _run(self) -> None:
        retry = self._first_retry
        while True:
            await self._wanted.wait()
            why = "mlccad closed the connection"
            try:
                reader, self._writer = await asyncio.open_unix_connection(self._path)
                self._session.connected()
                self._send()
                self._supervise_later()
                while data := await reader.read(1 << 16):
                    retry = self._first_retry
                    self._session.receive(data)
                    self._send()
                    self._supervise_later()
                    self._wake()
                    if self._session.failed:
                        self._ask_failed_in(retry if self._session.retry_soon else LONGER * self._longest_retry)
            except ProtocolError as wrong:
                why = str(wrong)
            except OSError as error:
                cause = error.strerror or str(error)
                why = cause if self._writer else f"no daemon: {self._path}: {cause}"
            finally:
                self._supervise_no_more()
                if self._writer:
                    self._writer.close()
                self._writer = None
            self._session.lost(why)
            self._losses += 1
            self._hurry.clear()
            self._wake()
            await self._pause(shortened(retry))
            retry = min(retry * 2, self._longest_retry)
