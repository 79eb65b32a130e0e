# SPDX-License-Identifier: MIT
"""python -m quadsplat.dropin: which modules it replaces, in the program and in its children."""
import os
import subprocess
import sys

import pytest

from conftest import ROOT

torch = pytest.importorskip("torch", reason="torch is not installed (python3-torch)")

SHOWS = """
import sys
import diff_gaussian_rasterization, diff_gaussian_rasterization_abs, fused_ssim, simple_knn._C
from simple_knn._C import distCUDA2
from diff_gaussian_rasterization import SparseGaussianAdam, compute_relocation, rasterize_gaussians
from diff_gaussian_rasterization_abs import GaussianRasterizer
print(*["quadsplat/dropin" in module.__file__ for module in (
    diff_gaussian_rasterization, diff_gaussian_rasterization_abs, fused_ssim, simple_knn._C)])
print(*sys.argv)
"""


def run(words, folder, code=0, **environment):
    done = subprocess.run(
        [sys.executable, "-B", "-m", "quadsplat.dropin", *map(str, words)], cwd=folder, text=True,
        capture_output=True, timeout=300,
        env={**os.environ, "PYTHONPATH": str(ROOT / "python"), **environment})
    assert done.returncode == code, done.stderr
    return done.stdout if code == 0 else done.stderr


def test_a_script_finds_quadsplat_even_beside_the_modules_folder(tmp_path):
    (tmp_path / "train.py").write_text(SHOWS)
    (tmp_path / "simple_knn.py").write_text("raise SystemExit('the wrong module')")
    (tmp_path / "helper.py").write_text("print('beside the script')")
    (tmp_path / "other").mkdir()
    (tmp_path / "train.py").write_text("import helper\n" + SHOWS)
    printed = run([tmp_path / "train.py", "-s", "data", "--cull", "of the script"], tmp_path / "other")
    assert printed.splitlines() == ["beside the script", "True True True True",
                                    f"{tmp_path / 'train.py'} -s data --cull of the script"]


def test_a_module_runs_too(tmp_path):
    (tmp_path / "tool").mkdir()
    (tmp_path / "tool" / "__init__.py").write_text("")
    (tmp_path / "tool" / "train.py").write_text(SHOWS)
    lines = run(["--variant", "mcmc", "-m", "tool.train", "a", "-m", "b"], tmp_path).splitlines()
    assert lines[0] == "True True True True" and lines[1].endswith("train.py a -m b")


def test_children_have_the_modules_the_options_and_their_own_sitecustomize(tmp_path):
    (tmp_path / "custom").mkdir()
    (tmp_path / "custom" / "sitecustomize.py").write_text("import sys; sys.customised = True\n")
    (tmp_path / "child.py").write_text(SHOWS + """
from quadsplat.dropin import _options
print(getattr(sys, "customised", False), _options.cull(), _options.variant())
""")
    (tmp_path / "train.py").write_text("""
import subprocess, sys
subprocess.run([sys.executable, "-B", "child.py"], check=True)
""")
    printed = run(["--cull", "quadbox", "--variant", "dr_aa", "train.py"], tmp_path, PYTHONPATH=os.pathsep.join(
        [str(ROOT / "python"), str(tmp_path / "custom")]))
    assert printed.splitlines() == ["True True True True", "child.py", "True quadbox dr_aa"]


def test_a_child_that_cannot_import_the_package_says_so_and_runs(tmp_path):
    (tmp_path / "train.py").write_text("""
import os, subprocess, sys
done = subprocess.run([sys.executable, "-B", "-c", "print('child')"], capture_output=True, text=True,
                      env={**os.environ, "QUADSPLAT_LIBRARY": "/none.so"})
print(done.stdout.strip(), done.stderr.splitlines())
""")
    line = run(["train.py"], tmp_path)
    assert line.startswith("child ['quadsplat.dropin: it is not installed in this process: quadsplat: the library "
                           "/none.so cannot be loaded") and line.count("', '") == 0


def test_a_child_in_another_folder_finds_the_package(tmp_path):
    (tmp_path / "quadsplat").symlink_to(ROOT / "python" / "quadsplat")
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "train.py").write_text("""
import subprocess, sys
subprocess.run([sys.executable, "-B", "-c", "import fused_ssim; print('dropin' in fused_ssim.__file__)"],
               cwd="elsewhere", check=True)
""")
    assert run(["train.py"], tmp_path, PYTHONPATH="").strip() == "True"


def test_children_of_multiprocessing_have_the_modules(tmp_path):
    (tmp_path / "train.py").write_text("""
import multiprocessing

def work(number):
    import fused_ssim
    return "quadsplat" in fused_ssim.__file__

if __name__ == "__main__":
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        print(pool.map(work, [1]))
""")
    assert run(["train.py"], tmp_path).strip() == "[True]"


