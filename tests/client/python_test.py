# SPDX-License-Identifier: BSD-2-Clause
"""The Python clients against a daemon that answers what a test wants. PYTHONPATH: where mlcca is installed."""
import asyncio
import os
import socket
import tempfile
import threading
import unittest

import mlcca
import mlcca.aio
from mlcca.session import encode
from mlcca.types import Cause, State
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
        self.listener.shutdown(socket.SHUT_RDWR)
        if self.connection:
            try:
                self.connection.shutdown(socket.SHUT_RDWR)
            except OSError:
                pass
        self.thread.join()
        self.listener.close()
        self.folder.cleanup()


class Clients:
    """The same program with either client: announces "stop" and takes so many exceptions."""

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
        self.assertEqual(self.causes([channels(True), event("switched")], [channels(True, 2), event("switched")],
                                     [channels(True, 1)], count=2), [Cause.DEGRADED, Cause.UPGRADED])

    def test_what_happens_to_events_is_given_with_its_numbers(self):
        _, all_of_them = self.both([channels(True), event("missing", silent_ns=161_000_000, missing=3), event("excess"),
                                    event("lapsed", 0), event("invented")], count=4)
        self.assertEqual([e.cause for e in all_of_them], [Cause.MISSING, Cause.POLICED, Cause.GATES_CLOSED, Cause.OTHER])
        self.assertEqual((all_of_them[0].silent_ns, all_of_them[0].missing_events), (161_000_000, 3))

    def test_a_daemon_that_is_lost_is_reported_and_the_channel_announced_again(self):
        _, all_of_them = self.both([channels(True)], [HANG_UP], [channels(False)], last=Cause.DAEMON_BACK, announcements=2)
        self.assertEqual(all_of_them[-1].answer.state, State.REFUSED)

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
        for wrong in ({"Speed": 1}, {"Period": "50 days"}, {"Omission": "2"}, {"Period": -1}):
            with self.assertRaises(ValueError):
                self.publisher("/none", lambda _: True, **wrong)


class Blocking(Clients, unittest.TestCase):
    def publisher(self, path, done, announcements=1, **stated):
        with mlcca.Client(path, patience=60, first_retry=0.001) as client:
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
    def publisher(self, path, done, announcements=1, **stated):
        async def program():
            async with mlcca.aio.Client(path, patience=60, first_retry=0.001) as client:
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
