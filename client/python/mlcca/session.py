# SPDX-License-Identifier: BSD-2-Clause
"""The control protocol without a socket: takes bytes from mlccad and makes bytes for it. Both clients use it."""
from __future__ import annotations

import enum
import operator
import random
import re
import time
from collections import deque
from dataclasses import replace
from typing import Deque, Mapping, Optional

from google.protobuf.message import DecodeError

from mlcca.events import Events, encode
from mlcca.types import Answer, Cause, ChannelException, Check, Delivery, Event, State
from mlcca.v1 import control_pb2

MOST_REPLY = 16 << 20  # bytes, as control.proto states
MOST_REQUEST = 64 << 10
MOST_WAITING = 256      # exceptions that are kept for a program that does not take them
MOST_EVENTS = 1024      # events of a channel that are kept for a program that does not take them
MOST_ROWS = 1 << 18     # deliveries accepted in one answer
PINGS_OF_TIME = 5       # pings that fit into the time within which the daemon must answer
LONGER = 5  # what cannot be used, such as a port that is taken, is tried again after so many times the longest delay of a connection

# Units of the attributes; values are integers.
UNITS = {"Latency": "ns", "Jitter": "ns", "Deadline": "ns", "Period": "ns", "Bandwidth": "bytes/s", "PacketLoss": "1e-9",
         "Omission": "events", "MaxPayload": "bytes"}
NANOSECONDS = {"ns": 1, "us": 1_000, "ms": 1_000_000, "s": 1_000_000_000}

HAPPENED = {"policed": Cause.POLICED, "dropped": Cause.DROPPED, "missing": Cause.MISSING, "restored": Cause.RESTORED,
            "missed": Cause.MISSED,
            "late": Cause.LATE, "lapsed": Cause.GATES_CLOSED, "stopped": Cause.GATES_CLOSED, "mode": Cause.MODE}
# Events after which the decision may be another one, so that the daemon is asked.
VERDICT = {"granted", "refused", "withdrawn", "released", "degraded", "upgraded", "rerouted", "reinstated", "reload",
           "lagged", "local", "binding"}
# Events about a subscription that the gateway has passed on.
FURTHER_ON = {"refused": Cause.REFUSED, "granted": Cause.GRANTED}
# Exceptions that are dropped first if a program takes none.
ONLY_INFORM = {Cause.POLICED, Cause.DROPPED, Cause.MISSING, Cause.RESTORED, Cause.MISSED, Cause.LATE, Cause.MODE,
               Cause.OTHER}


class ProtocolError(Exception):
    """The received bytes are no reply of mlccad, so the connection cannot be used any more."""


class Role(enum.Enum):
    PUBLISHER = control_pb2.ROLE_PUBLISHER
    SUBSCRIBER = control_pb2.ROLE_SUBSCRIBER


def value_of(name: str, value: int | str) -> int:
    """The integer value of an attribute, e.g. of "50ms" for Period. Raises ValueError that says what is right."""
    if name not in UNITS:
        raise ValueError(f"there is no attribute '{name}' (there are: {', '.join(UNITS)})")
    match = re.fullmatch(r"(\d+)\s*(ns|us|ms|s)", value) if isinstance(value, str) and UNITS[name] == "ns" else None
    number: Optional[int] = int(match[1]) * NANOSECONDS[match[2]] if match else None
    try:
        if not isinstance(value, str):
            number = operator.index(value)
    except TypeError:
        pass
    if number is None or isinstance(value, bool):
        raise ValueError(f"{name} {value!r}: must be a whole number of {UNITS[name]}"
                         + (', or text like "50ms" with ns, us, ms or s' if UNITS[name] == "ns" else ""))
    if not 0 <= number < 1 << 64:
        raise ValueError(f"{name} {value}: must be 0 to 2^64-1")
    return number


def check_of(row: control_pb2.Row) -> Check:
    return Check(row.where, row.attribute, row.unit, row.required, row.provided if row.provided_known else None,
                 row.outcome == control_pb2.OUTCOME_FIT, row.margin)


