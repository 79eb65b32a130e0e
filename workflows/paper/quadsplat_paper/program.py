# SPDX-License-Identifier: MIT
"""Asks the program what it can do, so that no list of its options or strategies is kept here."""
import functools
import re
import subprocess

from .problem import EXIT_DEVICE, Problem


class Program:
    def __init__(self, path: str):
        self.path = path

    @functools.lru_cache(maxsize=None)
    def _says(self, *words: str) -> str:
        try:
            return subprocess.run([self.path, *words], capture_output=True, text=True, check=True).stdout
        except (OSError, subprocess.CalledProcessError) as error:
            raise Problem(f"paper: {self.path} does not start: {error}", EXIT_DEVICE) from error

    def offers(self, command: str, option: str) -> bool:
        return re.search(rf"^  (-\w, )?{re.escape(option)}(\s|$)", self._says(command, "--help"), re.M) is not None

    def strategies(self) -> list[str]:
        """The names that `train --strategy` takes."""
        found = re.search(r"^  --strategy (\S+)", self._says("train", "--help"), re.M)
        return found.group(1).split("|") if found else []

    def commit(self) -> str:
        found = re.search(r"commit ([^,)]+)", self._says("--version"))
        return found.group(1) if found else "unknown"

    def gpus(self) -> int:
        """The number of GPUs that the program can use."""
        lines = self._says("--list-gpus").splitlines()
        return 0 if any(line.startswith("no GPU") for line in lines) else sum(bool(re.match(r"\d+: ", line)) for line in lines)
