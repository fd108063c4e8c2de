# SPDX-License-Identifier: BSD-2-Clause
"""The types that a program receives: answers with their reasons, events and exceptions."""
from __future__ import annotations

import enum
from dataclasses import dataclass, field
from typing import Optional, Union

EventData = Union[bytes, bytearray, memoryview]  # what can be published


class State(enum.Enum):
    """The latest decision on a channel that this program knows."""
    UNANNOUNCED = "unannounced"
    GRANTED = "granted"          # every delivery is granted
    PARTLY = "granted in part"   # some deliveries are granted and some are refused
    REFUSED = "refused"          # every delivery is refused, or no other end is known
    REJECTED = "rejected"        # the daemon does not accept the announcement; the reason says why
    NO_DAEMON = "no daemon"      # no daemon answers, so that nothing is known


class Cause(enum.Enum):
    """Why an exception is reported."""
    GRANTED = "granted"            # a delivery that was refused is granted
    REFUSED = "refused"            # a delivery is refused that was not known before
    WITHDRAWN = "withdrawn"        # a delivery that was granted is refused, or does not exist any more
    NETWORK_DOWN = "network-down"  # as WITHDRAWN, because `network` on its route is not available
    REJECTED = "rejected"          # after a reload the announcement does not fit the description any more
    DEGRADED = "degraded"          # a less preferred attribute set is in use
    UPGRADED = "upgraded"          # a more preferred attribute set is in use
    POLICED = "policed"            # the publisher sent more than was admitted, and the excess was dropped
    DROPPED = "dropped"            # the gate dropped frames of the channel
    MISSING = "missing"            # no event has arrived for longer than a subscriber's Omission allows
    RESTORED = "restored"          # events arrive again after MISSING
    MISSED = "missed"              # events of programs on this gateway were lost: not read in time, or the gates were closed
    LATE = "late"                  # events spent more time in mlcca-relay than the description states for the gateway
    GATES_CLOSED = "gates-closed"  # the kernel had closed all gates for a time, or the daemon stops, or its grace is over
    MODE = "mode"                  # the gateway has changed between the modes enforce and audit
    LAGGED = "lagged"              # exceptions were lost, because this program took them too slowly
    DAEMON_GONE = "daemon-gone"    # the connection is lost or the daemon hangs; grants hold for the grace, then GATES_CLOSED
    DAEMON_BACK = "daemon-back"    # the daemon has answered the announcement again; see `answer`
    OTHER = "other"                # a kind that this library does not know, or a problem with the sockets; see `text`


class Published(enum.Enum):
    """The result of publishing an event."""
    SENT = "sent"                # sent to every place that the channel is granted for
    PARTLY = "sent in part"      # sent to some of these places; at the others the queue was full or the gate dropped it
    LOST = "lost"                # sent to none of them
    NOT_GRANTED = "not granted"  # not sent, because nothing is granted, nobody receives, or no decision is known yet
    TOO_LONG = "too long"        # not sent, because it is longer than a network carries or than 65,535 bytes


@dataclass(frozen=True)
class Event:
    """An event that was received."""
    data: bytes       # 0 to 65,535 bytes
    network: str      # the network that it came from; empty if a program on the gateway sent it
    received_ns: int  # when the kernel received it (or it was read, if the kernel did not report that), ns since 1970


@dataclass(frozen=True)
class Check:
    """One attribute compared at one place on the route of an event."""
    where: str               # network or gateway, "end to end", "publisher NAME", …
    attribute: str           # name of the attribute, e.g. "Omission"
    unit: str                # of `required` and `provided`: "ns", "bytes/s", "1e-9", "events" or "bytes"
    required: int            # the strictest requirement of the publisher and the subscribers
    provided: Optional[int]  # None: unknown, hence not fulfilled
    fits: bool
    margin: str              # readable text: "1 to spare", "3 events too many"


@dataclass(frozen=True)
class Delivery:
    """The decision on the events of one publisher towards one network or gateway."""
    granted: bool
    publisher: str
    source: str       # network or gateway that the events come from
    to: str
    reason: str       # one line: if granted the smallest margin, otherwise why it is refused
    attribute_set: int  # the attribute set in use; 0 is the preferred one
    problem: str      # what is wrong although the delivery is granted; empty if nothing is
    route: tuple[str, ...]
    checks: tuple[Check, ...]


@dataclass(frozen=True)
class Answer:
    """The decision on one publisher or subscriber of a channel."""
    state: State = State.UNANNOUNCED
    reason: str = ""
    deliveries: tuple[Delivery, ...] = ()


@dataclass(frozen=True)
class ChannelException:
    """Something that has happened to a channel. It is passed to handlers or iterators, never raised."""
    cause: Cause
    text: str                # one line, as in the log of the gateway
    publisher: str = ""      # publisher concerned, by its name; empty if there are several or none
    network: str = ""        # NETWORK_DOWN: the network concerned
    silent_ns: int = 0       # MISSING, RESTORED: how long no event arrived
    missing_events: int = 0  # MISSING, RESTORED: events that should have arrived in that time; MISSED: lost since the last one
    frames: int = 0          # POLICED, DROPPED: frames since the last such exception
    late_events: int = 0     # LATE: late events since the last such exception
    longest_ns: int = 0      # LATE: the longest time that one of them spent in mlcca-relay
    answer: Answer = field(default_factory=Answer)  # the decision when the exception was raised
