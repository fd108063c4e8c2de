# SPDX-License-Identifier: BSD-2-Clause
"""The protocol without a socket: bytes of mlccad in, bytes for it out. Both clients are made of it."""
from __future__ import annotations

import enum
import re
from collections import deque
from typing import Deque, Mapping, Optional

from google.protobuf.message import DecodeError

from mlcca.types import Answer, Cause, ChannelException, Check, Delivery, State
from mlcca.v1 import control_pb2

MOST_REPLY = 16 << 20  # bytes, as control.proto has it
MOST_WAITING = 4096    # exceptions that wait for a program that does not take them

# In whole numbers of the unit that the daemon counts in.
UNITS = {"Latency": "ns", "Jitter": "ns", "Deadline": "ns", "Period": "ns", "Bandwidth": "bytes/s", "PacketLoss": "1e-9",
         "Omission": "events", "MaxPayload": "bytes"}
NANOSECONDS = {"ns": 1, "us": 1_000, "ms": 1_000_000, "s": 1_000_000_000}

CAUSES = {"granted": Cause.GRANTED, "refused": Cause.REFUSED, "withdrawn": Cause.WITHDRAWN, "released": Cause.WITHDRAWN,
          "excess": Cause.POLICED, "dropping": Cause.DROPPED, "missing": Cause.MISSING, "restored": Cause.RESTORED,
          "lapsed": Cause.GATES_CLOSED, "stopped": Cause.GATES_CLOSED, "mode": Cause.MODE, "lagged": Cause.LAGGED}
CHANGE_VERDICTS = {"granted", "refused", "withdrawn", "released", "switched", "reinstated"}


class ProtocolError(Exception):
    """What came is no reply of mlccad: the connection is of no use any more."""


class Role(enum.Enum):
    PUBLISHER = control_pb2.ROLE_PUBLISHER
    SUBSCRIBER = control_pb2.ROLE_SUBSCRIBER


def value_of(name: str, value: int | str) -> int:
    """50_000_000 or "50ms" of a Period, 2 of an Omission. Raises ValueError with what would be right."""
    if name not in UNITS:
        raise ValueError(f"there is no attribute '{name}' (there are: {', '.join(UNITS)})")
    if isinstance(value, str):
        match = re.fullmatch(r"(\d+)\s*(ns|us|ms|s)", value)
        if UNITS[name] != "ns" or not match:
            raise ValueError(f"{name} '{value}': must be a whole number of {UNITS[name]}"
                             + (", or one with ns, us, ms or s" if UNITS[name] == "ns" else ""))
        value = int(match[1]) * NANOSECONDS[match[2]]
    if not 0 <= value < 1 << 64:
        raise ValueError(f"{name} {value}: must be 0 to 2^64-1")
    return value


def encode(request: control_pb2.Request) -> bytes:
    body = request.SerializeToString()
    head = bytearray()
    size = len(body)
    while size > 127:
        head.append(size & 127 | 128)
        size >>= 7
    head.append(size)
    return bytes(head) + body


def check_of(row: control_pb2.Row) -> Check:
    return Check(row.where, row.attribute, row.unit, row.required, row.provided if row.provided_known else None,
                 row.outcome == control_pb2.OUTCOME_FIT, row.margin)


def delivery_of(channel: control_pb2.Channel) -> Delivery:
    return Delivery(channel.granted, channel.publisher, getattr(channel, "from"), channel.to, channel.reason, channel.set,
                    next(iter(channel.troubles), ""), tuple(channel.route), tuple(map(check_of, channel.rows)))


def answer_of(reply: control_pb2.Reply) -> Answer:
    if not reply.HasField("channels"):
        return Answer(State.REJECTED, reply.error.message or "the daemon answered with something else")
    deliveries = tuple(map(delivery_of, reply.channels.channels))
    refused = [d for d in deliveries if not d.granted]
    state = State.GRANTED if not refused else State.REFUSED if len(refused) == len(deliveries) else State.PARTLY
    if not deliveries:
        return Answer(State.REFUSED, "nobody is at the other end")
    return Answer(state, (refused or deliveries)[0].reason, deliveries)


