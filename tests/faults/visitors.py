"""Requests at their moments, however long the others take: the second process of the load test.

    python -m tests.faults.visitors PORT JOB RATE SECONDS PREVIEWS

RATE and PREVIEWS are requests a second; a preview is what a page asks for while a slider moves.

Prints JSON: the pace, and of each kind of request how often each status came and how long answers took, counted from
the moment at which a request was due, not from when it could be sent. It speaks HTTP/1.1 by itself: a client library
costs as much as the service that it asks.
"""

import asyncio
import collections
import json
import random
import sys
import time

import httptools
import uvloop

# Of a hundred requests.
MIX = {"status": 60, "list": 10, "result": 5, "ready": 5, "same again": 15, "submission": 5}
_CONNECTIONS = 64


def small(number):
    """A request like no other."""
    grid = {"time": {"cells": 8}, "velocity": {"cells": 8, "stop": 5.0 + number * 1e-3}}
    return {"grid": grid, "iterations": 101}


def glance(number):
    """What a page asks for at the next step of a slider."""
    return {"oscillator": {"damping": 0.55 + number % 1000 * 1e-4}, "quick": True}


class Connection(asyncio.Protocol):
    """One request at a time; its answer is the status and, where a job was submitted, its id."""

    def connection_made(self, transport):
        self.transport, self.answer = transport, None
        self.parser = httptools.HttpResponseParser(self)

    def ask(self, request):
        self.answer, self.job, self.later = asyncio.get_running_loop().create_future(), None, False
        self.transport.write(request)
        return self.answer

    def data_received(self, data):
        self.parser.feed_data(data)

    def on_header(self, name, value):
        if name.lower() == b"location":
            self.job = value.decode().rpartition("/")[2]
        self.later |= name.lower() == b"retry-after"

    def on_message_complete(self):
        status = self.parser.get_status_code()
        assert (status == 429) == self.later, "who asks too much is told when to come back"
        self.answer.set_result((status, self.job))
        self.parser = httptools.HttpResponseParser(self)

    def connection_lost(self, error):
        if self.answer is not None and not self.answer.done():
            self.answer.set_exception(error or ConnectionError("closed in the middle of an answer"))


class Visitors:
    """All who ask."""

    def __init__(self, port, job, rate):
        self.port, self.job, self.rate = port, job, rate
        self.known, self.glances = [job], 0
        self.answers = collections.defaultdict(list)
        self.chance = random.Random(7)

    def _request(self, what):
        method, path, body = "GET", f"/v1/jobs/{self.chance.choice(self.known)}", ""
        if what == "list":
            path = "/v1/jobs?size=20"
        elif what == "result":
            path = f"/v1/jobs/{self.job}/result"
        elif what == "ready":
            path = "/readyz"
        elif what == "preview":
            self.glances += 1
            method, path, body = "POST", "/v1/previews", json.dumps(glance(self.glances))
        elif what != "status":
            again = self.chance.randrange(20) if what == "same again" else self.chance.randrange(10**6)
            method, path, body = "POST", "/v1/basins", json.dumps(small(again))
        head = f"{method} {path} HTTP/1.1\r\nhost: 127.0.0.1:{self.port}\r\n"
        if body:
            head += f"content-type: application/json\r\ncontent-length: {len(body)}\r\n"
        return f"{head}\r\n{body}".encode()

    async def _ask(self, what, due):
        connection = await self.idle.get()
        status, job = await connection.ask(self._request(what))
        self.answers[what].append((status, time.perf_counter() - due))
        self.idle.put_nowait(connection)
        if status == 202:
            self.known.append(job)

    async def _begin(self, group, kinds, rate):
        begin = time.perf_counter()
        for number, what in enumerate(kinds):
            due = begin + number / rate
            await asyncio.sleep(max(0.0, due - time.perf_counter()))
            group.create_task(self._ask(what, due))

    async def visit(self, seconds, previews):
        """Ask for so long; the pace that was kept, in requests a second."""
        loop, self.idle = asyncio.get_running_loop(), asyncio.Queue()
        for _ in range(_CONNECTIONS):
            self.idle.put_nowait((await loop.create_connection(Connection, "127.0.0.1", self.port))[1])
        kinds = self.chance.choices(list(MIX), list(MIX.values()), k=self.rate * seconds)
        begin = time.perf_counter()
        async with asyncio.TaskGroup() as group:
            group.create_task(self._begin(group, kinds, self.rate))
            group.create_task(self._begin(group, previews * seconds * ["preview"], previews))
        return len(kinds) / (time.perf_counter() - begin)


def percentile(seconds, share):
    """What that share of them do not exceed."""
    return sorted(seconds)[min(len(seconds) - 1, int(share * len(seconds)))]


def main():
    """Visit, and say how it was."""
    port, job, rate, seconds, previews = sys.argv[1:]
    visitors = Visitors(int(port), job, int(rate))
    pace = uvloop.run(visitors.visit(int(seconds), int(previews)))
    kinds = {
        what: {
            "answers": collections.Counter(status for status, _ in answers),
            "milliseconds": {
                name: round(1e3 * percentile([spent for _, spent in answers], share), 1)
                for name, share in (("50 %", 0.5), ("99 %", 0.99), ("most", 1.0))
            },
        }
        for what, answers in sorted(visitors.answers.items())
    }
    spent = time.process_time() / sum(len(answers) for answers in visitors.answers.values())
    print(json.dumps({"requests a second": round(pace, 1), "own milliseconds": round(1e3 * spent, 2), "kinds": kinds}))


if __name__ == "__main__":
    main()
