# SPDX-License-Identifier: MIT
"""Finds quadsplat's modules under the names of the modules that they replace."""
from __future__ import annotations

import importlib.abc
import importlib.machinery
import importlib.util
import os
import re
import sys
from pathlib import Path
from types import ModuleType
from typing import Any, Callable, Dict, Optional, Sequence, Tuple

from . import _options
from ._device import map_to_cpu

_FOLDER = Path(__file__).parent
_MODULES = _FOLDER / "modules"
_SITE = _FOLDER / "site"

#: Modules that are replaced as a whole: name, file.
REPLACED: Dict[str, str] = {
    "diff_gaussian_rasterization": "diff_gaussian_rasterization.py",
    "diff_gaussian_rasterization_abs": "diff_gaussian_rasterization_abs.py",
    "fused_ssim": "fused_ssim.py",
    "simple_knn": "simple_knn/__init__.py",
    "simple_knn._C": "simple_knn/_C.py",
}
#: Modules whose functions and methods are replaced after their import: name, functions.
PATCHED: Dict[str, Sequence[str]] = {
    "gsplat.rendering": ("rasterization",),
    "gsplat.relocation": ("compute_relocation",),
    "gsplat.cuda._wrapper": ("adam", "quat_scale_to_covar_preci"),
    "gsplat.strategy.default": ("DefaultStrategy._update_state",),
    "gsplat.strategy.ops": ("_cuda_fused_mcmc_perturb",),
}
#: Modules that are used if the first of them is not installed.
STAND_INS: Dict[str, str] = {
    "gsplat": "gsplat/__init__.py",
    "gsplat.rendering": "gsplat/rendering.py",
}
#: The module that compiles gsplat's extension, and the first version that does so on import.
_EXTENSION, _COMPILES_ON_IMPORT = "gsplat.cuda._backend", (1, 6)


class Finder(importlib.abc.MetaPathFinder):
    """The first finder of sys.meta_path."""

    def find_spec(self, fullname: str, path: Optional[Sequence[str]],
                  target: Optional[ModuleType] = None) -> Any:
        if fullname in REPLACED:
            return _spec(fullname, REPLACED[fullname])
        if fullname in PATCHED or fullname in STAND_INS:
            found = self._of_others(fullname, path, target)
            if found is None:
                return _spec(fullname, STAND_INS[fullname]) if fullname in STAND_INS else None
            if fullname in PATCHED and found.loader is not None:
                found.loader = _PatchingLoader(found.loader, _replace_functions)
            return found
        if fullname == _EXTENSION:
            found = self._of_others(fullname, path, target)
            if found is None or _version_beside(found) < _COMPILES_ON_IMPORT:
                return found
            return _spec(fullname, "gsplat/_backend.py")
        if fullname == "torch" and _options.device() is not None:
            found = self._of_others(fullname, path, target)
            if found is not None and found.loader is not None:
                found.loader = _PatchingLoader(found.loader, map_to_cpu)
            return found
        return None

    def _of_others(self, fullname: str, path: Optional[Sequence[str]],
                   target: Optional[ModuleType]) -> Any:
        for finder in sys.meta_path:
            if finder is not self and hasattr(finder, "find_spec"):
                spec = finder.find_spec(fullname, path, target)
                if spec is not None:
                    return spec
        return None


class _PatchingLoader(importlib.abc.Loader):
    """Loads a module and changes it then."""

    def __init__(self, loader: Any, patch: Callable[[ModuleType], None]) -> None:
        self._loader = loader
        self._patch = patch

    def create_module(self, spec: Any) -> Any:
        return self._loader.create_module(spec)

    def exec_module(self, module: ModuleType) -> None:
        self._loader.exec_module(module)
        self._patch(module)

    def __getattr__(self, name: str) -> Any:  # get_source() and others
        return getattr(self._loader, name)


def _version_beside(extension: Any) -> Tuple[int, ...]:
    """The version of the gsplat that has this module; (0,) if it does not say it."""
    try:
        text = (Path(extension.origin).parent.parent / "version.py").read_text(encoding="utf-8")
    except (OSError, TypeError):
        return (0,)
    numbers = re.search(r"""__version__ *= *["'](\d+)\.(\d+)""", text)
    return tuple(map(int, numbers.groups())) if numbers else (0,)


def _replace_functions(module: ModuleType) -> None:
    from . import _gsplat, _gsplat_strategy

    for name in PATCHED[module.__name__]:
        kind, _, method = name.rpartition(".")
        if kind:
            owner = getattr(module, kind)
            setattr(owner, method, getattr(_gsplat_strategy, method)(getattr(owner, method)))
        else:
            setattr(module, name, getattr(_gsplat, name))


def install(cull: Optional[str] = None, variant: Optional[str] = None,
            device: Optional[str] = None) -> None:
    """Replaces modules that are imported from now on, here and in child processes.

    cull: culling mode, of quadsplat.modes(); None: as the replaced module culls.
    variant: the member of the family of diff_gaussian_rasterization, of VARIANTS; None: it follows
        from the settings that a trainer passes.
    device: "cpu": tensors that a program puts on `cuda` are on the CPU; None: they are where the
        program puts them.

    Child processes of Python inherit it by PYTHONPATH; `python -I`, `-E` and `-S` ignore that.
    Raises UsageError.
    """
    _options.choose(cull, variant, device)
    if not any(isinstance(finder, Finder) for finder in sys.meta_path):
        sys.meta_path.insert(0, Finder())
    if _options.device() is not None and "torch" in sys.modules:
        map_to_cpu(sys.modules["torch"])
    inherited = os.environ.get("PYTHONPATH", "").split(os.pathsep)
    if str(_SITE) not in inherited:
        os.environ["PYTHONPATH"] = os.pathsep.join([str(_SITE), *filter(None, inherited)])


def _spec(fullname: str, file: str) -> Any:
    path = _MODULES / file
    folders = [str(path.parent)] if path.name == "__init__.py" else None
    return importlib.util.spec_from_file_location(fullname, str(path),
                                                  submodule_search_locations=folders)