class Part:
    """What a channel of a program is to its connection."""

    def __init__(self, channel: str, role: Role, name: str, stated: Mapping[str, int | str]) -> None:
        self.request = control_pb2.AnnounceRequest(channel=channel, role=role.value, name=name)
        for attribute, value in stated.items():
            self.request.attributes.add(name=attribute, value=value_of(attribute, value), unit=UNITS[attribute])
        self.answer = Answer()
        self.exceptions: Deque[ChannelException] = deque()
        self.subject = 0  # 0: not known yet
        self.asked = 0    # the request that waits for an answer, 0: none
        self.lost = False  # the daemon went after it was announced
        self.waiting: list[control_pb2.Event] = []

    def note(self, cause: Cause, text: str, silent_ns: int = 0, missing_events: int = 0) -> None:
        if len(self.exceptions) == MOST_WAITING:
            self.exceptions[-1] = ChannelException(Cause.LAGGED, "exceptions were lost: they are taken too slowly",
                                                   answer=self.answer)
            return
        self.exceptions.append(ChannelException(cause, text, silent_ns, missing_events, self.answer))

    def note_event(self, event: control_pb2.Event, before: Answer) -> None:
        cause = CAUSES.get(event.kind, Cause.OTHER)
        if event.kind == "switched":
            cause = Cause.UPGRADED if self.answer.worst_set() < before.worst_set() else Cause.DEGRADED
        self.note(cause, event.message, event.silent_ns, event.missing)


class Session:
    """One connection after another. `out` has what is to be sent."""

    def __init__(self) -> None:
        self.parts: list[Part] = []
        self.out = bytearray()
        self._in = bytearray()
        self._last_id = 0
        self._whole: dict[int, control_pb2.Reply] = {}

    def connected(self) -> None:
        for part in self.parts:
            self.ask(part)

    def lost(self, why: str) -> None:
        self.out.clear()
        self._in.clear()
        self._whole.clear()
        for part in self.parts:
            told = part.answer.state not in (State.NO_DAEMON, State.UNANNOUNCED)
            part.asked, part.lost, part.waiting = 0, True, []
            part.answer = Answer(State.NO_DAEMON, why)
            if told:
                part.note(Cause.DAEMON_GONE, why)

    def ask(self, part: Part) -> None:
        self._last_id += 1
        part.asked = self._last_id
        self.out += encode(control_pb2.Request(id=part.asked, announce=part.request, slices=True))

    def receive(self, data: bytes) -> None:
        """Raises ProtocolError."""
        self._in += data
        while (reply := self._next_reply()) is not None:
            self._on_reply(reply)

    def _next_reply(self) -> Optional[control_pb2.Reply]:
        size = shift = at = 0
        while True:
            if at == len(self._in):
                return None
            byte = self._in[at]
            size |= (byte & 127) << shift
            at, shift = at + 1, shift + 7
            if byte < 128:
                break
            if shift > 28:
                raise ProtocolError("mlccad sent a length that is none")
        if size > MOST_REPLY:
            raise ProtocolError(f"mlccad sent a reply of {size} bytes, at most {MOST_REPLY} are possible")
        if len(self._in) < at + size:
            return None
        body = bytes(self._in[at:at + size])
        del self._in[:at + size]
        reply = control_pb2.Reply()
        try:
            read = reply.ParseFromString(body)
        except DecodeError as wrong:
            raise ProtocolError(f"mlccad sent what is no reply: {wrong}") from wrong
        if read != size:
            raise ProtocolError("mlccad sent what is no reply")
        return reply

    def _on_reply(self, reply: control_pb2.Reply) -> None:
        if reply.HasField("event"):
            self._on_event(reply.event)
            return
        if reply.id == 0:
            raise ProtocolError(reply.error.message or "mlccad sent a reply without a request")
        whole = self._whole.pop(reply.id, None)
        if whole is not None and not reply.HasField("error"):
            more = reply.more
            whole.MergeFrom(reply)
            whole.more = more
            reply = whole
        if reply.more:
            self._whole[reply.id] = reply
            return
        # One that was asked for again has an answer that is newer.
        for part in self.parts:
            if part.asked == reply.id:
                self._on_answer(part, reply)

    @staticmethod
    def _on_answer(part: Part, reply: control_pb2.Reply) -> None:
        part.asked = 0
        before, part.answer = part.answer, answer_of(reply)
        if reply.channels.channels:
            part.subject = reply.channels.channels[0].subject
        events, part.waiting = part.waiting, []
        if part.lost:
            part.lost = False
            part.note(Cause.DAEMON_BACK, part.answer.reason)
        # Events are of all ends of a channel.
        if before.state == part.answer.state and before.verdicts() == part.answer.verdicts():
            return
        for event in events:
            part.note_event(event, before)

    def _on_event(self, event: control_pb2.Event) -> None:
        for part in self.parts:
            # Without a delivery only the name is known.
            ours = event.subject != 0 and (event.subject == part.subject or event.channel == part.request.channel)
            if not ours and event.subject != 0:
                continue
            if ours and event.kind in CHANGE_VERDICTS:
                part.waiting.append(event)
                self.ask(part)
            else:
                part.note_event(event, part.answer)
