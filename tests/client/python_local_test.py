# SPDX-License-Identifier: BSD-2-Clause
"""mlcca in Python: events between programs on a gateway, what wakes a loop, and tables that are those of the library in C++."""
import array
import asyncio
import os
import re
import select
import socket
import sys
import tempfile
import unittest

import mlcca
import mlcca.aio
from mlcca import Cause, State
from mlcca.session import FURTHER_ON, MOST_REQUEST, ONLY_INFORM
from mlcca.types import Published
from mlcca.v1 import control_pb2
from python_test import Daemon, channels, event, granted_for

CLIENT = os.path.join(os.path.dirname(__file__), "../../client")
SECOND = 1_000_000_000


def source(name):
    with open(f"{CLIENT}/{name}", encoding="utf-8") as file:
        return file.read()


class Tables(unittest.TestCase):
    def test_what_only_informs_is_the_same_in_both_languages(self):
        body = re.search(r"bool only_informs\(.*?\n}", source("part.cc"), re.S)[0]
        self.assertEqual(set(re.findall(r"case Cause::(\w+):", body)), {cause.name.lower() for cause in ONLY_INFORM})

    def test_what_is_said_further_on_is_the_same_in_both_languages(self):
        found = re.findall(r'event\.kind == "(\w+)"\) return Cause::(\w+);', source("answers.cc"))
        self.assertEqual(dict(found), {kind: cause.name.lower() for kind, cause in FURTHER_ON.items()})

    def test_causes_are_the_same_in_both_languages(self):
        with open(f"{CLIENT}/../include/mlcca/client/client.hpp", encoding="utf-8") as file:
            body = re.search(r"enum class Cause[^{]*{(.*?)};", file.read(), re.S)[1]
        self.assertEqual(set(re.findall(r"^\s*(\w+),", body, re.M)), {cause.name.lower() for cause in Cause})


