# SPDX-License-Identifier: MIT
"""The workflow of `quadsplat paper`: its rules without a program, and whole runs on two tiny data sets on the CPU.

  QUADSPLAT=PROGRAM python3 paper_test.py [CLASS...]
Prints "skipped: REASON" if Snakemake or Slurm is missing.
"""
import csv
import json
import math
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest
from unittest import mock

sys.dont_write_bytecode = True
ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "workflows/paper"))
from quadsplat_paper import charts, gpus, matrix, pictures, ratios, report, results, sets, work  # noqa: E402
from quadsplat_paper.plan import Plan  # noqa: E402
from quadsplat_paper.problem import Problem  # noqa: E402

PROGRAM = os.environ.get("QUADSPLAT", str(ROOT / "build/optimised/quadsplat"))
TINY = ["--iterations", "20", "--train-options", "--random-points 300", "--backend", "cpu", "--frames", "1", "--warmup", "0",
        "--rounds", "2", "--yes"]


class FakeProgram:
    """Offers all options and strategies that the published rows need."""

    def __init__(self, strategies=("adc", "mcmc", "dash", "mask"), options=True):
        self._strategies, self._options = strategies, options

    def strategies(self):
        return [*self._strategies]

    def offers(self, command, option):
        return self._options


def published_scenes():
    return [sets.Scene(name, data_set.name, "/data", images, 1000, 500, 40, 10000, 1)
            for data_set in sets.SETS for name, images in data_set.scenes.items()]


def plan_of(names, program=FakeProgram(), seeds=1):
    models, rows = matrix.choose(program, names, None)
    return Plan("quadsplat", published_scenes(), [], models, rows, seeds, 30000, [], "cuda", "classic",
                ["--frames", "1", "--warmup", "0"], 1, False, "", [])


