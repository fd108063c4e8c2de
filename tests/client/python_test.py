# SPDX-License-Identifier: BSD-2-Clause
"""The Python clients against a daemon that answers what a test wants. PYTHONPATH: where mlcca is installed."""
import asyncio
import os
import re
import socket
import tempfile
import threading
import time
import unittest

import mlcca
import mlcca.aio
from mlcca.events import encode
from mlcca.session import HAPPENED, MOST_EVENTS, Part, Role, VERDICT
from mlcca.types import Cause, Published, State
from mlcca.v1 import control_pb2

SUBJECT = 0x73746f7000000000


def channels(granted, attribute_set=0):
    reply = control_pb2.Reply()
    reply.channels.SetInParent()
    if granted is not None:
        one = reply.channels.channels.add(subject=SUBJECT, name="stop", publisher="lever", to="field", granted=granted,
                                          set=attribute_set, reason="1 to spare" if granted else "3 too many")
        setattr(one, "from", "panel")
        one.rows.add(where="field", attribute="Omission", unit="events", required=2, provided_known=True, provided=1,
                     outcome=control_pb2.OUTCOME_FIT, margin="1 to spare")
    return reply


def granted_for(**endpoint):
    """Events go to, or come from, a program on this gateway."""
    reply = channels(True)
    reply.channels.endpoints.add(**endpoint)
    return reply


def event(kind, subject=SUBJECT, **more):
    return control_pb2.Reply(event=control_pb2.Event(kind=kind, subject=subject, channel="stop" if subject else "",
                                                     message=f"what is {kind}", **more))


def error(text):
    return control_pb2.Reply(error=control_pb2.Error(kind=control_pb2.ERROR_FORBIDDEN, message=text))


HANG_UP = "hang up"


class Daemon:
    """Answers each request with the next list of replies, and with the last one again."""

    def __init__(self, *answers, path=None):
        self.folder = tempfile.TemporaryDirectory()
        self.path = path or os.path.join(self.folder.name, "control.sock")
        self.answers = list(answers)
        self.requests = []
        self.pings, self.knows_pings = 0, True
        self.runs = threading.Event()  # cleared: it hangs
        self.runs.set()
        self.listener = socket.socket(socket.AF_UNIX)
        self.listener.bind(self.path)
        self.listener.listen()
        self.connection = None
        self.thread = threading.Thread(target=self.run, daemon=True)
        self.thread.start()

    def run(self):
        while True:
            try:
                self.connection, _ = self.listener.accept()
            except OSError:
                return
            with self.connection, self.connection.makefile("rb") as stream:
                self.serve(stream)

    def serve(self, stream):
        while head := stream.read(1):
            request = control_pb2.Request.FromString(stream.read(head[0]))
            self.runs.wait()
            if request.HasField("ping"):
                self.pings += 1
                if not self.knows_pings:
                    self.connection.sendall(encode(error("this request is unknown")))
                    return
                self.connection.sendall(encode(control_pb2.Reply(id=request.id, done=control_pb2.Done())))
                continue
            self.requests.append(request)
            answer = self.answers.pop(0) if len(self.answers) > 1 else self.answers[0]
            for reply in answer:
                if reply == HANG_UP:
                    return
                if isinstance(reply, control_pb2.Reply):
                    if not reply.HasField("event"):
                        reply.id = request.id
                    reply = encode(reply)
                self.connection.sendall(reply)

    def close(self):
        self.runs.set()
        self.listener.shutdown(socket.SHUT_RDWR)
        if self.connection:
            try:
                self.connection.shutdown(socket.SHUT_RDWR)
            except OSError:
                pass
        self.thread.join()
        self.listener.close()
        self.folder.cleanup()


class Chatty(Daemon):
    """Something happens all the time."""

    def serve(self, stream):
        over = threading.Event()

        def talk():
            while not over.wait(0.01):
                try:
                    self.connection.sendall(encode(event("dropped")))
                except OSError:
                    return
        talking = threading.Thread(target=talk, daemon=True)
        talking.start()
        try:
            super().serve(stream)
        finally:
            over.set()
            talking.join()


