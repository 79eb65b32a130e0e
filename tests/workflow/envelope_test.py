# SPDX-License-Identifier: MIT
"""The scripts envelope and synthetic_set: rules without a program, and small sets and runs on the CPU.

  QUADSPLAT=PROGRAM python3 envelope_test.py [CLASS...]
"""
import csv
import importlib.util
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest
from importlib.machinery import SourceFileLoader

sys.dont_write_bytecode = True
ROOT = pathlib.Path(__file__).resolve().parents[2]
PROGRAM = os.environ.get("QUADSPLAT", str(ROOT / "build/optimised/quadsplat"))
LOADER = SourceFileLoader("envelope", str(ROOT / "scripts/envelope"))
envelope = importlib.util.module_from_spec(importlib.util.spec_from_loader("envelope", LOADER))
LOADER.exec_module(envelope)


def script(name, *words):
    return subprocess.run([sys.executable, "-B", ROOT / "scripts" / name, *map(str, words)], capture_output=True, text=True,
                          env={**os.environ, "PROGRAM": PROGRAM})


class Rules(unittest.TestCase):
    def test_each_length_of_a_row_is_a_run(self):
        self.assertEqual(envelope.rows_of(["# text", "", "few=--strategy fastgs --iterations 5,10 --cull exact # more", "adc = --strategy adc"]),
                         [("few", ["--strategy", "fastgs", "--cull", "exact"], 5), ("few", ["--strategy", "fastgs", "--cull", "exact"], 10),
                          ("adc", ["--strategy", "adc"], 30000)])
        self.assertTrue(envelope.rows_of((ROOT / "scripts/envelope_runs.txt").read_text().splitlines()))

    def test_wrong_rows_are_refused_by_name(self):
        for rows, sentence in ((["few"], "'few' is not NAME=OPTIONS"), (["a/b=--seed 1"], "'a/b=--seed 1' is not NAME=OPTIONS"),
                               (["few=--iterations"], "row few"), (["few=--iterations 5,x"], "row few"), (["few=--cull 'x"], "row few"),
                               (["=--cull exact"], "is not NAME=OPTIONS"), (["few=--iterations 5", "few=--iterations 5"], "two rows are named few")):
            with self.assertRaisesRegex(SystemExit, re.escape(sentence)):
                envelope.rows_of(rows)

    def test_values_between_evaluations_are_linear_and_none_exist_outside(self):
        points = [(1.0, 20.0, 100), (3.0, 24.0, 300)]
        self.assertEqual(envelope.between(points, 2), [22.0, 200.0])
        self.assertEqual(envelope.between(points, 3), [24.0, 300.0])
        self.assertIsNone(envelope.between(points, 0.5))
        self.assertIsNone(envelope.between(points, 3.5))
        self.assertIsNone(envelope.between(points[:1], 1.5))

    def test_a_mark_that_some_seeds_do_not_reach_counts_them(self):
        cells = [*envelope.mark_cells([[(1, 20, 0.5, 1000), (3, 22, 0.7, 3000)], [(1, 22, 0.7, 1000), (9, 30, 0.9, 9000)]])]
        self.assertEqual(cells[0], "22.00 (21.00 to 23.00), 0.6625, 2 k")
        self.assertEqual(cells[1], "26.00, 0.8000, 5 k; 1 of 2 seeds")
        self.assertEqual(cells[2], "-")

    def test_the_page_has_means_of_seeds_peers_the_card_and_the_jobs(self):
        with tempfile.TemporaryDirectory() as name:
            out = pathlib.Path(name)
            for seed, length, jobs in ((0, 100, 1), (1, 100, 1), (0, 200, 1), (1, 200, 2)):
                folder = out / f"doll_few_{length}_{seed}"
                folder.mkdir()
                log = [{"iteration": i, "seconds": i / 10, "loss": 1, "gaussians": 1000 * i, "test_psnr": 20 + seed + i / 100, "test_ssim": 0.5}
                       for i in range(10, length + 1, 10)]
                (folder / "train.json").write_text(json.dumps(
                    {"settings": {"iterations": length, "seed": seed}, "log": log,
                     "environment": {"backend": "cuda, NVIDIA X1"}, "result": {"iteration": length, "stage_seconds": {"forward": 1}}}))
                (folder / "row.json").write_text(json.dumps({"set": "doll", "name": "few", "options": ["--strategy", "fastgs"], "jobs": jobs}))
            peers = out / "peers.csv"
            peers.write_text("name,set,seconds,psnr,ssim,gaussians,card,source\nOther,doll,4,25,,,X2,paper\nOther,room,4,25,,,X2,\n")
            done = script("envelope", "page", out, "--peers", peers)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertIn("left out: room", done.stderr)
            for part in ("Measured on NVIDIA X1, with --jobs 1, 2: seconds are not comparable.",
                         "| few, along 200 | 20.70 (20.20 to 21.20), 0.5000, 20 k |", "| few, ends | - | - | 21.50 (21.00 to 22.00), 0.5000, 100 k |",
                         "| few, 200 | 2 | 20.0 | 22.50 (22.00 to 23.00) | 0.00 |", "| Other, X2 | 4.0 | 25.00 | - | - | paper |",
                         "| few | --strategy fastgs |"):
                self.assertIn(part, done.stdout)
            self.assertEqual((out / "envelope.md").read_text(), done.stdout)
            self.assertIn("<td>few, along 200</td>", (out / "envelope.html").read_text())
            for text in ("name,set\nOther,doll\n", "name,set,seconds,psnr,ssim,gaussians,card,source\nOther,doll,x,25,,,X2,\n"):
                peers.write_text(text)
                self.assertRegex(script("envelope", "page", out, "--peers", peers).stderr, "a row is not name,set")


