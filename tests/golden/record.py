"""Writes the golden files anew: ``python -m tests.golden.record``.

Golden files say what must stay the same: of every kind of job the stored request and its digest, of small jobs the
store, the summary, pictures, tables and measures, what requests are refused with, the structure of
``docs/openapi.yaml``, and the options of every command. The tests beside this file compare them with the code.

A golden file is written anew only where a change of what it says is meant. Read the diff before you commit it: every
line of it is something that a user, a reader of old stores or a client will notice. A changed digest means that old
results are no longer found.

    requests.json       bodies; what the service stores of each, and its digest
    refusals.json       bodies; status, type and locations of the problem that refuses each
    trajectories.json   bodies; the time history that answers each
    jobs.json           bodies of small jobs
    stores/NAME.json    each of these jobs: its view, its result, its store, and what is shown of it
    commands.json       what each command takes
    help/*.txt          its help, to read; of it only the usage is compared
    openapi.json        docs/openapi.yaml without words

A new case is a new body: add its name, route and body to one of the first four files and run the script.

Names of what is to be written may be given: ``python -m tests.golden.record requests commands``.
"""

import os
import sys
import tempfile

# As wide in every terminal; asked once, when the first command is imported.
os.environ["COLUMNS"] = "200"

from tests.golden import adapter, api_document, commands, door, files, help_texts, jobs  # noqa: E402


def record_requests():
    """What the service stores of each body."""
    with tempfile.TemporaryDirectory() as data, adapter.idle(data) as service:
        files.write("requests.json", [door.stored_request(service, data, case) for case in files.read("requests.json")])


def record_refusals():
    """What the service refuses."""
    with tempfile.TemporaryDirectory() as data, adapter.idle(data) as service:
        files.write("refusals.json", [door.refusal(service, case) for case in files.read("refusals.json")])


def record_trajectories():
    """What the service answers at once."""
    with tempfile.TemporaryDirectory() as data, adapter.idle(data) as service:
        cases = files.read("trajectories.json")
        files.write("trajectories.json", [door.trajectory(service, case) for case in cases])


def record_stores():
    """What the service computes."""
    files.write("jobs.json", files.read("jobs.json"))
    with tempfile.TemporaryDirectory() as data, adapter.running(data) as service:
        for name, job in jobs.computed(service, files.read("jobs.json")).items():
            files.write(f"stores/{name}.json", jobs.looked_at(service, job))


def record_commands():
    """What the command line takes, and says of itself."""
    found = commands.commands()
    files.write("commands.json", {words: commands.parameters(command) for words, command in found.items()})
    for words in found:
        (files.FOLDER / help_texts.file_of(words)).write_text(help_texts.text_of(words))


def record_openapi():
    """Structure of the API's document."""
    files.write("openapi.json", api_document.structure())


RECORDS = {
    "requests": record_requests,
    "refusals": record_refusals,
    "trajectories": record_trajectories,
    "stores": record_stores,
    "commands": record_commands,
    "openapi": record_openapi,
}

if __name__ == "__main__":
    for name in sys.argv[1:] or RECORDS:
        RECORDS[name]()