class Clients:
    """The same program with either client: announces "stop" and takes so many exceptions."""

    longest_retry = 1
    answers_within = 5

    def publisher(self, path, done, announcements=1, **stated):
        """The answer, and the exceptions until `done` says so of them."""
        raise NotImplementedError

    def both(self, *answers, count=0, last=None, announcements=1, **stated):
        def done(exceptions):
            return len(exceptions) >= count and (last is None or exceptions[-1:] != [] and exceptions[-1].cause is last)

        daemon = Daemon(*answers)
        try:
            given, exceptions = self.publisher(daemon.path, done, announcements, **stated)
        finally:
            daemon.close()
        self.requests = daemon.requests
        return given, exceptions

    def causes(self, *answers, count):
        return [e.cause for e in self.both(*answers, count=count)[1]]

    def test_an_announcement_gets_what_is_decided_with_its_reasons(self):
        given, _ = self.both([channels(True)], Period="50ms", Omission=2)
        self.assertEqual((given.state, given.reason), (State.GRANTED, "1 to spare"))
        self.assertEqual(given.deliveries[0].source, "panel")
        self.assertEqual(given.deliveries[0].checks[0].provided, 1)
        asked = self.requests[0].announce
        self.assertEqual((asked.channel, asked.role, asked.name), ("stop", control_pb2.ROLE_PUBLISHER, "lever"))
        self.assertEqual([(a.name, a.value) for a in asked.attributes], [("Period", 50_000_000), ("Omission", 2)])

    def test_what_is_refused_gives_the_reason(self):
        for answer, state, reason in (([channels(False)], State.REFUSED, "3 too many"),
                                      ([channels(None)], State.REFUSED, "nobody is at the other end"),
                                      ([error("not for you")], State.REJECTED, "not for you")):
            given, _ = self.both(answer)
            self.assertEqual((given.state, given.reason), (state, reason))

    def test_a_reply_in_slices_is_one(self):
        first, second = channels(True), channels(False)
        first.more = True
        given, _ = self.both([first, second])
        self.assertEqual((given.state, len(given.deliveries)), (State.PARTLY, 2))

    def test_a_verdict_that_changes_is_asked_for(self):
        self.assertEqual(self.causes([channels(True), event("withdrawn")], [channels(False), event("granted")],
                                     [channels(True)], count=2), [Cause.WITHDRAWN, Cause.GRANTED])

    def test_changes_of_other_ends_are_none(self):
        self.assertEqual(self.causes([channels(True), event("refused")], [channels(True), event("missing")], count=1),
                         [Cause.MISSING])

    def test_a_withdrawal_is_told_also_where_the_next_answer_is_granted_again(self):
        self.assertEqual(self.causes([channels(True), event("withdrawn"), event("granted")], [channels(True)], count=2),
                         [Cause.WITHDRAWN, Cause.GRANTED])

    def test_where_events_go_is_asked_for_without_an_exception(self):
        for kind in ("local", "binding"):
            self.assertEqual(self.causes([channels(True), event(kind)], [channels(True), event("missing")], count=1),
                             [Cause.MISSING])

    def test_kinds_of_events_mean_the_same_in_both_languages(self):
        table = os.path.join(os.path.dirname(__file__), "../../control/event_kinds.inc")
        with open(table, encoding="utf-8") as file:
            kinds = re.findall(r'^MLCCA_(?:CLIENT_)?EVENT\((?:\w+, )?"([a-z-]+)", .*?(\w+), (\w+)\)$', file.read(), re.M)
        # Clients that do not ask for exact kinds get each withdrawal as "withdrawn".
        exact = {"revoked", "network-down", "removed"}
        self.assertEqual({kind for kind, meaning, _ in kinds if meaning != "happened"} - exact, VERDICT)
        self.assertEqual({kind: cause for kind, meaning, cause in kinds if meaning == "happened" and cause != "other"},
                         {kind: cause.name.lower() for kind, cause in HAPPENED.items()})

    def test_many_events_are_one_request(self):
        self.assertEqual(self.causes([channels(True)] + [event("withdrawn")] * 500, [channels(False)], count=1),
                         [Cause.WITHDRAWN])
        self.assertLessEqual(len(self.requests), 4)

    def test_a_reload_is_asked_for_and_a_rejection_is_an_exception(self):
        invalid = error("Period 50 ms is announced")
        self.assertEqual(self.causes([channels(True), event("reload", 0)], [invalid, event("reload", 0)], [channels(True)],
                                     count=2), [Cause.REJECTED, Cause.GRANTED])

    def test_after_events_that_were_lost_it_is_asked_again(self):
        self.assertEqual(self.causes([channels(True), event("lagged", 0)], [channels(False)], count=1), [Cause.WITHDRAWN])

    def test_a_network_that_is_down_is_told_as_such_and_by_its_name(self):
        _, told = self.both([channels(True), event("withdrawn", network_down="second-can")], [channels(False)], count=1)
        self.assertEqual([(e.cause, e.network, e.answer.state) for e in told],
                         [(Cause.NETWORK_DOWN, "second-can", State.REFUSED)])

    def test_what_was_missing_is_not_said_any_more_once_it_is_restored(self):
        troubled = channels(True)
        troubled.channels.channels[0].problems.append("nothing has come for 161 ms")
        given, told = self.both([troubled, event("restored")], [channels(True)], count=1)
        # With asyncio it is the answer as of when the caller goes on, which may be after the event.
        self.assertIn(given.deliveries[0].problem, ("nothing has come for 161 ms", ""))
        self.assertEqual(told[0].answer.deliveries[0].problem, "")

    def test_a_grant_further_on_is_told_to_subscribers(self):
        daemon = Daemon([channels(True), event("granted", network="middle")])
        with mlcca.Client(daemon.path, patience=60) as client:
            told = []
            stop = client.subscriber("stop")
            stop.on_exception = told.append
            stop.subscribe()
            while not told:
                client.wait(60)
            self.assertEqual([e.cause for e in told], [Cause.GRANTED])
            self.assertEqual(len(daemon.requests), 1)
        daemon.close()

    def test_what_happens_to_others_is_not_told(self):
        _, told = self.both([channels(True), event("missing", publisher="other"), event("withdrawn", publisher="other"),
                             event("restored", publisher="lever")], [channels(True)], count=1)
        self.assertEqual([(e.cause, e.publisher) for e in told], [(Cause.RESTORED, "lever")])

    def test_what_a_daemon_cannot_answer_is_asked_for_later(self):
        busy = control_pb2.Reply(error=control_pb2.Error(kind=control_pb2.ERROR_WORLD, message="no memory"))
        given, told = self.both([busy], [channels(True)], count=1)
        self.assertEqual((given.state, given.reason), (State.NO_DAEMON, "no memory"))
        self.assertEqual(told[0].cause, Cause.DAEMON_BACK)

    def test_another_attribute_set_is_degraded_or_upgraded(self):
        self.assertEqual(self.causes([channels(True), event("degraded")], [channels(True, 2), event("upgraded")],
                                     [channels(True, 1)], count=2), [Cause.DEGRADED, Cause.UPGRADED])

    def test_what_happens_to_events_is_given_with_its_numbers(self):
        _, all_of_them = self.both([channels(True), event("missing", silent_ns=161_000_000, missing=3), event("policed", frames=12),
                                    event("late", late=5, longest_ns=7_000_000), event("lapsed", 0), event("invented")], count=5)
        self.assertEqual([e.cause for e in all_of_them],
                         [Cause.MISSING, Cause.POLICED, Cause.LATE, Cause.GATES_CLOSED, Cause.OTHER])
        self.assertEqual(all_of_them[1].frames, 12)
        self.assertEqual((all_of_them[2].late_events, all_of_them[2].longest_ns), (5, 7_000_000))
        self.assertEqual((all_of_them[0].silent_ns, all_of_them[0].missing_events), (161_000_000, 3))

    def test_a_daemon_that_is_lost_is_reported_and_the_channel_announced_again(self):
        _, all_of_them = self.both([channels(True)], [HANG_UP], [channels(False)], last=Cause.DAEMON_BACK, announcements=2)
        self.assertEqual(all_of_them[-1].answer.state, State.REFUSED)

    def test_a_daemon_that_hangs_is_gone_and_is_back_when_it_answers_again(self):
        self.answers_within = 0.2
        daemon = Daemon([channels(True)], [channels(False)])
        self.addCleanup(daemon.close)

        def done(exceptions):
            if not exceptions:
                daemon.runs.clear()
            elif len(exceptions) == 1:
                daemon.runs.set()
            return len(exceptions) >= 2
        given, exceptions = self.publisher(daemon.path, done)
        self.assertEqual(given.state, State.GRANTED)
        self.assertEqual([e.cause for e in exceptions[:2]], [Cause.DAEMON_GONE, Cause.DAEMON_BACK])
        self.assertEqual(exceptions[0].text, "mlccad does not answer: nothing has come from it for 0.2 s")
        self.assertEqual(exceptions[1].answer.state, State.REFUSED)

    def test_a_daemon_that_does_not_know_pings_is_not_asked_again(self):
        self.answers_within = 0.1
        daemon = Daemon([channels(True)])
        daemon.knows_pings = False
        self.addCleanup(daemon.close)
        _, exceptions = self.publisher(daemon.path, lambda exceptions: len(exceptions) >= 2)
        self.assertEqual([e.cause for e in exceptions], [Cause.DAEMON_GONE, Cause.DAEMON_BACK])
        self.assertEqual(daemon.pings, 1)

    def test_what_is_no_reply_ends_the_connection(self):
        for garbage in (b"\x05\xff\xff\xff\xff\xff", b"\xff\xff\xff\xff\x7f", b"\xff" * 9, b"\x00"):
            given, _ = self.both([channels(True), garbage], [channels(True)], last=Cause.DAEMON_BACK)
            self.assertIn(given.state, (State.GRANTED, State.NO_DAEMON))

    def test_without_a_daemon_it_is_said_at_once(self):
        with tempfile.TemporaryDirectory() as folder:
            given, _ = self.publisher(f"{folder}/none", lambda _: True)
            self.assertEqual(given.state, State.NO_DAEMON)
            self.assertEqual(given.reason, f"no daemon: {folder}/none: No such file or directory")

    def test_values_are_checked(self):
        for wrong in ({"Speed": 1}, {"Period": "50 days"}, {"Omission": "2"}, {"Period": -1}, {"Period": 50.0},
                      {"Omission": None}, {"Omission": True}, {"Period": b"50ms"}):
            with self.assertRaisesRegex(ValueError, next(iter(wrong))):
                self.publisher("/none", lambda _: True, **wrong)

    def through(self, events, take, user=os.getuid()):
        """What take(SUBSCRIBER'S PATH, PUBLISH) gives, where PUBLISH() publishes the events and gives what became of each."""
        of_subscriber = self.of_subscriber = Daemon([granted_for(user=user)])
        publishers = []

        def publish():
            local = of_subscriber.requests[0].announce.local
            of_publisher = Daemon([granted_for(local=local)])
            publishers.append(of_publisher)
            with mlcca.Client(of_publisher.path, patience=60) as client:
                stop = client.publisher("stop")
                before = stop.publish(b"early")
                stop.announce()
                return [before] + [stop.publish(event) for event in events]
        try:
            return take(of_subscriber.path, publish)
        finally:
            for daemon in publishers + [of_subscriber]:
                daemon.close()

    def test_events_go_from_one_program_to_the_other(self):
        sent, came = self.through([b"go", b"", bytes(65_536), b"end"], self.subscriber)
        self.assertEqual(sent, [Published.NOT_GRANTED, Published.SENT, Published.SENT, Published.TOO_LONG, Published.SENT])
        self.assertEqual([e.data for e in came], [b"go", b"", b"end"])
        self.assertEqual({e.network for e in came}, {""})
        self.assertGreater(came[0].received_ns, 1_600_000_000_000_000_000)

    def test_who_does_not_know_the_key_fills_no_queue(self):
        def take(path, publish):
            def flooded():
                name = b"\0" + self.of_subscriber.requests[0].announce.local[:5].encode()
                with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as unadmitted:
                    unadmitted.setblocking(False)
                    for _ in range(600):  # raises BlockingIOError where a queue is full
                        unadmitted.sendto(SUBJECT.to_bytes(8, "big") + b"flood", name)
                return publish()
            return self.subscriber(path, flooded)
        sent, came = self.through([b"go", b"end"], take)
        self.assertEqual(sent[1:], [Published.SENT, Published.SENT])
        self.assertEqual([e.data for e in came], [b"go", b"end"])

    def test_endpoints_that_cannot_be_used_are_an_exception(self):
        wrong = channels(True)
        wrong.channels.endpoints.add(network="field", interface="none0", ifindex=999_999)
        _, told = self.both([wrong], count=1)
        self.assertEqual(told[0].cause, Cause.OTHER)
        self.assertIn("its events cannot be carried: field: none0", told[0].text)

    def test_endpoints_that_cannot_be_used_are_tried_again(self):
        wrong = channels(True)
        wrong.channels.endpoints.add(network="field", interface="none0", ifindex=999_999)
        _, told = self.both([wrong], [wrong], [channels(True)], count=2)
        self.assertEqual(told[1].text, "its events can be carried again")

    def test_a_place_for_events_of_programs_is_asked_for_again(self):
        full = channels(True)
        full.channels.local_problem = "all places are taken"
        answers, told = self.both([full], [full], [channels(True)], count=2)
        self.assertEqual(told[0].text, "its events cannot be carried: programs on this gateway: all places are taken")
        self.assertEqual(told[1].text, "its events can be carried again")

    def test_what_else_happens_neither_puts_a_retry_off_nor_makes_more_of_it(self):
        self.longest_retry = 0.2
        wrong = channels(True)
        wrong.channels.endpoints.add(network="field", interface="none0", ifindex=999_999)
        daemon = Chatty([wrong])
        began = time.monotonic()
        try:
            self.publisher(daemon.path, lambda _: len(daemon.requests) >= 6)
        finally:
            daemon.close()
        self.assertGreaterEqual(time.monotonic() - began, 5 * self.longest_retry)


