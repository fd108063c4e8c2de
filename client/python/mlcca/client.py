# SPDX-License-Identifier: BSD-2-Clause
"""The blocking client, for a program with one thread or a loop over file descriptors."""
from __future__ import annotations

import os
import select
import socket
import time
from typing import Callable, Mapping, Optional

from mlcca.session import LONGER, Part, ProtocolError, Role, Session, shortened
from mlcca.timer import Timer
from mlcca.types import Answer, ChannelException, Event, EventData, Published, State

SOCKET = "/run/mlcca/control.sock"
MOST_READS = 16  # reads in one turn, so that a daemon that sends without pause does not block the program
Handler = Callable[[ChannelException], None]
EventHandler = Callable[[Event], None]


class Channel:
    """The common base of publishers and subscribers."""

    def __init__(self, client: "Client", part: Part) -> None:
        self._client = client
        self._part = part
        self.on_exception: Optional[Handler] = None  # called by Client.process() and Client.wait()

    @property
    def answer(self) -> Answer:
        """The latest known decision."""
        return self._part.answer

    def close(self) -> None:
        """Ends the channel: it is not announced any more, and its handlers are not called any more."""
        self._client._forget(self)


class PublisherChannel(Channel):
    """The publisher of an event channel; made by Client.publisher()."""

    def announce(self) -> Answer:
        """Announces the publisher and waits for the answer, for the client's `patience` at most.

        Whatever the answer is, the channel is announced again whenever a daemon can be reached, until close(). A daemon that
        does not answer yields State.NO_DAEMON. Raises RuntimeError if the client is closed.
        """
        return self._client._take_up(self)

    def publish(self, event: EventData) -> Published:
        """Sends an event of 0 to 65,535 bytes to every granted network and to subscribers on this gateway.

        Never waits. While the daemon cannot be reached, events are sent where they were granted last, until the gates close
        after the grace period; subscribers on this gateway are then sent nothing either. Raises TypeError if `event` does not hold bytes, e.g. a str.
        """
        return self._client._session.sockets.publish(self._part.number, event)


class SubscriberChannel(Channel):
    """The subscriber of an event channel; made by Client.subscriber()."""

    def __init__(self, client: "Client", part: Part) -> None:
        super().__init__(client, part)
        self.on_event: Optional[EventHandler] = None  # called by Client.process() and Client.wait()

    def subscribe(self) -> Answer:
        """Announces the subscriber; otherwise like PublisherChannel.announce()."""
        return self._client._take_up(self)

    @property
    def lost(self) -> int:
        """How much was lost on the way to this channel. From programs on the gateway: its events that were longer than its
        MaxPayload, exceeded what is admitted, or were missed. From the networks that it receives from: frames and events that
        were incomplete, malformed or lost in a socket; the channels of a client on one network share its socket, so each of
        them counts all that was lost there. And events of this channel that the program did not take."""
        return self._client._session.sockets.lost_of(self._part.number) + self._part.untaken


