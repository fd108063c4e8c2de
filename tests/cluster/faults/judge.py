# SPDX-License-Identifier: BSD-2-Clause
"""Whether what was seen from outside is what docs/explanation/cluster.md promises. Entries of the store are read here by
code of its own: proto/mlcca/v1/cluster.proto."""
from bisect import bisect_right

from world import DESCRIBED_BYTES, LAN_BYTES

PREFIX = "/mlcca/t/"
GRANTED = 1  # stage
# Of a lease: a beat is committed at most that long after it was handed over, or its time does not count from there.
LATEST_COMMIT = 0.25
CLOCK_ERROR = 0.001


def varint(data, at):
    value = shift = 0
    while True:
        octet = data[at]
        value |= (octet & 127) << shift
        at, shift = at + 1, shift + 7
        if octet < 128:
            return value, at


def fields(data):
    """Of a message of protobuf: by number, the values in order."""
    out, at = {}, 0
    while at < len(data):
        tag, at = varint(data, at)
        if tag & 7 == 0:
            value, at = varint(data, at)
        elif tag & 7 == 2:
            length, at = varint(data, at)
            value, at = data[at:at + length], at + length
        else:
            raise ValueError(f"wire type {tag & 7}")
        out.setdefault(tag >> 3, []).append(value)
    return out


def number(message, field):
    return message.get(field, [0])[0]


class Beat:
    def __init__(self, revision, value):
        message = fields(value)
        self.seen, self.after, self.revision = revision.seen, revision.after, revision.number
        self.lease = number(message, 9) / 1e9
        self.incarnation = number(message, 1) or revision.number


class Reservation:
    def __init__(self, revision, value):
        message = fields(value)
        self.channel = number(message, 2).decode()
        # By whose they are: publisher, admission and origin.
        self.rates = {bytes(number(rate, 2)): number(rate, 1) for rate in map(fields, message.get(4, []))}
        self.revision = revision.number


class Spell:
    """From the commit `start` on frames of a channel may pass, up to the commit `end`."""

    def __init__(self, start):
        self.start, self.end = start, None


class Judge:
    def __init__(self):
        self.wrong = []
        self.beats, self.fences, self.reservations, self.asked = {}, {}, {}, {}
        self.open = {}  # (gateway, id): its spell
        self.spells = {}  # channel: all of them, in order
        self.granted = {}  # key of an admission: revisions at which it was granted
        self.refused = set()  # keys that were answered so
        self.most = 0
        self.counts = {"revisions": 0, "reservations": 0, "beats": 0, "fences": 0}

    # The history of the store.

    def play(self, history, refused):
        self.refused = refused
        for revision in history:
            self.counts["revisions"] += 1
            for key, value in revision.events:
                if key.startswith(PREFIX):
                    self.take(revision, key[len(PREFIX):].split("/"), value)
            if any(key.startswith(PREFIX + "r/") and value is not None for key, value in revision.events):
                self.sum_up(revision)
            self.follow(revision)

    def take(self, revision, key, value):
        kind = key[0]
        if kind == "m" and value is not None:
            self.counts["beats"] += 1
            self.beats.setdefault(key[1], []).append(Beat(revision, value))
        elif kind == "f" and value is not None:
            self.counts["fences"] += 1
            self.fences[key[1]] = revision
        elif kind == "r":
            if value is None:
                self.reservations.pop((key[2], key[3]), None)
            else:
                self.counts["reservations"] += 1
                self.reservations[key[2], key[3]] = Reservation(revision, value)
        elif kind == "x":
            if value is None:
                self.asked.pop((key[1], key[2]), None)
            else:
                self.asked[key[1], key[2]] = value
                if number(fields(value), 1) == GRANTED:
                    self.granted.setdefault(self.admission_in(value), []).append(revision)

    @staticmethod
    def admission_in(value):
        """Its key: they are all made as k-NUMBER-."""
        at = value.find(b"k-")
        return value[at:value.index(b"-", at + 2)].decode() if at >= 0 else ""

    def is_dead(self, gateway, reservation):
        return gateway in self.fences and self.fences[gateway].number > reservation.revision

    def follow(self, revision):
        """Which channels are promised something from this revision on, and which no longer."""
        alive = set()
        for (gateway, number_), reservation in self.reservations.items():
            asked = self.asked.get((gateway, number_))
            if asked is None or number(fields(asked), 1) != GRANTED or self.is_dead(gateway, reservation) or \
                    self.admission_in(asked) in self.refused:
                continue
            alive.add((gateway, number_))
            if (gateway, number_) not in self.open:
                spell = self.open[gateway, number_] = Spell(revision)
                self.spells.setdefault(reservation.channel, []).append(spell)
        for key in set(self.open) - alive:
            self.open.pop(key).end = revision

    def may_send_at(self, gateway, revision):
        """At that commit a dead gateway may still send, surely."""
        last = [beat for beat in self.beats[gateway] if beat.revision < self.fences[gateway].number][-1]
        return last.after + last.lease * (1 - CLOCK_ERROR - LATEST_COMMIT) > revision.seen

    def sum_up(self, revision):
        rates = {}
        for (gateway, _), reservation in self.reservations.items():
            if not self.is_dead(gateway, reservation) or self.may_send_at(gateway, revision):
                # A channel that is decided again has two entries for a while, of the same traffic.
                for source, rate in reservation.rates.items():
                    key = (gateway, reservation.channel, source)
                    rates[key] = max(rates.get(key, 0), rate)
        total = DESCRIBED_BYTES + sum(rates.values())
        self.most = max(self.most, total)
        if total > LAN_BYTES:
            self.wrong.append(f"revision {revision.number}: {total} bytes/s are promised of {LAN_BYTES}: {rates}")

    # Frames.

    def judge(self, gateway, channel, times):
        """No frame after what allowed it has ended: the reservation (given back, or fenced), or the lease."""
        spells = self.spells.get(channel, [])
        starts = [spell.start.after for spell in spells]
        beats = self.beats.get(gateway, [])
        sent = [beat.after for beat in beats]
        for moment in times:
            at = bisect_right(starts, moment)  # spells that may have begun before
            reserved = any(spell.end is None or spell.end.seen > moment for spell in spells[:at])
            if not reserved:
                end = spells[at - 1].end if at else None
                self.wrong.append(f"{channel} of {gateway}: a frame at {moment:.3f}, when nothing is reserved: " + (
                    f"that ended with revision {end.number} ({', '.join(key for key, _ in end.events)}), seen at "
                    f"{end.seen:.3f}" if end else "nothing was before"))
                return
            last = bisect_right(sent, moment) - 1
            if last < 0 or max(beat.seen + beat.lease for beat in beats[:last + 1][-50:]) < moment:
                self.wrong.append(f"{channel} of {gateway}: a frame at {moment:.3f}, after its lease" + (
                    f": the latest beat was seen at {beats[last].seen:.3f}" if last >= 0 else ""))
                return

    # Answers.

    def answered(self, key, granted, moment):
        revisions = self.granted.get(key, [])
        if granted and not any(revision.after <= moment for revision in revisions):
            self.wrong.append(f"{key} was answered granted at {moment:.3f}, and the store had nothing of it")