class Runs(unittest.TestCase):
    def test_a_set_from_given_cameras_has_these_cameras_and_trains(self):
        with tempfile.TemporaryDirectory() as name:
            out, scene = pathlib.Path(name), ROOT / "assets/plush.ply"
            first = script("synthetic_set", scene, out / "sphere", "--views", 9, "--size", "48x36")
            self.assertEqual(first.returncode, 0, first.stderr)
            done = script("synthetic_set", scene, out / "set", "--cameras", out / "sphere/transforms.json", "--points", 300, "--size", "96x72")
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertIn("9 views of plush.ply, 96x72, 300 points", done.stdout)
            sphere, given = (json.loads((out / folder / "transforms.json").read_text()) for folder in ("sphere", "set"))
            for one, two in zip(sphere["frames"], given["frames"], strict=True):
                self.assertEqual(one["file_path"], two["file_path"])
                self.assertAlmostEqual(2 * one["fl_x"], two["fl_x"])
                for a, b in zip(sum(one["transform_matrix"], []), sum(two["transform_matrix"], [])):
                    self.assertAlmostEqual(a, b)
            measured = subprocess.run([PROGRAM, "eval", scene, "--cameras", out / "set/transforms.json", "--images", out / "set/images",
                                       "--csv", "-"], capture_output=True, text=True).stdout
            psnr = [float(row["psnr"]) for row in csv.DictReader(measured.splitlines())]
            self.assertEqual(len(psnr), 9, measured)
            self.assertGreater(min(psnr), 50)  # rounding to 8 bits leaves 59

            words = ("train", out / "runs", out / "set", "--backend", "cpu", "--seeds", "0,1", "--run", "few=--strategy fastgs --iterations 4,8")
            done = script("envelope", *words, "--jobs", 2)
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
            self.assertEqual(sorted(f.name for f in (out / "runs").iterdir()), [f"set_few_{n}_{seed}" for n in (4, 8) for seed in (0, 1)])
            report = json.loads((out / "runs/set_few_8_1/train.json").read_text())
            self.assertEqual((report["data"]["points"], report["settings"]["seed"], len(report["log"])), (300, 1, 8))
            self.assertFalse((out / "runs/set_few_8_1/point_cloud").exists())
            self.assertEqual(script("envelope", *words).stdout, "")  # nothing is trained twice
            (out / "b/set").mkdir(parents=True)
            self.assertIn("two sets have the same name: set, set",
                          script("envelope", "train", out / "runs", out / "set", out / "b/set").stderr)
            other = script("envelope", *words[:-1], "few=--strategy adc --iterations 8")
            self.assertIn("was trained with --strategy fastgs", other.stderr)
            self.assertEqual(script("envelope", "page", out / "runs").returncode, 0)
            self.assertEqual(script("envelope", *words[:-1], "bad=--strategy none --iterations 1").returncode, 1)


if __name__ == "__main__":
    unittest.main()