class Client:
    """A connection to mlccad. It is established when a channel is announced, and again whenever it is lost.

    Pass it to select(), or its fileno() to a loop of your own, and call process() when it is readable: it becomes readable
    also when it is time to look for a daemon that was lost. Or call wait(). A client is not thread-safe.

    `path`: the daemon's control socket. The other arguments are in seconds. `patience`: how long announce() and subscribe()
    wait for an answer. `first_retry`: the delay before connecting again, which is doubled up to `longest_retry`; each delay is
    shortened by up to a quarter at random. `answers_within`: how long a daemon may leave a question unanswered before it counts
    as gone, although the connection exists; it is asked if nothing came from it for a fifth of this time. 0: never. State less
    than the grace period of the gateway.
    """

    def __init__(self, path: str = SOCKET, *, patience: float = 10, first_retry: float = 0.1, longest_retry: float = 1,
                 answers_within: float = 5) -> None:
        self._path, self._patience = path, patience
        self._first_retry, self._longest_retry = first_retry, max(first_retry, longest_retry)
        self._retry, self._retry_at = first_retry, 0.0
        self._session = Session(answers_within)
        self._epoll = select.epoll()
        self._epoll.register(self._session.sockets, select.EPOLLIN)
        # Readable while something waits for handlers. Older types of os do not have it.
        self._wakes: int = os.eventfd(0, os.EFD_CLOEXEC | os.EFD_NONBLOCK)  # type: ignore[attr-defined]
        self._epoll.register(self._wakes, select.EPOLLIN)
        self._timer = Timer()  # expires when it is time to connect, or to ask again for channels that failed
        self._epoll.register(self._timer, select.EPOLLIN)
        self._socket: Optional[socket.socket] = None
        self._channels: dict[Part, Channel] = {}

    def publisher(self, channel: str, name: str = "", **stated: int | str) -> PublisherChannel:
        """Makes a publisher. It must be announced before it can publish.

        `channel`: its name in the description, or its subject as "0xa4efeccc3210b497". `name`: the publisher's name in the
        description; needed if this user has several publishers of the channel. `stated`: attributes that the program was
        built for, e.g. Period="50ms"; the daemon rejects the announcement if the description falls short of them. Raises
        ValueError that names the attribute if it is unknown or its value is wrong.
        """
        return PublisherChannel(self, Part(channel, Role.PUBLISHER, name, stated))

    def subscriber(self, channel: str, name: str = "", **stated: int | str) -> SubscriberChannel:
        """Makes a subscriber. The arguments have the same meaning as for publisher(), with the subscriber's name."""
        return SubscriberChannel(self, Part(channel, Role.SUBSCRIBER, name, stated))

    @property
    def connected(self) -> bool:
        return self._socket is not None

    @property
    def lost(self) -> int:
        """How much was lost on the way to or from all channels of this client, each loss counted once; see SubscriberChannel.lost.
        Counts also J1939 messages that could not be sent completely."""
        return self._session.losses

    def fileno(self) -> int:
        """A file descriptor that is readable when process() has work to do. It is the same until close()."""
        return self._epoll.fileno()

    def process(self) -> None:
        """Handles all pending work and calls the handlers of exceptions and events; never waits. If a handler raises, process()
        raises the same, and what was not handled is kept for the next call."""
        self._turn()
        try:
            for part in list(self._session.waiting):
                try:
                    channel = self._channels.get(part)
                    if channel:
                        self._call_with_exceptions(channel)
                        self._call_with_events(channel)
                finally:
                    if not part.waits() and not part.events:
                        self._session.waiting.pop(part, None)
        finally:
            self._wake_or_not()

    def wait(self, seconds: Optional[float] = None) -> None:
        """Waits until there is work to do, for `seconds` at most (None: without limit), and then does the same as process()."""
        end = None if seconds is None else time.monotonic() + seconds
        while not self._has_waiting():
            left = None if end is None else end - time.monotonic()
            if left is not None and left <= 0:
                break
            self._pause(left)
            self._turn()
        self.process()

    def close(self) -> None:
        if self._socket:
            self._socket.close()
        self._socket = None
        self._channels.clear()
        self._session.waiting.clear()
        self._session.sockets.close()
        if not self._epoll.closed:
            os.close(self._wakes)
            self._timer.close()
        self._epoll.close()

    def __enter__(self) -> "Client":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    # --- below: for Channel ---------------------------------------------------------------------------------------

    def _take_up(self, channel: Channel) -> Answer:
        part = channel._part
        if self._epoll.closed:
            raise RuntimeError("the client is closed")
        self._channels[part] = channel
        self._session.add(part)
        part.lost = False
        if not self._socket:
            self._connect(planned=False)
        else:
            self._session.ask_again(part)
        end = time.monotonic() + self._patience
        self._turn()
        while part.asked != 0 and (left := end - time.monotonic()) > 0:
            self._wait_for_daemon(left)
            self._turn()
        if part.asked != 0:
            part.lost = True  # so that an answer that comes later is reported
            part.answer = Answer(State.NO_DAEMON, f"no answer from mlccad within {self._patience:g} s")
        self._wake_or_not()  # events that arrived in between were taken from the sockets
        return part.answer

    def _has_waiting(self) -> bool:
        return bool(self._session.waiting)

    def _wake_or_not(self) -> None:
        """Keeps fileno() readable as long as something waits for a handler."""
        if self._epoll.closed:
            return
        try:
            if self._has_waiting():
                os.eventfd_write(self._wakes, 1)  # type: ignore[attr-defined]
            else:
                os.eventfd_read(self._wakes)  # type: ignore[attr-defined]
        except BlockingIOError:
            pass

    def _forget(self, channel: Channel) -> None:
        self._channels.pop(channel._part, None)
        self._session.remove(channel._part)

    def _call_with_exceptions(self, channel: Channel) -> None:
        """What is added while a handler runs waits for the next turn. A handler may end its channel."""
        part = channel._part
        for _ in range(part.waits()):
            exception = part.take_exception()
            if channel.on_exception:
                channel.on_exception(exception)
            if part not in self._channels:
                return

    def _call_with_events(self, channel: Channel) -> None:
        part = channel._part
        for _ in range(len(part.events) if part in self._channels else 0):
            event = part.events.popleft()
            handler = channel.on_event if isinstance(channel, SubscriberChannel) else None
            if handler:
                handler(event)
            if part not in self._channels:
                return

    # --- the connection -------------------------------------------------------------------------------------------

    def _connect(self, planned: bool = True) -> None:
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM | socket.SOCK_CLOEXEC)
        self._socket.setblocking(False)
        try:
            self._socket.connect(self._path)
        except OSError as error:
            self._lose(f"no daemon: {self._path}: {error.strerror or error}", planned)
            return
        self._epoll.register(self._socket, select.EPOLLIN)
        self._session.connected()

    def _retry_later(self, planned: bool) -> None:
        """Sets the time of the next try. Only the failure of a planned try doubles the delay."""
        self._retry_at = time.monotonic() + shortened(self._retry)
        if planned:
            self._retry = min(self._retry * 2, self._longest_retry)

    def _lose(self, why: str, planned: bool = True) -> None:
        if self._socket:
            self._socket.close()
        self._socket = None
        self._retry_later(planned)
        self._session.lost(why)

    def _turn(self) -> None:
        if self._epoll.closed:
            return
        due = self._channels and time.monotonic() >= self._retry_at
        if not self._socket and due:
            self._connect()
        if self._socket and due:
            self._session.ask_failed()
        try:
            self._send()
            self._receive()
            self._session.supervise()
            self._send()
        except ProtocolError as wrong:
            self._lose(str(wrong))
        except OSError as error:
            self._lose(error.strerror or str(error))
        self._session.take_events()  # after what the daemon has sent, which may end what is granted
        if self._socket:
            self._epoll.modify(self._socket, select.EPOLLIN | (select.EPOLLOUT if self._session.out else 0))
        times = [self._retry_at] if self._is_to_retry() else []
        if (supervised := self._session.due) is not None:
            times.append(supervised)
        self._timer.expire_at(min(times, default=None))

    def _send(self) -> None:
        while self._socket and self._session.out:
            try:
                del self._session.out[:self._socket.send(self._session.out, socket.MSG_NOSIGNAL)]
            except BlockingIOError:
                return
            except OSError:  # what the daemon has sent before it closed is read; then the connection ends
                self._session.out.clear()
                self._socket.shutdown(socket.SHUT_RDWR)

    def _receive(self) -> None:
        for _ in range(MOST_READS):
            if not self._socket:
                return
            try:
                data = self._socket.recv(1 << 16)
            except BlockingIOError:
                return
            if not data:
                self._lose("mlccad closed the connection")
                return
            self._session.receive(data)
            self._retry = self._first_retry
            if self._session.failed:
                now = time.monotonic()
                due = now + (self._retry if self._session.retry_soon else LONGER * self._longest_retry)
                # A later reply must not delay it.
                self._retry_at = min(self._retry_at, due) if self._retry_at > now else due

    def _is_to_retry(self) -> bool:
        """Whether something must be tried again at `_retry_at`."""
        return bool(self._channels) and (not self._socket or bool(self._session.failed))

    def _pause(self, seconds: Optional[float]) -> None:
        """Waits for events, for the daemon, and until something must be tried again."""
        if self._epoll.closed:
            raise RuntimeError("the client is closed")
        if not self._channels and seconds is None:
            raise RuntimeError("nothing is announced: wait() would have no end")
        self._epoll.poll(seconds)

    def _wait_for_daemon(self, seconds: float) -> None:
        """Waits for the daemon alone, until something must be tried again at most; events stay in their sockets."""
        reads = [self._socket, self._timer] if self._socket else [self._timer]
        select.select(reads, [self._socket] if self._socket and self._session.out else [], [], seconds)
