# SPDX-License-Identifier: MIT
"""The paper's tables as a workflow: `plan` says what must run, `work` runs one step, `report` writes the tables.

Standard library only. run.py is started by `quadsplat paper`, step.py by the rules of the Snakefile.
"""