CUDA = """
import io, subprocess, sys
import torch

made = [
    torch.zeros(2, 3, device="cuda") + torch.tensor([1.0, 2, 3]).cuda(),
    torch.ones(2, 3, device=torch.device("cuda:0")).to("cuda", torch.float64),
    torch.empty(2).to(device="cuda:0", dtype=torch.int32), torch.rand(2).to(0).cuda(0),
    torch.rand_like(torch.ones(3), device="cuda"), torch.ones(3).new_full((2,), 4.0, device="cuda"),
    torch.nn.Linear(3, 2, device="cuda").cuda().to(torch.device("cuda")).weight,
    torch.ones(3).to(torch.float64), torch.ones(3).to(torch.ones(1, dtype=torch.int32))]
file = io.BytesIO()
torch.save(made[0], file)
file.seek(0)
made.append(torch.load(file, map_location="cuda"))
assert torch.equal(made[0], made[-1]) and made[1].dtype == torch.float64 and made[2].dtype == torch.int32
assert made[7].dtype == torch.float64 and made[8].dtype == torch.int32 and made[5].tolist() == [4, 4]
torch.cuda.set_device(torch.device("cuda:0"))
start, end = torch.cuda.Event(enable_timing=True), torch.cuda.Event(enable_timing=True)
start.record()
sum(range(10000))
end.record()
torch.cuda.synchronize()
torch.cuda.empty_cache()
assert 0 < start.elapsed_time(end) < 1e5
print({str(tensor.device) for tensor in made}, torch.device("cuda"), *sys.argv[1:])
"""


def test_programs_for_cuda_run_on_the_cpu_if_asked_to(tmp_path):
    (tmp_path / "child.py").write_text(CUDA)
    (tmp_path / "train.py").write_text(CUDA + """
subprocess.run([sys.executable, "-B", "child.py", "child"], check=True)
""")
    assert run(["--device", "cpu", "train.py", "parent"], tmp_path).splitlines() == [
        "{'cpu'} cuda parent", "{'cpu'} cuda child"]
    if not torch.cuda.is_available():
        assert "cuda" in run(["train.py"], tmp_path, code=1).lower()
    (tmp_path / "late.py").write_text("import torch, quadsplat.dropin\n"
                                      "quadsplat.dropin.install(device='cpu')\n" + CUDA)
    done = subprocess.run([sys.executable, "-B", "late.py"], cwd=tmp_path, text=True, capture_output=True,
                          env={**os.environ, "PYTHONPATH": str(ROOT / "python")})
    assert done.stdout.strip() == "{'cpu'} cuda", done.stderr


def test_the_culling_mode_is_used(tmp_path):
    (tmp_path / "train.py").write_text("""
from quadsplat.dropin import _inria
import torch
lens = torch.tensor([[1.0, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 1], [0, 0, -0.01, 0]])
settings = _inria.GaussianRasterizationSettings(8, 8, 1, 1, torch.zeros(3), 1, torch.eye(4), lens, 0,
                                                torch.zeros(3))
print(_inria._plan(settings, "original", torch.zeros(1, 3), False)[0].rules.cull.decode())
""")
    assert run(["train.py"], tmp_path).strip() == "3dgs"
    assert run(["--cull", "exact", "train.py"], tmp_path).strip() == "exact"


@pytest.mark.parametrize("words, sentence", [
    ([], "the following arguments are required: program"),
    (["none.py"], "none.py does not exist"),
    (["--cull", "best", "train.py"], "dropin: cull: 'best' is none of 3dgs"),
    (["--cull", "reference", "train.py"], "dropin: cull: 'reference' is none of 3dgs"),
    (["--device", "cuda", "train.py"], "invalid choice: 'cuda'"),
    (["--variant", "best", "train.py"], "invalid choice: 'best'"),
    (["--variant", "taming", "train.py"], "dropin: variant: taming-3dgs's rasterizer returns 13 values")])
def test_wrong_words_are_refused_in_a_sentence(tmp_path, words, sentence):
    assert sentence in run(words, tmp_path, code=2)


def test_an_error_of_the_script_is_its_own(tmp_path):
    (tmp_path / "train.py").write_text("raise SystemExit('no data')")
    assert run(["train.py"], tmp_path, code=1).strip() == "no data"


# ---- gsplat

