# SPDX-License-Identifier: BSD-2-Clause
"""The same for asyncio: announce() is awaited, and events and exceptions are iterated over."""
from __future__ import annotations

import asyncio
from typing import AsyncIterator, Optional

from mlcca.client import SOCKET
from mlcca.session import Part, ProtocolError, Role, Session
from mlcca.types import Answer, ChannelException, Event, Published, State


class Channel:
    """What a publisher and a subscriber of a program have in common."""

    def __init__(self, client: "Client", part: Part) -> None:
        self._client = client
        self._part = part

    @property
    def answer(self) -> Answer:
        return self._part.answer

    async def exceptions(self) -> AsyncIterator[ChannelException]:
        """Without end; what came before is kept."""
        while True:
            while self._part.waits():
                yield self._part.take_exception()
            await self._client._changed()

    def close(self) -> None:
        """Nothing happens to it any more."""
        self._client._forget(self._part)


class PublisherChannel(Channel):
    """It is made by Client.publisher()."""

    async def announce(self) -> Answer:
        """As mlcca.PublisherChannel.announce()."""
        return await self._client._take_up(self._part)

    def publish(self, event: bytes) -> Published:
        """As mlcca.PublisherChannel.publish(): it never waits."""
        return self._client._session.sockets.publish(self._part.number, event)


class SubscriberChannel(Channel):
    """It is made by Client.subscriber()."""

    async def subscribe(self) -> Answer:
        """As mlcca.PublisherChannel.announce()."""
        return await self._client._take_up(self._part)

    async def events(self) -> AsyncIterator[Event]:
        """Without end. At most 1,024 wait to be taken; those that come then are lost, see `lost`."""
        while True:
            while self._part.events:
                yield self._part.events.popleft()
            await self._client._changed()

    @property
    def lost(self) -> int:
        """As mlcca.SubscriberChannel.lost, and events that were not taken in time."""
        return self._client._session.sockets.lost() + self._part.untaken


class Client:
    """`async with Client() as client`: the connection lives in a task of the running loop."""

    def __init__(self, path: str = SOCKET, patience: float = 10, first_retry: float = 0.1, longest_retry: float = 5) -> None:
        self._path, self._patience = path, patience
        self._first_retry, self._longest_retry = first_retry, max(first_retry, longest_retry)
        self._session = Session()
        self._writer: Optional[asyncio.StreamWriter] = None
        self._task: Optional[asyncio.Task[None]] = None
        self._change = asyncio.Event()
        self._wanted = asyncio.Event()  # something is announced
        self._hurry = asyncio.Event()   # somebody waits for a connection
        self._again: Optional[asyncio.TimerHandle] = None  # asks those that failed
        self._losses = 0

    def publisher(self, channel: str, name: str = "", **stated: int | str) -> PublisherChannel:
        """As mlcca.Client.publisher()."""
        return PublisherChannel(self, Part(channel, Role.PUBLISHER, name, stated))

    def subscriber(self, channel: str, name: str = "", **stated: int | str) -> SubscriberChannel:
        """As mlcca.Client.publisher()."""
        return SubscriberChannel(self, Part(channel, Role.SUBSCRIBER, name, stated))

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
            part.lost = True  # the answer may come later
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
        """Whoever waits for a change looks whether it is theirs."""
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
        """Once, however often it is called meanwhile, and no later than planned."""
        loop = asyncio.get_running_loop()
        if self._again is not None:
            if self._again.when() <= loop.time() + seconds:
                return
            self._again.cancel()
        self._again = loop.call_later(seconds, self._ask_failed)

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
                while data := await reader.read(1 << 16):
                    retry = self._first_retry
                    self._session.receive(data)
                    self._send()
                    self._wake()
                    if any(part.failed for part in self._session.parts):
                        self._ask_failed_in(retry if self._session.retry_soon else self._longest_retry)
            except ProtocolError as wrong:
                why = str(wrong)
            except OSError as error:
                told = error.strerror or str(error)
                why = told if self._writer else f"no daemon: {self._path}: {told}"
            finally:
                if self._writer:
                    self._writer.close()
                self._writer = None
            self._session.lost(why)
            self._losses += 1
            self._hurry.clear()
            self._wake()
            await self._pause(retry)
            retry = min(retry * 2, self._longest_retry)