def delivery_of(channel: control_pb2.Channel) -> Delivery:
    return Delivery(channel.granted, channel.publisher, getattr(channel, "from"), channel.to, channel.reason, channel.set,
                    next(iter(channel.problems), ""), tuple(channel.route), tuple(map(check_of, channel.rows)))


def summary_of(deliveries: tuple[Delivery, ...]) -> Answer:
    if not deliveries:
        return Answer(State.REFUSED, "nobody is at the other end")
    refused = [d for d in deliveries if not d.granted]
    state = State.GRANTED if not refused else State.REFUSED if len(refused) == len(deliveries) else State.PARTLY
    return Answer(state, (refused or deliveries)[0].reason, deliveries)


def answer_of(reply: control_pb2.Reply) -> Optional[Answer]:
    """The answer that a reply to an announcement states; None if the daemon could not answer now, but may later."""
    if reply.HasField("channels"):
        return summary_of(tuple(map(delivery_of, reply.channels.channels)))
    if reply.HasField("error") and reply.error.kind != control_pb2.ERROR_WORLD:
        return Answer(State.REJECTED, reply.error.message)
    return None


def shortened(delay: float) -> float:
    """The delay, shortened by up to a quarter at random, so that not all programs connect at once."""
    return delay * random.uniform(0.75, 1)


class Part:
    """The state of a channel that its connection works with."""

    def __init__(self, channel: str, role: Role, name: str, stated: Mapping[str, int | str]) -> None:
        self.request = control_pb2.AnnounceRequest(channel=channel, role=role.value, name=name)
        for attribute, value in stated.items():
            self.request.attributes.add(name=attribute, value=value_of(attribute, value), unit=UNITS[attribute])
        self.answer = Answer()
        self.subject = int(channel, 16) if re.fullmatch("0x[0-9a-fA-F]{1,16}", channel) else 0  # 0: unknown yet
        self.asked = 0         # id of the pending request; 0: none
        self.outdated = False  # something has changed since that request was sent
        self.problem = ""      # why events cannot be carried; empty if they can
        self.lost = False      # the connection was lost, or the answer is overdue: its return is reported
        self.number = 0        # its end at the sockets
        self.waiting: dict["Part", None] = {}  # it is added when something waits for the program; of the session that it is in
        self.events: Deque[Event] = deque()
        self.untaken = 0       # events that were lost because MOST_EVENTS waited
        self._waiting: Deque[ChannelException] = deque()
        self._lagged = False

    @property
    def publishes(self) -> bool:
        return bool(self.request.role == Role.PUBLISHER.value)

    def arrived(self, event: Event) -> bool:
        """Keeps the event for the program. Returns False if it is lost, because too many wait."""
        if len(self.events) >= MOST_EVENTS:
            self.untaken += 1
            return False
        self.events.append(event)
        self.waiting[self] = None
        return True

    def waits(self) -> int:
        """The number of exceptions that take_exception() will return."""
        return len(self._waiting) + self._lagged

    def take_exception(self) -> ChannelException:
        if self._lagged:
            self._lagged = False
            return ChannelException(Cause.LAGGED, "exceptions were lost: they are taken too slowly", answer=self.answer)
        return self._waiting.popleft()

    def note(self, cause: Cause, text: str, event: Optional[control_pb2.Event] = None) -> None:
        self.waiting[self] = None
        if len(self._waiting) >= MOST_WAITING:
            least = next((i for i, e in enumerate(self._waiting) if e.cause in ONLY_INFORM), 0)
            del self._waiting[least]
            self._lagged = True
        if event is None:
            self._waiting.append(ChannelException(cause, text, answer=self.answer))
            return
        self._waiting.append(ChannelException(
            cause, text, publisher=event.publisher, network=event.network_down, silent_ns=event.silent_ns, missing_events=event.missing,
            frames=event.frames, late_events=event.late, longest_ns=event.longest_ns, answer=self.answer))

    def concerns(self, event: control_pb2.Event) -> bool:
        """Whether the event concerns a delivery of this channel. Before there is one, only the channel is known."""
        if not event.publisher or not self.answer.deliveries:
            return True
        return any(d.publisher == event.publisher and event.network in ("", d.to, d.source) for d in self.answer.deliveries)

    def take(self, answer: Answer) -> None:
        """Takes the daemon's answer, and adds an exception for each delivery that is decided otherwise than before."""
        before, self.answer = self.answer, answer
        if answer.state is State.REJECTED:
            if before.state not in (State.REJECTED, State.UNANNOUNCED):
                self.note(Cause.REJECTED, answer.reason)
            return
        if before.state in (State.UNANNOUNCED, State.NO_DAEMON):
            return
        was_of = {(d.publisher, d.source, d.to): d for d in before.deliveries}
        for d in answer.deliveries:
            was = was_of.pop((d.publisher, d.source, d.to), None)
            if d.granted and (was is None or not was.granted):
                self.note(Cause.GRANTED, d.reason)
            elif d.granted and was and d.attribute_set != was.attribute_set:
                self.note(Cause.UPGRADED if d.attribute_set < was.attribute_set else Cause.DEGRADED, d.reason)
            elif not d.granted and was is None:
                self.note(Cause.REFUSED, d.reason)
            elif not d.granted and was and was.granted:
                self.note(Cause.WITHDRAWN, d.reason)
        for d in was_of.values():
            if d.granted:
                self.note(Cause.WITHDRAWN, f"there is no delivery of {d.publisher} to {d.to} any more")

    def forget_trouble(self, event: control_pb2.Event) -> bool:
        """Removes the problem of deliveries of which events arrive again. Returns False if none had any."""
        def concerned(d: Delivery) -> bool:
            return bool(d.problem) and event.publisher in ("", d.publisher) and event.network in ("", d.to, d.source)
        if not any(map(concerned, self.answer.deliveries)):
            return False
        self.answer = replace(self.answer, deliveries=tuple(replace(d, problem="") if concerned(d) else d
                                                            for d in self.answer.deliveries))
        return True

    def is_granted_here(self) -> bool:
        """Whether a delivery on the gateway itself is granted."""
        return any(d.granted and d.source == d.to for d in self.answer.deliveries)

    def withdraw(self, event: control_pb2.Event) -> None:
        """Marks the deliveries that the event withdraws as refused, before the daemon is asked."""
        def concerned(d: Delivery) -> bool:
            return d.granted and event.publisher in ("", d.publisher) and event.network in ("", d.to)
        if not any(map(concerned, self.answer.deliveries)):
            return
        self.answer = summary_of(tuple(replace(d, granted=False, reason=event.message, checks=()) if concerned(d) else d
                                       for d in self.answer.deliveries))
        self.note(Cause.NETWORK_DOWN if event.network_down else Cause.WITHDRAWN, event.message, event)


