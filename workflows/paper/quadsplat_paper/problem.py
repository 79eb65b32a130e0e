# SPDX-License-Identifier: MIT
"""Errors that the user can cause, and the exit codes of quadsplat."""

EXIT_OK, EXIT_USAGE, EXIT_INPUT, EXIT_DEVICE, EXIT_INTERRUPTED = 0, 1, 2, 3, 130


class Problem(Exception):
    """One sentence that says who, where and what, and the exit code."""

    def __init__(self, sentence: str, code: int = EXIT_INPUT):
        super().__init__(sentence)
        self.code = code
