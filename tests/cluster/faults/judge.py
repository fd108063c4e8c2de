# SPDX-License-Identifier: BSD-2-Clause
"""Whether what was seen from outside is what docs/explanation/cluster.md promises. Entries of the store are read here by
code of its own: proto/mlcca/v1/cluster.proto."""
from bisect import bisect_right

from world import CAPACITY, DESCRIBED

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
        self.generation, self.applied = number(message, 5), number(message, 6)
        self.carries = (self.incarnation, number(message, 7), number(message, 8))  # with its role, and whether it drains


class Asked:
    """A request to other gateways. Its revision is the one at which it was written last."""

    def __init__(self, revision, value):
        message = fields(value)
        self.value, self.revision = value, revision.number
        self.granted = number(message, 1) == GRANTED
        asking = fields(message[2][0]) if 2 in message else {}
        self.channel = asking.get(1, [b""])[0].decode()


class Current:
    """A description in force, until the next entry of that kind."""

    def __init__(self, revision, value):
        message = fields(value)
        self.generation, self.open = number(message, 1), bool(number(message, 4))
        self.start, self.end = revision, None


class Reservation:
    def __init__(self, revision, value):
        message = fields(value)
        self.channel = number(message, 2).decode()
        # By whose they are: publisher, admission and origin.
        self.rates = {bytes(number(rate, 2)): number(rate, 1) for rate in map(fields, message.get(4, []))}
        self.revision = revision.number


class Spell:
    """From the commit `start` on frames of a channel may pass, up to the commit `end`, or until the gateway has said that
    it knows of that commit."""

    def __init__(self, start):
        self.start, self.end = start, None