class Rules(unittest.TestCase):
    def test_the_matrix_has_87_trainings_per_seed_and_100_with_published_rules(self):
        self.assertEqual(len([*plan_of([]).units()]), 87)
        self.assertEqual(len([*plan_of(["published"]).units()]), 100)
        self.assertEqual(len([*plan_of([], seeds=3).units()]), 261)

    def test_rows_that_the_program_cannot_train_say_so_and_train_nothing(self):
        plan = plan_of([], FakeProgram(("adc",), options=False))
        self.assertEqual(len([*plan.units()]), 35)  # 3dgs 13, quadbox 13, dualbox 9
        why = {row.name: row.why for row in plan.rows}
        self.assertEqual(why["mask"], "not available in this program: train has no strategy 'mask'")
        self.assertEqual(why["quadbox"], "")
        self.assertEqual(plan.rows[0].notes, ["trained without '--count-views mode', which this program does not have"])

    def test_the_rows_of_compact_3dgs_train_a_colour_field(self):
        options = {model.name: model.options for model in plan_of([]).models}
        self.assertEqual([name for name in options if "--color-field" in options[name]], ["mask", "mask-quadbox"])
        older = plan_of(["mask"], FakeProgram(options=False))
        self.assertNotIn("--color-field", older.models[0].options)
        self.assertEqual(older.rows[0].notes, ["trained without '--color-field', which this program does not have"])

    def test_an_exception_leaves_the_visible_gpus_as_they_were(self):
        for before in (None, "3"):
            with mock.patch.dict(os.environ):
                os.environ.pop("CUDA_VISIBLE_DEVICES", None)
                if before is not None:
                    os.environ["CUDA_VISIBLE_DEVICES"] = before
                with self.assertRaises(KeyError), work.chosen_gpu({"CUDA_VISIBLE_DEVICES": "1"}):
                    self.assertEqual(os.environ["CUDA_VISIBLE_DEVICES"], "1")
                    raise KeyError
                self.assertEqual(os.environ.get("CUDA_VISIBLE_DEVICES"), before)

    def test_rows_are_chosen_by_name(self):
        self.assertEqual([model.name for model in plan_of(["adr", "quadbox"]).models], ["quadbox"])
        with self.assertRaisesRegex(Problem, "'nonsense' is none of 3dgs, adr"):
            plan_of(["nonsense"])

    def test_shards_share_all_measurements(self):
        plan = plan_of([])
        parts = [plan.targets(i, 3) for i in (1, 2, 3)]
        self.assertEqual(sorted(sum(parts, [])), sorted(plan.targets()))
        self.assertEqual(len(plan.targets()), 2 * 87 + 1)

    def test_a_plan_is_read_as_it_was_written(self):
        with tempfile.TemporaryDirectory() as name:
            folder, plan = pathlib.Path(name), plan_of([])
            plan.write(folder)
            first = (folder / "plan.json").stat().st_mtime_ns
            self.assertEqual(Plan.read(folder).json(), plan.json())
            plan.write(folder)
            self.assertEqual((folder / "plan.json").stat().st_mtime_ns, first)

    def test_scenes_are_found_where_people_unpack_them(self):
        with tempfile.TemporaryDirectory() as name:
            root = pathlib.Path(name)
            for folder, images in (("360_v2/garden", "images_4"), ("tandt_db/tandt/train", "images"), ("mine/shed", "images"),
                                   ("bonsai", "images")):
                (root / folder / "sparse/0").mkdir(parents=True)
                (root / folder / images).mkdir()
                (root / folder / images / "a.ppm").write_bytes(b"P6 20 10 255\n" + bytes(600))
            (root / "mine/shed/sparse/0/points3D.bin").write_bytes((7).to_bytes(8, "little"))
            scenes, missing = sets.find_scenes(root, None)
        self.assertEqual([(scene.name, scene.set) for scene in scenes],
                         [("garden", "Mip-NeRF 360"), ("train", "Tanks and Temples"), ("shed", "Own scenes")])
        self.assertEqual((scenes[2].points, scenes[2].width, scenes[2].height), (7, 20, 10))
        reasons = {name: reason for _, name, reason in missing}
        self.assertEqual(len(missing), 11)
        self.assertIn("has no photographs in images_2", reasons["bonsai"])

    def test_methods_of_users_are_rows(self):
        with tempfile.TemporaryDirectory() as name:
            file = pathlib.Path(name, "methods.json")
            file.write_text(json.dumps([{"name": "mine", "command": ["./mine", "{data}", "{out}"]},
                                        {"name": "few", "options": ["--max-gaussians", "1000"]},
                                        {"name": "lib", "plugin": "lib.so"}]))
            models, rows = matrix.choose(FakeProgram(), ["quadbox", "mine", "few", "lib"], file)
            self.assertEqual([model.name for model in models], ["quadbox", "mine", "few"])
            self.assertTrue(models[0].plugin.endswith("/lib.so"))
            self.assertEqual(rows[-1].mode, "lib")
            for bad, sentence in (('{}', "is no list"), ('[{"name": "a b"}]', "needs a \"name\""),
                                  ('[{"name": "a"}]', "needs exactly one of"), ('[{"name": "a", "colour": 1}]', "'colour' is none of"),
                                  ('[{"name": "quadbox", "options": ["x"]}]', "two rows named quadbox"), ('[', "cannot be read")):
                file.write_text(bad)
                with self.assertRaisesRegex(Problem, sentence):
                    matrix.choose(FakeProgram(), [], file)

    def test_ratios_have_students_interval(self):
        rows = [{"mode": mode, "view": view, "ms_median": ms, "round_ms": [ms]}
                for view, pair in enumerate(((4.0, 2.0), (6.0, 2.0), (8.0, 4.0))) for mode, ms in zip(("3dgs", "quadbox"), pair)]
        sample = ratios.paired(rows, "quadbox", "3dgs")
        ratio = ratios.mean_of([sample])
        mean = (2 * math.log(2) + math.log(3)) / 3
        half = 4.303 * math.sqrt(sum((math.log(r) - mean) ** 2 for r in (2, 3, 2)) / 2 / 3)
        self.assertAlmostEqual(ratio.value, math.exp(mean))
        self.assertAlmostEqual(ratio.high, math.exp(mean + half))
        self.assertIsNone(ratios.mean_of([ratios.sample_of([0.5])]).low)

    def test_fps_of_the_paper_averages_times(self):
        speed = results.speed_of([{"ms_mean": 1, "ms_median": 1, "pairs": 5}, {"ms_mean": 3, "ms_median": 3, "pairs": 6}])
        self.assertEqual((speed["fps_paper"], speed["pairs"]), (500, 11))
        self.assertEqual(results.speed_of([{"ms_mean": 1, "ms_median": 1, "pairs": 5}], 700)["fps_paper"], 700)

    def test_a_lock_lasts_as_long_as_a_child_works(self):
        with tempfile.TemporaryDirectory() as name:
            path = pathlib.Path(name, "lock")
            lock = gpus.try_lock(path)
            child = subprocess.Popen(["sleep", "60"], pass_fds=[lock])
            os.close(lock)
            self.assertIsNone(gpus.try_lock(path))
            child.kill()
            child.wait()
            self.assertIsNotNone(gpus.try_lock(path))

    def test_two_jobs_never_share_a_gpu(self):
        numbers = [f"test{os.getpid()}{letter}" for letter in "ab"]
        try:
            with gpus.one_gpu(numbers) as (first, _), gpus.one_gpu(numbers) as (second, _):
                self.assertEqual([first["CUDA_VISIBLE_DEVICES"], second["CUDA_VISIBLE_DEVICES"]], numbers)
                self.assertIsNone(gpus.try_lock(gpus.gpu_lock(numbers[0])))
            with gpus.one_gpu([]) as (none, locks):
                self.assertEqual((none, locks), ({}, []))
        finally:
            for number in numbers:
                gpus.gpu_lock(number).unlink(missing_ok=True)

    def test_crops_stay_inside_the_picture(self):
        with tempfile.TemporaryDirectory() as name:
            source, target = pathlib.Path(name, "a.ppm"), pathlib.Path(name, "a.png")
            source.write_bytes(b"P6\n4 3\n255\n" + bytes(range(36)))
            pictures.crop_ppm(source, target, (3, 2, 2, 2))
            self.assertEqual(pictures.size_of(target), (2, 2))
            self.assertEqual(pictures.size_of(source), (4, 3))

    def test_a_page_takes_the_tables_between_its_marks(self):
        with tempfile.TemporaryDirectory() as name:
            folder, page = pathlib.Path(name), pathlib.Path(name, "page.md")
            words = [sys.executable, "-B", str(ROOT / "workflows/paper/page.py"), str(folder), str(page)]
            self.assertEqual(subprocess.run(words, capture_output=True).returncode, 1)
            (folder / "report.md").write_text("# T\n\ntext\n\n## A\n\n1\n\n## Plots and pictures\n\n![p](plots/p.svg)\n\n"
                                              "### A part of x\n\n![q](x/q.png)\n\n## B\n\n2\n")
            (folder / "plots").mkdir()
            (folder / "plots/p.svg").write_text("<svg/>")
            page.write_text("before\n<!-- tables -->\nold\n<!-- end of tables -->\nafter\n")
            self.assertEqual(subprocess.run(words).returncode, 0)
            self.assertEqual(page.read_text(), "before\n<!-- tables -->\n\ntext\n\n### A\n\n1\n\n### Plots\n\n![p](page/p.svg)\n\n### B\n\n2\n\n"
                             "<!-- end of tables -->\nafter\n")
            self.assertEqual((folder / "page/p.svg").read_text(), "<svg/>")

    def test_charts_of_nothing_are_drawn(self):
        self.assertIn("</svg>", charts.bars("t", [], {}))
        self.assertIn("</svg>", charts.curves("t", "x", {}))
        self.assertIn("a &lt; b", charts.bars("a < b", ["g"], {"s": [(1, 0.5, 2)], "none": [None]}))

    def test_a_gpu_is_known_by_the_name_of_its_backend(self):
        for backend, on_gpu in (("cuda, NVIDIA H200", True), ("cpu", False), (None, False)):
            tables = report.Tables.__new__(report.Tables)
            tables.rows = [{"backend": backend}]
            self.assertEqual(tables.on_gpu, on_gpu, backend)


