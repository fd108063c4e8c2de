# SPDX-License-Identifier: BSD-2-Clause
"""Sends and receives events by the sockets of libmlcca (mlcca/client/events.h), which all languages share."""
from __future__ import annotations

import ctypes
from dataclasses import dataclass

from mlcca.types import Event, EventData, Published
from mlcca.v1 import control_pb2

LIBRARY = "libmlcca.so.@ABI@"
WHY_SIZE = 256
HAPPENED_SIZE = 4096  # bytes; more than most reports have

_OnEvent = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_uint64, ctypes.c_void_p, ctypes.c_size_t, ctypes.c_char_p,
                            ctypes.c_uint64)
_PUBLISHED = (Published.SENT, Published.PARTLY, Published.LOST, Published.NOT_GRANTED, Published.TOO_LONG)


def _load() -> ctypes.CDLL:
    try:
        library = ctypes.CDLL(LIBRARY)
    except OSError as missing:
        raise ImportError(f"events go by {LIBRARY}, which cannot be loaded (package libmlcca@ABI@): {missing}") from missing
    events, end, data, size = ctypes.c_void_p, ctypes.c_uint64, ctypes.c_char_p, ctypes.c_size_t
    for name, result, arguments in (("new", events, ()),
                                    ("free", None, (events,)),
                                    ("fd", ctypes.c_int, (events,)),
                                    ("address", ctypes.c_char_p, (events, end)),
                                    ("use", ctypes.c_int, (events, end, ctypes.c_int, data, size, data, size)),
                                    ("gone", None, (events, end)),
                                    ("close", None, (events, end)),
                                    ("leave", None, (events, end)),
                                    ("publish", ctypes.c_int, (events, end, data, size)),
                                    ("process", None, (events, _OnEvent, ctypes.c_void_p)),
                                    ("happened", size, (events, ctypes.POINTER(end), data, size)),
                                    ("lost_of", ctypes.c_uint64, (events, end)),
                                    ("lost", ctypes.c_uint64, (events,))):
        function = getattr(library, f"mlcca_events_{name}")
        function.restype, function.argtypes = result, arguments
    return library


def encode(message: control_pb2.Request | control_pb2.Reply) -> bytes:
    """The encoded message, preceded by its length as a varint."""
    body: bytes = message.SerializeToString()
    head = bytearray()
    size = len(body)
    while size > 127:
        head.append(size & 127 | 128)
        size >>= 7
    head.append(size)
    return bytes(head) + body


@dataclass(frozen=True)
class Arrival:
    """An event and the number of the channel's end that it is for."""
    end: int
    event: Event


class Events:
    """The sockets of one client. No method waits. Ends of channels have numbers that the caller chooses."""

    _library = _load()

    def __init__(self) -> None:
        self._events = self._library.mlcca_events_new()
        if not self._events:
            raise OSError("there are no file descriptors left for events")
        self._arrived: list[Arrival] = []
        self._lost = 0
        self._on_event = _OnEvent(self._take)

    def close(self) -> None:
        if self._events:
            self._lost = self.lost()
            self._library.mlcca_events_free(self._events)
        self._events = None

    def fileno(self) -> int:
        """A file descriptor that is readable when take() has work to do. It is the same until close()."""
        return int(self._library.mlcca_events_fd(self._events))

    def address(self, end: int) -> str:
        """The address to which programs on the gateway send events for this end; use() may change it."""
        return bytes(self._library.mlcca_events_address(self._events, end)).decode()

    def use(self, end: int, publishes: bool, reply: control_pb2.Reply) -> str:
        """Makes the end send or receive as granted. Returns what cannot be used, and why; empty if everything can."""
        wanted = control_pb2.Reply(id=1)
        wanted.channels.grace_ns = reply.channels.grace_ns
        wanted.channels.local_problem = reply.channels.local_problem
        wanted.channels.endpoints.extend(reply.channels.endpoints)
        for of in reply.channels.channels:
            row = wanted.channels.channels.add(subject=of.subject, publisher=of.publisher, to=of.to, granted=of.granted)
            setattr(row, "from", getattr(of, "from"))
        data = encode(wanted)
        why = ctypes.create_string_buffer(WHY_SIZE)
        done = self._library.mlcca_events_use(self._events, end, 0 if publishes else 1, data, len(data), why, WHY_SIZE)
        return "" if done == 0 else why.value.decode(errors="replace")

    def gone(self, since_ns: int) -> None:
        """The daemon is gone since this time of time.monotonic_ns(). Events between programs on the gateway end after the grace,
        unless use() is called before; happened() reports it."""
        if self._events:
            self._library.mlcca_events_gone(self._events, since_ns)

    def close_end(self, end: int) -> None:
        """Events between programs on the gateway end for this end, until use() is called for it."""
        if self._events:
            self._library.mlcca_events_close(self._events, end)

    def leave(self, end: int) -> None:
        if self._events:
            self._library.mlcca_events_leave(self._events, end)

    def publish(self, end: int, event: EventData) -> Published:
        if isinstance(event, str):
            raise TypeError("an event has bytes and is no str: publish text as text.encode()")
        if not isinstance(event, bytes):
            event = bytes(memoryview(event))
        if not self._events:
            return Published.NOT_GRANTED
        return _PUBLISHED[self._library.mlcca_events_publish(self._events, end, event, len(event))]

    def take(self) -> list[Arrival]:
        """The events that have arrived, in order."""
        self._library.mlcca_events_process(self._events, self._on_event, None)
        arrived, self._arrived = self._arrived, []
        return arrived

    def happened(self) -> list[tuple[int, control_pb2.Event]]:
        """What happened to events of programs on the gateway, which pass no gate: the end and an event as of the daemon."""
        out: list[tuple[int, control_pb2.Event]] = []
        end, room = ctypes.c_uint64(), HAPPENED_SIZE
        while True:
            reply = ctypes.create_string_buffer(room)
            size = int(self._library.mlcca_events_happened(self._events, ctypes.byref(end), reply, room))
            if size == 0:
                return out
            if size > room:
                room = size
                continue
            head = next(i for i, byte in enumerate(reply.raw) if byte < 128) + 1
            out.append((end.value, control_pb2.Reply.FromString(reply.raw[head:size]).event))

    def lost_of(self, end: int) -> int:
        return int(self._library.mlcca_events_lost_of(self._events, end)) if self._events else 0

    def lost(self) -> int:
        """How much was lost in all; after close() as it was then."""
        return int(self._library.mlcca_events_lost(self._events)) if self._events else self._lost

    def _take(self, _: None, end: int, data: int, size: int, network: bytes, unix_ns: int) -> None:
        content = ctypes.string_at(data, size) if size else b""
        self._arrived.append(Arrival(end, Event(content, network.decode(), unix_ns)))
