"""Three hundred requests a second, reads and submissions, for a minute, while tiles compute on both cores."""

import asyncio
import collections
import json
import os
import random
import time

import httpx2 as httpx

RATE, SECONDS = 300, int(os.environ.get("RATTLE_LOAD_SECONDS", "60"))
LONG = {"grid": {"time": {"cells": 3000}, "velocity": {"cells": 3000}}, "iterations": 10007}
# Of a hundred requests.
MIX = {"status": 60, "list": 10, "result": 5, "ready": 5, "same again": 15, "submission": 5}


def small(number):
    """A request like no other."""
    return {
        "grid": {"time": {"cells": 8}, "velocity": {"cells": 8, "stop": 5.0 + number * 1e-3}}, "iterations": 101,
    }  # fmt: skip


class Visitors:
    """Requests at their moments, however long the others take."""

    def __init__(self, url, job):
        self.url, self.job = url, job
        self.known = [job["id"]]
        self.answers = collections.defaultdict(list)
        self.chance = random.Random(7)

    async def _ask(self, client, what):
        method, path, body = "GET", f"/v1/jobs/{self.chance.choice(self.known)}", None
        if what == "list":
            path = "/v1/jobs?size=20"
        elif what == "result":
            path = f"/v1/jobs/{self.job['id']}/result"
        elif what == "ready":
            path = "/readyz"
        elif what != "status":
            again = self.chance.randrange(20) if what == "same again" else self.chance.randrange(10**6)
            method, path, body = "POST", "/v1/basins", small(again)
        begin = time.perf_counter()
        answer = await client.request(method, self.url + path, json=body)
        self.answers[what].append((answer.status_code, time.perf_counter() - begin))
        if answer.status_code == 202:
            self.known.append(answer.json()["id"])

    async def visit(self):
        kinds = self.chance.choices(list(MIX), list(MIX.values()), k=RATE * SECONDS)
        limits = httpx.Limits(max_connections=200, max_keepalive_connections=200)
        async with httpx.AsyncClient(timeout=30.0, limits=limits) as client, asyncio.TaskGroup() as group:
            begin = time.perf_counter()
            for number, what in enumerate(kinds):
                await asyncio.sleep(max(0.0, begin + number / RATE - time.perf_counter()))
                group.create_task(self._ask(client, what))
        return RATE * SECONDS / (time.perf_counter() - begin)


def percentile(seconds, share):
    return sorted(seconds)[min(len(seconds) - 1, int(share * len(seconds)))]


def test_reads_stay_fast_and_nothing_fails_under_load(a_service):
    with a_service() as service:
        job = service.submit(LONG)
        before = service.wait(job["id"], lambda job: job["progress"] and job["progress"]["tiles_done"] >= 2)
        visitors = Visitors(service.url, job)
        rate = asyncio.run(visitors.visit())
        after = service.request("GET", f"/v1/jobs/{job['id']}").json()
        report = {"requests a second": round(rate, 1)} | {
            what: {
                "answers": dict(collections.Counter(status for status, _ in answers)),
                "ms (50 %, 99 %, most)": [
                    round(1e3 * percentile([s for _, s in answers], share), 1) for share in (0.5, 0.99, 1.0)
                ],
            }
            for what, answers in sorted(visitors.answers.items())
        }
        print(json.dumps(report, indent=1))
        statuses = {status for answers in visitors.answers.values() for status, _ in answers}
        assert max(statuses) < 500
        assert rate > 0.95 * RATE
        assert after["progress"]["tiles_done"] > before["progress"]["tiles_done"]
        assert percentile([seconds for _, seconds in visitors.answers["status"]], 0.99) < 0.150
        service.request("POST", job["links"]["cancel"])