class Runs(unittest.TestCase):
    """Whole runs. The first one makes the data."""

    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="quadsplat_workflow_"))
        cls.addClassCleanup(shutil.rmtree, cls.folder, ignore_errors=True)
        cls.data = cls.folder / "data"
        for name, elevation in (("doll", "60"), ("flat", "20")):
            subprocess.run([sys.executable, ROOT / "scripts/synthetic_set", ROOT / "assets/plush.ply", cls.data / name, "--views", "9",
                            "--size", "48x36", "--elevation", elevation], check=True, capture_output=True,
                           env={**os.environ, "PROGRAM": PROGRAM})

    def words(self, out, *more):
        return [PROGRAM, "paper", str(self.data), "--out-dir", str(self.folder / out), *TINY, *more]

    def paper(self, out, *more):
        return subprocess.run(self.words(out, *more), capture_output=True, text=True, stdin=subprocess.DEVNULL)

    def rows(self, out):
        """rows.csv without the columns that differ between runs."""
        with open(self.folder / out / "rows.csv", newline="") as file:
            dropped = results.TIMES | {"attempts", "model_bytes", "host", "slurm_job", "visible_gpus"}
            return [{key: value for key, value in row.items() if key not in dropped} for row in csv.DictReader(file)]

    def test_a_run_is_complete_repeats_nothing_and_continues_after_a_kill(self):
        rows = ("--rows", "3dgs,adr,quadbox,mask")
        first = self.paper("one", *rows)
        self.assertEqual(first.returncode, 0, first.stdout + first.stderr)
        measured = self.rows("one")
        self.assertEqual([row["state"] for row in measured], 8 * ["done"])
        page = (self.folder / "one/report.md").read_text()
        for part in ("Compact-3DGS", "measured on the CPU", "QuadBox over AdR", "jonbarron.info", "plots/zoom.svg",
                     "crops/photograph.png"):
            self.assertIn(part, page)
        done = json.loads((self.folder / "one/doll/seed0/quadbox/done.json").read_text())
        for key in ("commit", "seed", "settings", "data", "seconds", "program"):
            self.assertIsNotNone(done[key], key)
        compact = json.loads((self.folder / "one/doll/seed0/mask/done.json").read_text())
        self.assertTrue(compact["settings"]["color_field"])
        evaluated = (self.folder / "one/doll/seed0/mask/eval.log").read_text()
        self.assertIn("--exact-color", evaluated)
        model = self.folder / "one/doll/seed0/quadbox/model"
        self.assertFalse((model / "checkpoint").exists())
        self.assertEqual([path.name for path in (model / "point_cloud").iterdir()], ["iteration_20"])

        files = {path: path.stat().st_mtime_ns for path in (self.folder / "one").rglob("*.json")}
        second = self.paper("one", *rows)
        self.assertEqual(second.returncode, 0, second.stderr)
        self.assertIn("nothing to do", second.stdout)
        self.assertEqual(files, {path: path.stat().st_mtime_ns for path in (self.folder / "one").rglob("*.json")})

        other = self.paper("one", *rows, "--iterations", "30")
        self.assertEqual(other.returncode, 2)
        self.assertIn("was trained with other options", other.stderr)

        # Two jobs at a time, killed in the middle, then continued.
        process = subprocess.Popen(self.words("two", *rows, "--jobs", "2"), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                                   stdin=subprocess.DEVNULL, start_new_session=True)
        deadline = time.monotonic() + 60
        while not any((self.folder / "two").glob("*/seed0/*/done.json")) and time.monotonic() < deadline:
            time.sleep(0.05)
        for session in [process.pid, *children_of(process.pid)]:
            try:
                os.kill(session, signal.SIGKILL)
            except ProcessLookupError:
                pass
        process.wait()
        finished = [path.with_name("model") / "train.json" for path in (self.folder / "two").glob("*/seed0/*/done.json")]
        kept = {path: path.stat().st_mtime_ns for path in finished}
        self.assertNotEqual(kept, {})
        again = self.paper("two", *rows, "--jobs", "2")
        self.assertEqual(again.returncode, 0, again.stdout + again.stderr)
        self.assertEqual(kept, {path: path.stat().st_mtime_ns for path in kept})
        self.assertEqual(self.rows("two"), measured)

    def test_a_failed_row_does_not_stop_the_others(self):
        methods = self.folder / "methods.json"
        train = ["{program}", "train", "{data}", "--out-dir", "{out}", "--iterations", "2", "--random-points", "40", "--backend", "cpu"]
        methods.write_text(json.dumps([{"name": "broken", "command": ["false", "{data}"]}, {"name": "mine", "command": train},
                                       {"name": "plain", "options": ["--sh-degree", "0"]}]))
        run = self.paper("partial", "--rows", "mine,plain,broken", "--scenes", "doll", "--methods", str(methods))
        self.assertEqual(run.returncode, 2, run.stdout)
        self.assertIn("failed: train doll 0 broken: training failed", run.stdout)
        self.assertIn("--partial writes the tables", run.stderr)
        partial = self.paper("partial", "--rows", "mine,plain,broken", "--scenes", "doll", "--methods", str(methods), "--partial")
        self.assertEqual(partial.returncode, 0, partial.stderr)
        self.assertIn("- doll, seed 0, broken: not finished.", (self.folder / "partial/report.md").read_text())
        self.assertEqual({row["row"]: (row["state"], row["gaussians"]) for row in self.rows("partial")},
                         {"broken": ("missing", ""), "mine": ("done", "40"), "plain": ("done", "300")})

    def test_bad_input_gets_one_sentence(self):
        for more, sentence in ((("--scenes", "garden"), "get it from https://jonbarron.info"), (("--rows", "x"), "--rows: 'x' is none of"),
                               (("--profile", "none"), "--profile: none: is neither"), (("--methods", "none"), "cannot be read")):
            run = self.paper("bad", *more)
            self.assertNotEqual(run.returncode, 0)
            self.assertIn(sentence, run.stderr)
            self.assertEqual(run.stderr.count("\n"), 1, run.stderr)
        run = subprocess.run([PROGRAM, "paper", str(self.data), "--out-dir", str(self.data), *TINY], capture_output=True, text=True)
        self.assertIn("results would be written into the data set", run.stderr)
        run = self.paper("data/doll/transforms.json")
        self.assertEqual((run.returncode, run.stderr.count("\n")), (2, 1), run.stderr)
        tools = self.folder / "tools"
        tools.mkdir()
        for path, sentence in ((tools, "python3 was not found"), (tools, "snakemake was not found")):
            run = subprocess.run(self.words("bad"), capture_output=True, text=True, env={**os.environ, "PATH": str(path)})
            self.assertEqual((run.returncode, run.stderr.count("\n")), (3, 1), run.stderr)
            self.assertIn(sentence, run.stderr)
            if not (tools / "python3").exists():
                (tools / "python3").symlink_to(sys.executable)
        empty = self.folder / "empty"
        empty.mkdir()
        run = subprocess.run([PROGRAM, "paper", str(empty), "--out-dir", str(self.folder / "bad")], capture_output=True, text=True)
        self.assertIn("holds no data set", run.stderr)
        asked = subprocess.run([word for word in self.words("bad") if word != "--yes"], capture_output=True, text=True,
                               stdin=subprocess.DEVNULL)
        self.assertEqual(asked.returncode, 1)
        self.assertIn("--yes starts without asking", asked.stderr)