class Session:
    """The state of the protocol, over one connection after another. `out` has the bytes to send."""

    def __init__(self, answers_within: float = 0) -> None:
        self._answers_within = answers_within
        self._heard = self._pinged = 0.0  # time.monotonic() of the latest bytes of the daemon, and of the ping
        self._ping = 0                    # id of the pending ping; 0: none
        self._stops = False               # the daemon has said on this connection that it stops
        self._supervises = False          # there is a connection to a daemon that has answered so far
        self._knows_pings = True          # False: an older daemon, which closes the connection instead
        self.parts: dict[int, Part] = {}      # by their numbers
        self.failed: dict[Part, None] = {}    # those to announce again later
        self.waiting: dict[Part, None] = {}   # those with something that waits; mlcca.Client removes them
        self._asked: dict[int, Part] = {}     # by the ids of the pending requests
        self.sockets = Events()
        self.out = bytearray()
        self._in = bytearray()
        self._last_id = 0
        self._last_number = 0
        self._partial: dict[int, control_pb2.Reply] = {}
        self._untaken = 0  # events of all channels that were lost because MOST_EVENTS waited

    @property
    def losses(self) -> int:
        """How much was lost on the way to or from all channels, each loss counted once."""
        return self.sockets.lost() + self._untaken

    def add(self, part: Part) -> None:
        """Has the channel announced whenever a connection is made."""
        if self.has(part):
            return
        self._last_number += 1
        part.number = self._last_number
        part.waiting = self.waiting
        self.parts[part.number] = part
        if part.waits() or part.events:
            self.waiting[part] = None

    def has(self, part: Part) -> bool:
        return self.parts.get(part.number) is part

    def remove(self, part: Part) -> None:
        if not self.has(part):
            return
        del self.parts[part.number]
        self.failed.pop(part, None)
        self.waiting.pop(part, None)
        part.waiting = {}
        self.sockets.leave(part.number)

    def _set_failed(self, part: Part, failed: bool) -> None:
        """Has the channel announced again later, or not."""
        if failed:
            self.failed[part] = None
        else:
            self.failed.pop(part, None)

    def take_events(self) -> None:
        """Moves the events that have arrived from the sockets to their channels."""
        arrived, happened = self.sockets.take(), self.sockets.happened()
        for arrival in arrived:
            if arrival.end in self.parts and not self.parts[arrival.end].arrived(arrival.event):
                self._untaken += 1
        for end, event in happened:
            if end in self.parts:
                self._on_happened(self.parts[end], event)

    def connected(self) -> None:
        self._heard, self._ping, self._stops = time.monotonic(), 0, False
        self._supervises = self._answers_within > 0 and self._knows_pings
        for part in self.parts.values():
            self.ask(part)

    def lost(self, why: str) -> None:
        self.out.clear()
        self._in.clear()
        self._partial.clear()
        self._supervises = False
        self.failed.clear()
        self._asked.clear()
        for part in self.parts.values():
            part.asked, part.outdated = 0, False
        self._note_gone(why, time.monotonic())

    def _note_gone(self, why: str, since: float) -> None:
        self.sockets.gone(int(since * NANOSECONDS["s"]))
        for part in self.parts.values():
            answered = part.answer.state not in (State.NO_DAEMON, State.UNANNOUNCED)
            part.lost = True
            part.answer = Answer(State.NO_DAEMON, why)
            if answered:
                part.note(Cause.DAEMON_GONE, why)

    @property
    def due(self) -> Optional[float]:
        """When supervise() is to be called, a time of time.monotonic(); None: not before bytes have come."""
        if not self._supervises:
            return None
        if self._ping == 0:
            return self._heard + self._answers_within / PINGS_OF_TIME
        return max(self._heard, self._pinged) + self._answers_within

    def supervise(self) -> bool:
        """Asks a daemon that was silent for a while whether it answers, and returns True if it has not answered in time. It
        counts as gone then; its connection stays, for the time when it runs again. What has come must have been received."""
        due, now = self.due, time.monotonic()
        if due is None or now < due:
            return False
        if self._ping == 0:
            self._last_id += 1
            self._ping, self._pinged = self._last_id, now
            self.out += encode(control_pb2.Request(id=self._ping, ping=control_pb2.PingRequest()))
            return False
        self._supervises = False
        self._note_gone(f"mlccad does not answer: nothing has come from it for {self._answers_within:g} s", self._heard)
        return True

    def _hear(self) -> None:
        self._heard = time.monotonic()
        if self._supervises or self._ping == 0:
            return
        self._supervises = True  # it had not answered; the decisions may have changed since
        for part in self.parts.values():
            self.ask_again(part)

    def ask(self, part: Part) -> None:
        if not part.publishes:
            part.request.local = self.sockets.address(part.number)
        request = control_pb2.Request(id=self._last_id + 1, announce=part.request, slices=True)
        part.outdated = False
        self._set_failed(part, False)
        if request.ByteSize() > MOST_REQUEST:  # the daemon would close the connection, and with it all channels
            part.asked = 0
            part.take(Answer(State.REJECTED, f"the names and attributes are longer than a request may be, {MOST_REQUEST:,} bytes"))
            return
        self._last_id += 1
        part.asked = self._last_id
        self._asked[part.asked] = part
        self.out += encode(request)

    def ask_again(self, part: Part) -> None:
        """Announces the channel once more: at once, or after the answer to a pending request."""
        if part.asked == 0:
            self.ask(part)
        else:
            part.outdated = True

    @property
    def retry_soon(self) -> bool:
        """Whether a channel failed because the daemon could not answer. What another program holds is tried again later."""
        return any(not part.problem for part in self.failed)

    def ask_failed(self) -> None:
        """Announces the channels that failed once more."""
        for part in list(self.failed):
            self.ask(part)

    def receive(self, data: bytes) -> None:
        """Takes bytes from the daemon. Raises ProtocolError if they are no replies."""
        self._in += data
        self._hear()
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
        if self._ping != 0 and reply.id == self._ping:
            self._ping = 0
            return
        if reply.id == 0:
            self._knows_pings = self._knows_pings and self._ping == 0
            raise ProtocolError(reply.error.message or "mlccad sent a reply without a request")
        partial = self._partial.pop(reply.id, None)
        if partial is not None and not reply.HasField("error"):
            more = reply.more
            partial.MergeFrom(reply)
            partial.more = more
            reply = partial
        if len(reply.channels.channels) > MOST_ROWS:
            raise ProtocolError("mlccad sent an answer without end")
        if reply.more:
            self._partial[reply.id] = reply
            return
        asked = self._asked.pop(reply.id, None)
        if asked is not None and asked.asked == reply.id and self.has(asked):
            self._on_answer(asked, reply)

    def _on_answer(self, part: Part, reply: control_pb2.Reply) -> None:
        part.asked = 0
        answer = answer_of(reply)
        if answer is None:
            # A temporary error, e.g. overload or lack of memory. The last known answer stays.
            self._set_failed(part, True)
            if part.answer.state in (State.UNANNOUNCED, State.NO_DAEMON):
                part.answer = Answer(State.NO_DAEMON, reply.error.message or "mlccad answered with something else")
                part.lost = True
            return
        if reply.channels.channels:
            part.subject = reply.channels.channels[0].subject
        # The endpoints are those of this answer. After a temporary error the former ones stay, and the gates decide.
        # If an endpoint cannot be used, e.g. because another program holds a port, it is tried again later.
        wrong = self.sockets.use(part.number, part.publishes, reply)
        if self._stops:
            self.sockets.close_end(part.number)
        if reply.HasField("channels") and not part.publishes and part.request.local != self.sockets.address(part.number):
            part.outdated = True
        self._set_failed(part, bool(wrong))
        if wrong != part.problem:
            part.problem = wrong
            part.note(Cause.OTHER, f"its events cannot be carried: {wrong}" if wrong else "its events can be carried again")
        # Something has happened since this request was sent, so only the next answer is certain to include it.
        if part.outdated:
            self.ask(part)
            return
        part.take(answer)
        if part.lost:
            part.lost = False
            part.note(Cause.DAEMON_BACK, part.answer.reason)

    def _on_happened(self, part: Part, event: control_pb2.Event) -> None:
        outdated = event.kind == "restored" and part.forget_trouble(event)
        part.note(HAPPENED.get(event.kind, Cause.OTHER), event.message, event)
        if outdated:  # the delivery may have other problems
            self.ask_again(part)

    def _on_event(self, event: control_pb2.Event) -> None:
        if event.kind == "stopped":
            self._stops = True
            for part in self.parts.values():
                self.sockets.close_end(part.number)
        for part in self.parts.values():
            # Without a delivery only the channel's name is known.
            of_channel = event.subject != 0 and (event.subject == part.subject or event.channel == part.request.channel)
            if not of_channel and event.subject != 0:
                continue
            # An event before the first answer happened before the channel was announced.
            if event.kind not in VERDICT and part.answer.state is State.UNANNOUNCED:
                continue
            # About a subscription that the gateway has passed on: its own decision has not changed.
            if event.kind in FURTHER_ON and not event.publisher and event.network:
                if not part.publishes:
                    part.note(FURTHER_ON[event.kind], event.message, event)
                continue
            if event.kind not in VERDICT:
                if event.subject == 0 or part.concerns(event):
                    self._on_happened(part, event)
                continue
            if event.kind == "withdrawn":
                had_local = part.is_granted_here()
                part.withdraw(event)
                if had_local and not part.is_granted_here():  # no gate is between programs on the gateway
                    self.sockets.close_end(part.number)
            self.ask_again(part)