class Judge:
    def __init__(self):
        self.wrong = []
        self.beats, self.fences, self.reservations, self.asked = {}, {}, {}, {}
        self.open = {}  # (gateway, id): its spell
        self.spells = {}  # channel: all of them, in order
        self.agreed = set()  # (gateway that agrees, gateway that asks, id)
        self.open_across, self.spells_across = {}, {}  # the same of what a gateway carries for another one
        self.currents = []  # descriptions, in order
        self.changes = []  # revisions after which another gateway may carry what several could
        self.granted = {}  # key of an admission: revisions at which it was granted
        self.refused = set()  # keys that were answered so
        self.most = dict.fromkeys(CAPACITY, 0)
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
                for network in CAPACITY:
                    self.sum_up(revision, network)
            self.follow(revision)

    def take(self, revision, key, value):
        kind = key[0]
        if kind == "m" and value is not None:
            self.counts["beats"] += 1
            beats = self.beats.setdefault(key[1], [])
            beats.append(Beat(revision, value))
            if len(beats) == 1 or beats[-1].carries != beats[-2].carries:
                self.changes.append(revision)
        elif kind == "f" and value is not None:
            self.counts["fences"] += 1
            self.fences[key[1]] = revision
            self.changes.append(revision)
        elif kind == "r":
            if value is None:
                self.reservations.pop(tuple(key[1:]), None)
            else:
                self.counts["reservations"] += 1
                self.reservations[tuple(key[1:])] = Reservation(revision, value)
        elif kind == "x":
            self.take_asked(revision, (key[1], key[2]), value)
        elif kind == "a":
            self.agreed.discard((key[1], key[2], key[3]))
            if value is not None and number(fields(value), 2):
                self.agreed.add((key[1], key[2], key[3]))
        elif key == ["d", "current"] and value is not None:
            if self.currents:
                self.currents[-1].end = revision
            self.currents.append(Current(revision, value))

    def take_asked(self, revision, key, value):
        if value is None:
            self.asked.pop(key, None)
            return
        self.asked[key] = Asked(revision, value)
        if self.asked[key].granted:
            self.granted.setdefault(self.admission_in(value), []).append(revision)

    @staticmethod
    def admission_in(value):
        """Its key: they are all made as k-NUMBER-."""
        at = value.find(b"k-")
        return value[at:value.index(b"-", at + 2)].decode() if at >= 0 else ""

    def is_dead(self, gateway, entry):
        return gateway in self.fences and self.fences[gateway].number > entry.revision

    def follow(self, revision):
        """Which channels are promised something from this revision on, and which no longer."""
        alive = {}
        for (_, gateway, number_), reservation in self.reservations.items():
            asked = self.asked.get((gateway, number_))
            if asked is not None and asked.granted and not self.is_dead(gateway, reservation) and \
                    self.admission_in(asked.value) not in self.refused:
                alive[gateway, number_] = reservation.channel
        self.change(revision, alive, self.open, self.spells)
        across = {}
        for carrier, gateway, number_ in self.agreed:
            asked = self.asked.get((gateway, number_))
            if asked is not None and asked.granted and not self.is_dead(gateway, asked):
                across[carrier, gateway, number_] = carrier, asked.channel
        self.change(revision, across, self.open_across, self.spells_across)

    @staticmethod
    def change(revision, alive, opened, spells):
        """`alive`: by key, whose spell it is."""
        for key, whose in alive.items():
            if key not in opened:
                opened[key] = Spell(revision)
                spells.setdefault(whose, []).append(opened[key])
        for key in set(opened) - set(alive):
            opened.pop(key).end = revision

    def may_send_at(self, gateway, revision):
        """At that commit a dead gateway may still send, surely."""
        last = [beat for beat in self.beats[gateway] if beat.revision < self.fences[gateway].number][-1]
        return last.after + last.lease * (1 - CLOCK_ERROR - LATEST_COMMIT) > revision.seen

    def sum_up(self, revision, medium):
        rates = {}
        for (network, gateway, _), reservation in self.reservations.items():
            if network == medium and (not self.is_dead(gateway, reservation) or self.may_send_at(gateway, revision)):
                # A channel that is decided again has two entries for a while, of the same traffic.
                for source, rate in reservation.rates.items():
                    key = (gateway, reservation.channel, source)
                    rates[key] = max(rates.get(key, 0), rate)
        total = DESCRIBED[medium] + sum(rates.values())
        self.most[medium] = max(self.most[medium], total)
        if total > CAPACITY[medium]:
            self.wrong.append(f"revision {revision.number}: {total} bytes/s of {CAPACITY[medium]} are promised on {medium}: "
                              f"{rates}")

    # Frames.

    def judge(self, gateway, channel, times):
        """No frame after what allowed it has ended: the reservation (given back, or fenced), or the lease."""
        spells = self.spells.get(channel, [])
        starts = [spell.start.after for spell in spells]
        for moment in times:
            at = bisect_right(starts, moment)  # spells that may have begun before
            if not any(spell.end is None or spell.end.seen > moment for spell in spells[:at]):
                end = spells[at - 1].end if at else None
                self.wrong.append(f"{channel} of {gateway}: a frame at {moment:.3f}, when nothing is reserved: " + (
                    f"that ended with revision {end.number} ({', '.join(key for key, _ in end.events)}), seen at "
                    f"{end.seen:.3f}" if end else "nothing was before"))
                return
        self.judge_lease(gateway, channel, times)

    def judge_lease(self, gateway, channel, times):
        beats = self.beats.get(gateway, [])
        sent = [beat.after for beat in beats]
        for moment in times:
            last = bisect_right(sent, moment) - 1
            if last < 0 or max(beat.seen + beat.lease for beat in beats[:last + 1][-50:]) < moment:
                self.wrong.append(f"{channel} of {gateway}: a frame at {moment:.3f}, after its lease" + (
                    f": the latest beat was seen at {beats[last].seen:.3f}" if last >= 0 else ""))
                return

    def judge_across(self, gateway, channel, times):
        """What a gateway carries for another one: only what that one has asked for and this one has agreed to. After the
        end no frame comes once this gateway has said that it acted on it; and never one after its lease."""
        spells = self.spells_across.get((gateway, channel), [])
        starts = [spell.start.after for spell in spells]
        ends = [self.acted_on(gateway, spell.end) for spell in spells]
        for moment in times:
            at = bisect_right(starts, moment)
            if not any(end is None or end > moment for end in ends[:at]):
                self.wrong.append(f"{channel} carried by {gateway}: a frame at {moment:.3f}, " + (
                    f"though it said at {ends[at - 1]:.3f} that it had acted on revision {spells[at - 1].end.number}" if at else
                    "and it had not agreed to any"))
                return
        self.judge_lease(gateway, channel, times)

    def acted_on(self, gateway, revision):
        """When that was known surely; None: never."""
        if revision is None:
            return None
        return next((beat.seen for beat in self.beats.get(gateway, [])
                     if beat.revision > revision.number and beat.applied >= revision.number), None)

    def judge_one_carrier(self, times):
        """`times` by gateway, of one channel that several could carry. After another one has begun, a gateway sends nothing
        until a revision has made it the carrier again."""
        frames = sorted((moment, gateway) for gateway, all_of in times.items() for moment in all_of)
        self.counts["carriers"] = 0
        begun = None  # when the one that carries now began
        for (_, before), (moment, gateway) in zip(frames, frames[1:]):
            if gateway == before:
                continue
            self.counts["carriers"] += 1
            if begun is not None and not any(change.seen >= begun and change.after <= moment for change in self.changes):
                self.wrong.append(f"{before} carries since {begun:.3f}, and {gateway} sends a frame at {moment:.3f}")
                return
            begun = moment

    def judge_rollouts(self, gateway, times):
        """No frame on a shared network from the moment at which a gateway says that it uses the next description until that
        is open."""
        self.counts["rollouts"] = sum(1 for one in self.currents if not one.open)
        for current in self.currents:
            end = current.end.after if current.end else float("inf")
            said = next((beat.seen for beat in self.beats.get(gateway, [])
                         if beat.revision > current.start.number and beat.generation == current.generation), None)
            if current.open or said is None or current.end and said > end:
                continue
            self.none_between(gateway, times, said, end, f"generation {current.generation} of the description is closed")

    def none_between(self, gateway, times, start, end, why):
        """`times`: sorted."""
        at = bisect_right(times, start)
        if at < len(times) and times[at] < end:
            self.wrong.append(f"{gateway}: a frame at {times[at]:.3f}, and from {start:.3f} to {end:.3f} {why}")

    # Answers.

    def answered(self, key, granted, moment):
        revisions = self.granted.get(key, [])
        if granted and not any(revision.after <= moment for revision in revisions):
            self.wrong.append(f"{key} was answered granted at {moment:.3f}, and the store had nothing of it")