def children_of(process):
    """All descendants of a process."""
    listed = subprocess.run(["ps", "-e", "-o", "pid=,ppid="], capture_output=True, text=True, check=True).stdout
    parents = {int(pid): int(parent) for pid, parent in (line.split() for line in listed.splitlines())}
    found = [process]
    for known in found:
        found += [pid for pid, parent in parents.items() if parent == known]
    return found[1:]


SLURM_CONF = """ClusterName=test
SlurmctldHost={host}(127.0.0.1)
SlurmUser=root
SlurmdUser=root
AuthType=auth/none
CredType=cred/none
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
SlurmctldPort={port}
SlurmdPort={next_port}
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
MpiDefault=none
ReturnToService=2
GresTypes=gpu
NodeName={host} NodeAddr=127.0.0.1 CPUs=2 RealMemory=1000 Gres=gpu:2
PartitionName=main Nodes={host} Default=YES State=UP
"""


class Slurm(Runs):
    """A cluster of this machine with two GPUs by name."""

    def setUp(self):
        host = os.uname().nodename
        self.cluster = self.folder / "slurm"
        for name in ("state", "spool"):
            (self.cluster / name).mkdir(parents=True)
        port = 20000 + os.getpid() % 20000
        conf = self.cluster / "slurm.conf"
        conf.write_text(SLURM_CONF.format(host=host, folder=self.cluster, port=port, next_port=port + 1))
        (self.cluster / "gres.conf").write_text(f"NodeName={host} Name=gpu File=/dev/tty[0-1]\n")
        os.environ["SLURM_CONF"] = str(conf)
        for words in (["slurmctld", "-D", "-f", conf], ["slurmd", "-D", "-f", conf, "-N", host]):
            process = subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            self.addCleanup(process.wait)
            self.addCleanup(process.terminate)
        deadline = time.monotonic() + 60
        while "idle" not in subprocess.run(["sinfo", "-h", "-o", "%T"], capture_output=True, text=True).stdout:
            if time.monotonic() > deadline:
                self.skipTest("Slurm does not start on this machine")
            time.sleep(0.5)

    def test_a_run_is_complete_repeats_nothing_and_continues_after_a_kill(self):
        profile = self.folder / "profile"
        shutil.copytree(ROOT / "workflows/paper/profiles/slurm", profile)
        for config in profile.glob("config*.yaml"):
            config.write_text(config.read_text().replace("mem_mb=32000", "mem_mb=200").replace("latency-wait: 60", "latency-wait: 10"))
        words = self.words("cluster", "--rows", "3dgs,quadbox", "--profile", str(profile), "--jobs", "4")
        process = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, stdin=subprocess.DEVNULL)
        job = ""
        deadline = time.monotonic() + 60
        while not job and time.monotonic() < deadline:  # kills the first training that runs
            listed = subprocess.run(["squeue", "-h", "-t", "R", "-n", "quadsplat-train", "-o", "%i"], capture_output=True, text=True)
            job = listed.stdout.split()[0] if listed.stdout.split() else ""
            time.sleep(0.05)
        subprocess.run(["scancel", job], check=True)
        out, _ = process.communicate()
        logs = [*(self.folder / "cluster/slurm").glob("*.log")]
        self.assertEqual(process.returncode, 0, out + (self.folder / "cluster/snakemake.log").read_text()[-3000:])
        self.assertGreater(len(logs), 12)
        done = [json.loads(path.read_text()) for path in (self.folder / "cluster").glob("*/seed0/*/done.json")]
        self.assertEqual(len(done), 4)
        self.assertEqual({entry["visible_gpus"] for entry in done}, {"0", "1"})
        local = self.paper("alone", "--rows", "3dgs,quadbox")
        self.assertEqual(local.returncode, 0, local.stderr)
        self.assertEqual(self.rows("cluster"), self.rows("alone"))

    test_a_failed_row_does_not_stop_the_others = None
    test_bad_input_gets_one_sentence = None


def skip_reason(names):
    if {"Runs", "Slurm"} & set(names) and not shutil.which("snakemake"):
        return "snakemake is not installed"
    if "Slurm" in names and not (shutil.which("slurmctld") and shutil.which("slurmd") and shutil.which("sbatch")):
        return "Slurm is not installed"
    return "Slurm needs root here" if "Slurm" in names and os.geteuid() != 0 else ""


if __name__ == "__main__":
    if reason := skip_reason(sys.argv[1:]):
        print(f"skipped: {reason}")
    else:
        unittest.main()
