# SPDX-License-Identifier: MIT
"""Installs the drop-in in child processes, then runs the sitecustomize that this one hides."""
import importlib.machinery
import importlib.util
import os
import sys

_here = os.path.dirname(os.path.abspath(__file__))
if importlib.util.find_spec("quadsplat") is None:
    sys.path.append(os.path.dirname(os.path.dirname(os.path.dirname(_here))))
try:
    import quadsplat.dropin

    quadsplat.dropin.install()
except ImportError as error:  # another Python, which may lack numpy
    print(f"quadsplat.dropin: it is not installed in this process: {error}", file=sys.stderr)

_others = [folder for folder in sys.path if os.path.abspath(folder or ".") != _here]
_next = importlib.machinery.PathFinder.find_spec("sitecustomize", _others)
if _next is not None and _next.loader is not None:
    _next.loader.exec_module(importlib.util.module_from_spec(_next))