class Blocking(Clients, unittest.TestCase):
    def subscriber(self, path, publish):
        with mlcca.Client(path, patience=60) as client:
            stop = client.subscriber("stop")
            came = []
            stop.on_event = came.append
            stop.subscribe()
            sent = publish()
            while b"end" not in [event.data for event in came]:
                client.wait(60)
            self.assertEqual(stop.lost, 0)
            return sent, came

    def test_what_a_handler_raises_comes_out_and_the_other_events_are_kept(self):
        def take(path, publish):
            with mlcca.Client(path, patience=60) as client:
                stop = client.subscriber("stop")
                came = []

                def handler(event):
                    came.append(event.data)
                    if event.data == b"1":
                        raise ZeroDivisionError
                stop.on_event = handler
                stop.subscribe()
                publish()
                with self.assertRaises(ZeroDivisionError):
                    client.wait(60)
                self.assertEqual(came, [b"1"])
                client.wait(60)
                self.assertEqual(came, [b"1", b"2"])
                stop.on_event = lambda _: stop.close()
                publish()
                client.wait(60)
                stop.on_event = came.append
                client.process()
                self.assertEqual(came, [b"1", b"2"])
        self.through([b"1", b"2"], take)

    def test_events_of_other_users_do_not_come(self):
        def take(path, publish):
            with mlcca.Client(path, patience=60) as client:
                stop = client.subscriber("stop")
                stop.on_event = lambda event: self.fail("an event of another user")
                stop.subscribe()
                self.assertEqual(publish()[1:], [Published.SENT])
                client.process()
        self.through([b"1"], take, user=os.getuid() + 1)

    def test_a_refusal_further_on_is_told_to_a_subscriber(self):
        daemon = Daemon([channels(True), event("refused", network="middle")], [channels(True)])
        try:
            with mlcca.Client(daemon.path, patience=60) as client:
                stop, told = client.subscriber("stop"), []
                stop.on_exception = told.append
                stop.subscribe()
                while not told:
                    client.wait(60)
        finally:
            daemon.close()
        self.assertEqual([(e.cause, e.text) for e in told], [(Cause.REFUSED, "what is refused")])

    def test_after_close_there_is_nothing(self):
        client = mlcca.Client("/none")
        stop, brake = client.publisher("stop"), client.subscriber("brake")
        client.close()
        client.close()
        self.assertEqual((stop.publish(b"go"), brake.lost), (Published.NOT_GRANTED, 0))
        client.process()
        for call in (stop.announce, brake.subscribe, lambda: client.wait(1)):
            with self.assertRaisesRegex(RuntimeError, "the client is closed"):
                call()

    def publisher(self, path, done, announcements=1, **stated):
        with mlcca.Client(path, patience=60, first_retry=0.001, longest_retry=self.longest_retry,
                          answers_within=self.answers_within) as client:
            stop = client.publisher("stop", "lever", **stated)
            exceptions = []
            stop.on_exception = exceptions.append
            for _ in range(announcements):
                given = stop.announce()
            while not done(exceptions):
                client.wait(60)
            return given, exceptions

    def test_a_handler_may_close_its_channel(self):
        daemon = Daemon([channels(True), event("missing"), event("restored")])
        with mlcca.Client(daemon.path, patience=60) as client:
            stop = client.publisher("stop")
            called = []

            def handler(exception):
                called.append(exception)
                stop.close()
            stop.on_exception = handler
            stop.announce()
            while not called:
                client.wait(60)
            client.process()
            self.assertEqual(len(called), 1)
            self.assertRaises(RuntimeError, lambda: (client.close(), client.wait()))
        daemon.close()


