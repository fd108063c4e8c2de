# SPDX-License-Identifier: BSD-2-Clause
"""What a program is given: answers with their reasons, and exceptions."""
from __future__ import annotations

import enum
from dataclasses import dataclass, field
from typing import Optional


class State(enum.Enum):
    """What is known of a channel."""
    UNANNOUNCED = "unannounced"
    GRANTED = "granted"          # every delivery
    PARTLY = "granted in part"   # some deliveries are granted, some refused
    REFUSED = "refused"          # every delivery, or there is none
    REJECTED = "rejected"        # the daemon does not take the announcement: see the reason
    NO_DAEMON = "no daemon"      # nothing is known while no daemon answers


class Cause(enum.Enum):
    """Why there is an exception."""
    GRANTED = "granted"            # a delivery that was refused is granted
    REFUSED = "refused"            # a delivery is refused
    WITHDRAWN = "withdrawn"        # a delivery was granted and is not any more
    NETWORK_DOWN = "network down"  # the same, since a network on its way is not available: see `network`
    REJECTED = "rejected"          # after a reload the announcement does not go with the description any more
    DEGRADED = "degraded"          # another attribute set is in use, which asks for less
    UPGRADED = "upgraded"          # another attribute set is in use, which gives more
    POLICED = "policed"            # the publisher sent more than was admitted
    DROPPED = "dropped"            # the gate dropped frames of the channel
    MISSING = "missing"            # nothing has come for longer than a subscriber's Omission allows
    RESTORED = "restored"          # events come again
    MISSED = "missed"              # events of programs on this gateway were lost, since they were not read in time
    LATE = "late"                  # events took longer in mlcca-relay than the gateway states
    GATES_CLOSED = "gates closed"  # the kernel closed all gates for a while, or the daemon ends
    MODE = "mode"                  # enforce or audit
    LAGGED = "lagged"              # exceptions were lost: this program took them too slowly
    DAEMON_GONE = "daemon gone"    # granted deliveries hold for the grace period
    DAEMON_BACK = "daemon back"    # it is announced again: see the answer
    OTHER = "other"                # of a newer daemon: see the text


class Published(enum.Enum):
    """What became of an event that was published."""
    SENT = "sent"                # to every place that it is granted for
    PARTLY = "sent in part"      # to some of them; the others have a full queue, or their gate drops it
    LOST = "lost"                # to none of them
    NOT_GRANTED = "not granted"  # nothing is granted, or nothing is known yet, so that it was not sent
    TOO_LONG = "too long"        # longer than a network carries


@dataclass(frozen=True)
class Event:
    """An event that has come."""
    data: bytes       # 0 to 65,535 bytes
    network: str      # that it came from; empty: from a program on the gateway
    received_ns: int  # when the kernel received it, or, of a program on the gateway, when it was read; since 1970


@dataclass(frozen=True)
class Check:
    """One attribute, held against one place on the way of an event."""
    where: str               # network or gateway, "end to end", "publisher NAME", …
    attribute: str           # "Omission"
    unit: str                # of both values: "ns", "bytes/s", "1e-9", "events", "bytes"
    required: int            # what publisher and subscribers ask for together
    provided: Optional[int]  # None: it is not known
    fits: bool
    margin: str              # readable: "1 to spare", "3 too many"


@dataclass(frozen=True)
class Delivery:
    """What was decided for the events of one publisher towards one network or gateway."""
    granted: bool
    publisher: str
    source: str       # network or gateway that the events come from
    to: str
    reason: str       # one line: the smallest margin, or why it is refused
    attribute_set: int  # the one in use, 0: the preferred one
    trouble: str      # what is wrong although it is granted; empty: nothing
    route: tuple[str, ...]
    checks: tuple[Check, ...]


@dataclass(frozen=True)
class Answer:
    """What is decided for one end of a channel."""
    state: State = State.UNANNOUNCED
    reason: str = ""
    deliveries: tuple[Delivery, ...] = ()


@dataclass(frozen=True)
class ChannelException:
    """Something has happened to a channel. It is handed over, never raised."""
    cause: Cause
    text: str                # one line, as in the log of the gateway
    publisher: str = ""      # that it is of, by its name; empty: of several, or of none
    network: str = ""        # network down: which one
    silent_ns: int = 0       # missing, restored: how long nothing came
    missing_events: int = 0  # missing, restored: how many did not come in that time; missed: since the last one
    frames: int = 0          # policed, dropped: so many since the last such exception
    late_events: int = 0     # late: so many since the last such exception
    longest_ns: int = 0      # late: the time that one of these took in mlcca-relay
    answer: Answer = field(default_factory=Answer)  # what is decided now