class Local(unittest.TestCase):
    def subscriber(self, client, daemon):
        """It, and who publishes to it."""
        stop = client.subscriber("stop")
        stop.subscribe()
        self.publishers = Daemon([granted_for(local=daemon.requests[0].announce.local)])
        self.addCleanup(self.publishers.close)
        publisher = mlcca.Client(self.publishers.path, patience=60)
        self.addCleanup(publisher.close)
        self.publisher = publisher
        lever = publisher.publisher("stop")
        lever.announce()
        return stop, lever

    def start(self, **endpoint):
        daemon = Daemon([granted_for(user=os.getuid(), **endpoint)])
        self.addCleanup(daemon.close)
        client = mlcca.Client(daemon.path, patience=60)
        self.addCleanup(client.close)
        return client, daemon

    def is_readable(self, client):
        return bool(select.select([client], [], [], 0)[0])

    def test_a_receiver_that_is_gone_is_no_loss(self):
        """Any user can announce an address that no socket has."""
        with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as gone:
            gone.bind("")
            nobody = gone.getsockname()[1:].decode()
        client, daemon = self.start()
        stop, _ = self.subscriber(client, daemon)
        came = []
        stop.on_event = came.append
        local = daemon.requests[0].announce.local
        both = granted_for(local=local)
        both.channels.endpoints.add(local=nobody + local[5:], local_user=os.getuid())
        publishers = Daemon([both])
        self.addCleanup(publishers.close)
        with mlcca.Client(publishers.path, patience=60) as other:
            lever = other.publisher("stop")
            lever.announce()
            self.assertEqual([lever.publish(b"1"), lever.publish(b"2")], [Published.SENT] * 2)
        client.process()
        self.assertEqual([event.data for event in came], [b"1", b"2"])

    def test_a_silence_is_an_exception(self):
        client, daemon = self.start(silence_ns=SECOND // 100, period_ns=SECOND // 200, publisher="lever")
        stop, _ = self.subscriber(client, daemon)
        raised = []
        stop.on_exception = raised.append
        while not raised:
            client.wait(60)
        self.assertEqual((raised[0].cause, raised[0].publisher), (Cause.MISSING, "lever"))
        self.assertGreaterEqual(raised[0].silent_ns, SECOND // 100)
        self.assertGreaterEqual(raised[0].missing_events, 2)

    def test_what_is_too_long_or_too_much_is_counted(self):
        client, daemon = self.start(frame_bytes=8, event_cost_ns=3600 * SECOND)
        stop, lever = self.subscriber(client, daemon)
        raised, came = [], []
        stop.on_exception, stop.on_event = raised.append, lambda event: came.append(event.data)
        self.assertEqual([lever.publish(b"123456789"), lever.publish(b"go"), lever.publish(b"no")], [Published.SENT] * 3)
        while not raised:
            client.wait(60)
        self.assertEqual((raised[0].cause, raised[0].frames), (Cause.POLICED, 1))
        self.assertEqual((came, stop.lost), ([b"go"], 2))

    def test_what_is_missed_is_an_exception(self):
        client, daemon = self.start(publisher="lever")
        stop, lever = self.subscriber(client, daemon)
        raised, came = [], []
        stop.on_exception, stop.on_event = raised.append, lambda event: came.append(event.data)
        lost = [lever.publish(b"go") for _ in range(2000)].count(Published.LOST)
        while not raised:
            self.assertTrue(select.select([client, self.publisher], [], [], 60)[0])
            client.process()
            self.publisher.process()
        self.assertEqual((raised[0].cause, raised[0].publisher, raised[0].missing_events), (Cause.MISSED, "lever", lost))
        self.assertEqual((len(came) + lost, stop.lost), (2000, lost))

    def test_who_is_withdrawn_keeps_a_key_that_is_of_no_use(self):
        here = granted_for(user=os.getuid())
        here.channels.channels[0].to = getattr(here.channels.channels[0], "from")
        daemon = Daemon([here, event("withdrawn")], [channels(False)])
        self.addCleanup(daemon.close)
        with mlcca.Client(daemon.path, patience=60) as client:
            client.subscriber("stop").subscribe()
            while len(daemon.requests) < 3:
                client.wait(60)
        first, second, third = (request.announce.local for request in daemon.requests[:3])
        self.assertEqual(first, second)
        self.assertEqual(first[:5], third[:5])
        self.assertNotEqual(first, third)

    def test_an_event_costs_the_same_however_many_channels_there_are(self):
        daemon = Daemon([granted_for(user=os.getuid())], [channels(True)])
        self.addCleanup(daemon.close)
        client = mlcca.Client(daemon.path, patience=60)
        self.addCleanup(client.close)
        stop, lever = self.subscriber(client, daemon)
        came = []
        stop.on_event = came.append

        def steps():
            """The lines of Python that run until an event has been handled."""
            count = 0

            def trace(*_):
                nonlocal count
                count += 1
                return trace
            lever.publish(b"go")
            before = sys.gettrace()
            sys.settrace(trace)
            try:
                client.wait(60)
            finally:
                sys.settrace(before)
            return count

        steps()
        alone = steps()
        others = [client.publisher(f"other{number}") for number in range(200)]
        for other in others:
            other.announce()
        client.process()
        self.assertEqual(steps(), alone)
        self.assertEqual(len(came), 3)

    def test_whatever_holds_bytes_is_an_event(self):
        client, daemon = self.start()
        stop, lever = self.subscriber(client, daemon)
        came = []
        stop.on_event = lambda event: came.append(event.data)
        events = [bytearray(b"1"), memoryview(b"a2b")[1:2], memoryview(b"3-4-5")[::2], array.array("H", [0x3636])]
        self.assertEqual([lever.publish(event) for event in events], [Published.SENT] * 4)
        self.assertEqual(lever.publish(bytearray(65_536)), Published.TOO_LONG)
        client.process()
        self.assertEqual(came, [b"1", b"2", b"345", b"66"])

    def test_what_holds_no_bytes_is_no_event(self):
        for client in (mlcca.Client("/none"), mlcca.aio.Client("/none")):
            for wrong, why in (("go", r"encode\(\)"), (5, "int"), (None, "NoneType"), ([1], "list")):
                with self.assertRaisesRegex(TypeError, why):
                    client.publisher("stop").publish(wrong)

    def test_a_loop_is_woken_as_long_as_events_wait(self):
        client, daemon = self.start()
        stop, lever = self.subscriber(client, daemon)
        came = []

        def handler(event):
            came.append(event.data)
            raise ZeroDivisionError
        stop.on_event = handler
        for event in (b"1", b"2"):
            lever.publish(event)
        other = client.publisher("stop")
        other.announce()  # meanwhile what came is taken from the sockets
        for number in (1, 2):
            self.assertTrue(self.is_readable(client))
            self.assertRaises(ZeroDivisionError, client.process)
            self.assertEqual(len(came), number)
        client.process()
        self.assertFalse(self.is_readable(client))

    def test_what_is_no_request_is_rejected_by_itself(self):
        daemon = Daemon([channels(True)])
        self.addCleanup(daemon.close)
        with mlcca.Client(daemon.path, patience=60) as client:
            self.assertEqual(client.publisher("stop").announce().state, State.GRANTED)
            self.assertEqual(client.publisher("a" * MOST_REQUEST).announce().state, State.REJECTED)
            client.process()
            self.assertTrue(client.connected)
            self.assertEqual(len(daemon.requests), 1)
            self.assertEqual(client.publisher("stop").announce().state, State.GRANTED)


class Gone(unittest.TestCase):
    """Events between programs on the gateway pass no gate. When the gates close, the library ends them."""

    def program(self, *answers, **more):
        """A program that subscribes, and one that publishes to it."""
        self.daemon = Daemon(*answers)
        self.addCleanup(lambda: self.daemon and self.daemon.close())
        self.client = mlcca.Client(self.daemon.path, patience=60, **more)
        self.addCleanup(self.client.close)
        stop = self.client.subscriber("stop")
        self.came, self.raised = [], []
        stop.on_event = lambda event: self.came.append(event.data)
        stop.on_exception = lambda exception: self.raised.append(exception.cause)
        stop.subscribe()
        publishers = Daemon([granted_for(local=self.daemon.requests[0].announce.local)])
        self.addCleanup(publishers.close)
        publisher = mlcca.Client(publishers.path, patience=60)
        self.addCleanup(publisher.close)
        lever = publisher.publisher("stop")
        lever.announce()
        return stop, lever

    def granted(self, grace_ns):
        reply = granted_for(user=os.getuid())
        reply.channels.grace_ns = grace_ns
        return reply

    def wait_for(self, *causes):
        while self.raised[-1:] != [causes[-1]]:
            self.client.wait(60)
        self.assertEqual(self.raised, list(causes))

    def send(self, lever, text):
        self.assertEqual(lever.publish(text), Published.SENT)
        self.client.process()

    def test_a_daemon_that_is_lost_for_longer_than_its_grace(self):
        stop, lever = self.program([self.granted(SECOND // 10)])
        self.send(lever, b"1")
        self.daemon.close()
        self.daemon = None
        self.wait_for(Cause.DAEMON_GONE, Cause.GATES_CLOSED)
        self.send(lever, b"2")
        self.assertEqual((self.came, stop.lost, self.client.lost), ([b"1"], 1, 1))

    def test_within_the_grace_they_are_delivered(self):
        _, lever = self.program([self.granted(3600 * SECOND)])
        self.daemon.close()
        self.daemon = None
        self.wait_for(Cause.DAEMON_GONE)
        self.send(lever, b"1")
        self.assertEqual(self.came, [b"1"])

    def test_a_daemon_that_hangs_for_longer_than_its_grace(self):
        stop, lever = self.program([self.granted(SECOND // 10)], answers_within=0.05)
        self.daemon.runs.clear()
        self.wait_for(Cause.DAEMON_GONE, Cause.GATES_CLOSED)
        self.send(lever, b"1")
        self.assertEqual(self.came, [])
        self.daemon.runs.set()
        while self.raised[-1] is not Cause.DAEMON_BACK:
            self.client.wait(60)
        self.send(lever, b"2")
        self.assertEqual((self.came, stop.lost), ([b"2"], 1))

    def test_a_daemon_that_stops_ends_them_at_once(self):
        stop, lever = self.program([self.granted(3600 * SECOND), event("stopped", subject=0)])
        self.wait_for(Cause.GATES_CLOSED)
        self.send(lever, b"1")
        self.assertEqual((self.came, stop.lost), ([], 1))

    def test_what_a_daemon_answers_that_stops_opens_nothing(self):
        _, lever = self.program([self.granted(3600 * SECOND), event("stopped", subject=0), event("granted")],
                                [self.granted(3600 * SECOND), event("mode", subject=0)])
        self.wait_for(Cause.GATES_CLOSED, Cause.MODE)
        self.send(lever, b"1")
        self.assertEqual(self.came, [])

    def test_a_publisher_sends_nothing_either(self):
        stop, _ = self.program([self.granted(3600 * SECOND)])
        daemon = Daemon([granted_for(local=self.daemon.requests[0].announce.local), event("stopped", subject=0)])
        self.addCleanup(daemon.close)
        with mlcca.Client(daemon.path, patience=60) as client:
            lever = client.publisher("stop")
            told = []
            lever.on_exception = lambda exception: told.append(exception.cause)
            lever.announce()
            while told != [Cause.GATES_CLOSED]:
                client.wait(60)
            self.assertEqual(lever.publish(b"1"), Published.LOST)
        self.client.process()
        self.assertEqual((self.came, stop.lost), ([], 1))

    def test_in_asyncio(self):
        async def run():
            daemon = Daemon([self.granted(SECOND // 10)])
            async with mlcca.aio.Client(daemon.path, patience=60) as client:
                stop = client.subscriber("stop")
                await stop.subscribe()
                daemon.close()
                causes = []
                async for exception in stop.exceptions():
                    causes.append(exception.cause)
                    if len(causes) == 2:
                        return causes, client.lost
        self.assertEqual(asyncio.run(run()), ([Cause.DAEMON_GONE, Cause.GATES_CLOSED], 0))

    def test_the_losses_of_a_client_are_those_of_all_channels(self):
        stop, lever = self.program([self.granted(3600 * SECOND)])
        sent = [lever.publish(b"go") for _ in range(2000)].count(Published.SENT)
        self.client.process()
        lever._client.process()  # reports what was lost
        self.client.process()
        self.assertGreater(self.client.lost, 0)
        self.assertEqual((len(self.came), self.client.lost, stop.lost), (sent, 2000 - sent, 2000 - sent))
        stop.close()
        self.assertEqual(self.client.lost, 2000 - sent)
        self.client.close()
        self.assertEqual(self.client.lost, 2000 - sent)


class Loop(unittest.TestCase):
    """A loop of the user, which calls process() only if fileno() is readable."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.path = f"{folder.name}/control.sock"
        self.running = None

    def daemon(self, *answers):
        self.running = Daemon(*answers, path=self.path)

    def stop(self):
        self.running.close()
        self.running = None
        os.unlink(self.path)

    def tearDown(self):
        if self.running:
            self.running.close()

    def client(self, first_retry):
        client = mlcca.Client(self.path, patience=60, first_retry=first_retry)
        self.addCleanup(client.close)
        stop = client.publisher("stop")
        self.told = []
        stop.on_exception = lambda exception: self.told.append(exception.cause)
        stop.announce()
        return client

    def loop_until(self, client, cause):
        while cause not in self.told:
            self.assertTrue(select.select([client], [], [], 60)[0], f"fileno() is not readable, of {self.told}")
            client.process()

    def is_readable(self, client):
        return bool(select.select([client], [], [], 0)[0])

    def test_it_finds_a_daemon_that_comes_back(self):
        self.daemon([channels(True)])
        client = self.client(first_retry=0.01)
        self.stop()
        self.loop_until(client, Cause.DAEMON_GONE)
        self.daemon([channels(True)])
        self.loop_until(client, Cause.DAEMON_BACK)
        self.assertFalse(self.is_readable(client))

    def test_it_finds_a_daemon_that_starts_later(self):
        client = self.client(first_retry=0.01)
        self.daemon([channels(True)])
        self.loop_until(client, Cause.DAEMON_BACK)

    def test_it_asks_again_what_the_daemon_could_not_answer(self):
        busy = control_pb2.Reply(error=control_pb2.Error(kind=control_pb2.ERROR_WORLD, message="no memory"))
        self.daemon([busy], [channels(True)])
        self.loop_until(self.client(first_retry=0.01), Cause.DAEMON_BACK)

    def test_it_sleeps_until_it_is_time_to_connect(self):
        self.daemon([channels(True)])
        client = self.client(first_retry=3600)
        self.stop()
        self.loop_until(client, Cause.DAEMON_GONE)
        self.assertFalse(self.is_readable(client))

    def test_without_a_channel_nothing_wakes_it(self):
        client = mlcca.Client(self.path, first_retry=0.01)
        self.addCleanup(client.close)
        stop = client.publisher("stop")
        stop.announce()
        stop.close()
        client.process()
        self.assertFalse(select.select([client], [], [], 0.1)[0])


if __name__ == "__main__":
    unittest.main()