class Asyncio(Clients, unittest.TestCase):
    def subscriber(self, path, publish, wait_for=b"end"):
        async def program():
            async with mlcca.aio.Client(path, patience=60) as client:
                stop = client.subscriber("stop")
                await stop.subscribe()
                sent = await asyncio.to_thread(publish)
                came = []
                async for event in stop.events():
                    came.append(event)
                    if event.data == wait_for:
                        break
                self.lost = stop.lost
                return sent, came
        return asyncio.run(asyncio.wait_for(program(), 120))

    def test_a_publisher_of_asyncio_is_the_same(self):
        async def program(path):
            async with mlcca.aio.Client(path, patience=60) as client:
                stop = client.publisher("stop")
                before = stop.publish(b"early")
                await stop.announce()
                return before, stop.publish(b"go")
        daemon = Daemon([granted_for(local="0" * 20)])  # it is no address
        try:
            self.assertEqual(asyncio.run(asyncio.wait_for(program(daemon.path), 120)), (Published.NOT_GRANTED, Published.LOST))
        finally:
            daemon.close()

    def test_events_that_are_not_taken_are_bounded_and_counted(self):
        part = Part("stop", Role.SUBSCRIBER, "", {})
        for number in range(MOST_EVENTS + 3):
            part.arrived(mlcca.Event(b"%d" % number, "", 0))
        self.assertEqual((len(part.events), part.untaken), (MOST_EVENTS, 3))
        self.assertEqual(part.events[0].data, b"0")

    def publisher(self, path, done, announcements=1, **stated):
        async def program():
            async with mlcca.aio.Client(path, patience=60, first_retry=0.001, longest_retry=self.longest_retry,
                                        answers_within=self.answers_within) as client:
                stop = client.publisher("stop", "lever", **stated)
                exceptions = []
                for _ in range(announcements):
                    given = await stop.announce()
                arriving = stop.exceptions()
                while not done(exceptions):
                    exceptions.append(await anext(arriving))
                return given, exceptions
        return asyncio.run(asyncio.wait_for(program(), 120))


if __name__ == "__main__":
    unittest.main()
