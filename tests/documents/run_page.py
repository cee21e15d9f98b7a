"""Run the blocks of a page in order, as a reader does in one session, by an environment that has the wheel alone.

Blocks come on standard input as JSON: file, line, language and text. Python's blocks share their names. What a block
prints follows a line that names the block.
"""

import json
import subprocess
import sys

HEAD = "==== "


def main():
    names = {"__name__": "__main__"}
    for block in json.load(sys.stdin):
        place = f"{block['file']}:{block['line']}"
        print(HEAD + place, flush=True)
        if block["language"] == "python":
            # The lines before it keep the numbers of a traceback those of the page.
            text = "\n" * block["line"] + block["text"]
            exec(compile(text, block["file"], "exec"), names)
        elif subprocess.run(["bash", "-e", "-o", "pipefail", "-c", block["text"]]).returncode:
            sys.exit(f"{place}: the command failed")
        sys.stdout.flush()


if __name__ == "__main__":
    main()
