#!/usr/bin/env python3
"""What zsh makes of a command line when the tabulator is hit: in_zsh.py FOLDER LINE, with the completions in FOLDER. For help.sh."""

import os
import pty
import re
import select
import subprocess
import sys
import time

PATIENCE = 20  # s


def read_until(terminal, mark, text=""):
    ends = time.monotonic() + PATIENCE
    while not re.search(mark, text):
        if not select.select([terminal], [], [], max(0, ends - time.monotonic()))[0]:
            sys.exit(f"zsh says nothing more after: {text!r}")
        text += os.read(terminal, 4096).decode(errors="replace")
    return text


def main():
    folder, line = sys.argv[1:]
    terminal, other = pty.openpty()
    environment = {**os.environ, "TERM": "dumb", "ZDOTDIR": "/nonexistent"}
    zsh = subprocess.Popen(["zsh", "-f", "-i"], stdin=other, stdout=other, stderr=other, env=environment, start_new_session=True)
    os.write(terminal, f"PS1= RPS1=; fpath=('{folder}' $fpath); autoload -Uz compinit; compinit -u -D; print rea''dy\n".encode())
    read_until(terminal, "ready\r\n")
    os.write(terminal, f"{line}\t".encode())
    time.sleep(1)  # the answer to a tabulator has no end to wait for
    os.write(terminal, b"\x01print -r -- '<'\x05'>'\n")
    print(re.search(r"\r\n<(.*?) ?>\r\n", read_until(terminal, r"\r\n<.*>\r\n"))[1].strip())
    zsh.kill()
    zsh.wait()


if __name__ == "__main__":
    main()