FAKE = {
    "__init__.py": """
from .version import __version__
from .cuda._wrapper import quat_scale_to_covar_preci
from .relocation import compute_relocation
from .rendering import rasterization
from .strategy import Strategy
""",
    "version.py": "__version__ = '{version}'\n",
    "rendering.py": "def rasterization(*a, **b): raise RuntimeError('compiles')\ndef other(): return 'own'\n",
    "relocation.py": "def compute_relocation(*a, **b): raise RuntimeError('compiles')\n",
    "strategy/__init__.py": "from gsplat import quat_scale_to_covar_preci\n"
                            "from gsplat.relocation import compute_relocation\nfrom . import ops\n"
                            "from .default import DefaultStrategy\nclass Strategy: pass\n",
    "strategy/default.py": "class DefaultStrategy:\n    def _update_state(self, *a, packed=False): return 'own'\n",
    "strategy/ops.py": "def _cuda_fused_mcmc_perturb(*a, **b): raise RuntimeError('compiles')\n",
    "cuda/__init__.py": "",
    "cuda/_wrapper.py": "def adam(*a): raise RuntimeError('compiles')\n"
                        "def quat_scale_to_covar_preci(*a): raise RuntimeError('compiles')\n",
}


def test_functions_of_an_installed_gsplat_are_replaced_and_the_rest_stays(tmp_path):
    for name, text in FAKE.items():
        path = tmp_path / "gsplat" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text.replace("{version}", "1.4.0"))
    (tmp_path / "train.py").write_text("""
import torch, gsplat, gsplat.rendering, gsplat.strategy, gsplat.cuda._wrapper
from quadsplat.dropin import _gsplat
print(gsplat.rasterization is gsplat.rendering.rasterization is _gsplat.rasterization)
print(gsplat.strategy.compute_relocation is gsplat.compute_relocation is _gsplat.compute_relocation)
print(gsplat.strategy.quat_scale_to_covar_preci is _gsplat.quat_scale_to_covar_preci)
print(gsplat.cuda._wrapper.adam is _gsplat.adam, gsplat.rendering.other(), gsplat.Strategy().__class__.__name__)
print(gsplat.strategy.ops._cuda_fused_mcmc_perturb(*4 * [torch.zeros(2, 3)], scaler=2))
print(_gsplat._version().radius_rule)
update = gsplat.strategy.DefaultStrategy._update_state
print(update.__module__, update.__wrapped__(None), update.__code__.co_filename.endswith("_gsplat_strategy.py"))
import inspect
print(inspect.getsource(gsplat.rendering.other).strip())
""")
    assert run(["train.py"], tmp_path).splitlines() == [
        "True", "True", "True", "True own Strategy", "False", "gsplat_1_4", "gsplat.strategy.default own True", "def other(): return 'own'"]


@pytest.mark.parametrize("version, built, printed", [
    ("1.6.0", False, ["None"]), ("1.6.0", True, ["built"]), ("1.10.2", False, ["None"]), ("1.5.3", False, ["compiles"])])
def test_the_extension_is_not_compiled_by_an_import(tmp_path, version, built, printed):
    """gsplat compiles it on import from 1.6 on, and at the first call of its functions before."""
    files = {**FAKE, "cuda/_backend.py": "raise RuntimeError('compiles')\n"}
    if version.startswith("1.6"):
        files["cuda/_wrapper.py"] = "from ._backend import _C\n" + FAKE["cuda/_wrapper.py"]
    if built:
        files["csrc.py"] = "name = 'built'\n"
    for name, text in files.items():
        path = tmp_path / "gsplat" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text.replace("{version}", version))
    (tmp_path / "train.py").write_text("""
import gsplat
try:
    from gsplat.cuda._backend import _C
    print(getattr(_C, "name", None))
except RuntimeError as error:
    print(error)
""")
    assert run(["train.py"], tmp_path).splitlines() == printed


def test_without_gsplat_a_module_stands_in(tmp_path):
    (tmp_path / "train.py").write_text("""
import gsplat
from gsplat.rendering import rasterization
print(gsplat.rasterization is rasterization, gsplat.__version__)
try:
    import gsplat.strategy
except ImportError as error:
    print(error)
""")
    assert run(["train.py"], tmp_path).splitlines() == ["True 1.5.3", "No module named 'gsplat.strategy'"]


def test_small_sets_of_points_and_ssim_without_training(tmp_path):
    (tmp_path / "train.py").write_text("""
import torch
from fused_ssim import fused_ssim
from simple_knn._C import distCUDA2
print([distCUDA2(torch.eye(3)[:count] * 2).tolist() for count in range(4)])
a, b = (torch.rand(1, 3, 12, 12, requires_grad=True) for _ in range(2))
fused_ssim(a, b, train=False).backward()
print(bool(a.grad.abs().max() > 0 and b.grad.abs().max() > 0))
""")
    assert run(["train.py"], tmp_path).splitlines() == ["[[], [0.0], [8.0, 8.0], [8.0, 8.0, 8.0]]", "True"]
