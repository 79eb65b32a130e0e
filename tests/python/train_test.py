# SPDX-License-Identifier: MIT
"""Training, against the program."""
import math
import os
import signal
import subprocess
import sys
import threading

import pytest

from conftest import PLUSH, ROOT

SMALL = {"random_points": 100, "sh_degree": 0}


@pytest.fixture(scope="module")
def data(write_data_set, tmp_path_factory):
    folder = tmp_path_factory.mktemp("photographs")
    write_data_set(folder)
    return folder


def gaussians(model, iteration):
    return (model / "point_cloud" / f"iteration_{iteration}" / "point_cloud.ply").read_bytes()


def test_a_model_has_the_bytes_of_the_program(quadsplat, cpu, program, data, tmp_path, capfd):
    states, sentences = [], []
    end = quadsplat.train(data, tmp_path / "own", strategy="adc", iterations=12, eval_every=10, final_prunes=False,
                          step_before_densify=True, background=(0.5, 0, 1), antialiased=True,
                          opacity_rate=1e-3, seed=None, callback=states.append,
                          text=sentences.append, context=cpu, **SMALL)
    assert capfd.readouterr() == ("", "")
    program("train", data, "--out-dir", tmp_path / "program", "--strategy", "adc", "--iterations", 12, "--eval-every", 10,
            "--step-before-densify", "--background", "0.5,0,1", "--antialiased", "on", "--backend",
            "cpu", "--opacity-rate", "0.001", "--random-points", 100, "--sh-degree", 0)
    assert gaussians(tmp_path / "own", 12) == gaussians(tmp_path / "program", 12)
    assert [state.iteration for state in states] == [*range(12), 12, 12][:len(states)]
    assert states[0].loss == 0 and states[1].loss > 0 and math.isnan(states[1].test_psnr)
    assert end == states[-1] and end.finished and end.evaluated == 12 and end.gaussians == 100
    assert end.test_psnr > 5 and 0 < end.test_ssim < 1 and end.seconds > 0 and end.iterations == 12
    assert "training on cpu" in sentences and any("wrote " in text for text in sentences)
    assert len(quadsplat.load(tmp_path / "own", context=cpu)) == 100


def test_the_state_has_the_curve_of_the_guard(quadsplat, cpu, data, tmp_path):
    states = []
    quadsplat.train(data, tmp_path / "model", guard=True, iterations=40, callback=states.append, context=cpu, **SMALL)
    assert math.isnan(states[0].guard_psnr) and states[0].guarded == states[0].growth_ended == 0
    curve = {state.guarded: state.guard_psnr for state in states if state.guarded}
    # In the model's folder: the last value before each row.
    rows = [line.split(",") for line in (tmp_path / "model" / "train.csv").read_text().splitlines()]
    assert rows[0][-1] == "reserved_psnr" and len(curve) > 1 and 4 < min(curve) and max(curve) <= 40
    assert float(rows[-1][-1]) == pytest.approx(curve[max(curve)], abs=1e-3)
    assert not {state.growth_ended for state in states} - {0, *curve}


def test_a_callback_ends_a_run_which_continues_to_the_same_bits(quadsplat, data, tmp_path):
    with quadsplat.Context("cpu", threads=1) as one, quadsplat.Context("cpu", threads=2) as two:
        quadsplat.train(data, tmp_path / "whole", iterations=9, context=one, **SMALL)
        early = quadsplat.train(data, tmp_path / "parts", iterations=9, context=two,
                                callback=lambda state: state.iteration == 4, **SMALL)
        assert early.iteration == 4 and not early.finished

        class Own(Exception):
            pass

        def fail(state):
            if state.iteration == 6:
                raise Own("sentence")

        with pytest.raises(Own, match="^sentence$"):
            quadsplat.train(data, tmp_path / "parts", iterations=9, context=two, resume=True,
                            callback=fail, **SMALL)
        with pytest.raises(quadsplat.Cancelled):
            quadsplat.train(data, tmp_path / "parts", iterations=9, context=two, resume=True,
                            callback=lambda state: two.stop(), **SMALL)
        quadsplat.train(data, tmp_path / "parts", iterations=9, context=two, resume=True, **SMALL)
    assert gaussians(tmp_path / "whole", 9) == gaussians(tmp_path / "parts", 9)


@pytest.fixture
def own_context(quadsplat):
    with quadsplat.Context("cpu", threads=1) as context:
        yield context


def test_a_callback_that_uses_or_closes_its_context_is_refused(quadsplat, data, tmp_path, own_context):
    drawn = quadsplat.load(PLUSH, context=own_context)
    camera = quadsplat.Camera(8, 8, 8)
    acts = {"render": lambda: quadsplat.render(drawn, camera), "Context.close": own_context.close,
            "train": lambda: quadsplat.train(data, tmp_path / "inner", context=own_context, **SMALL)}
    sentences = []

    def callback(state):
        for act in acts.values():
            with pytest.raises(quadsplat.UsageError) as raised:
                act()
            sentences.append(str(raised.value))
        return True

    end = {}
    thread = threading.Thread(daemon=True, target=lambda: end.update(state=quadsplat.train(
        data, tmp_path / "model", context=own_context, callback=callback, **SMALL)))
    thread.start()
    thread.join(60)
    assert not thread.is_alive() and end["state"].iteration == 0
    assert sentences == [f"{who}: the context is used by the call that called this callback: open another context, "
                         "or wait for the end of the call" for who in acts]
    quadsplat.render(drawn, camera)  # the context is still open


def test_ctrl_c_ends_no_call_of_another_thread(quadsplat, data, tmp_path, own_context):
    began, may_end, ends = threading.Event(), threading.Event(), {}

    def wait(state):
        began.set()
        may_end.wait(60)

    other = threading.Thread(target=lambda: ends.update(other=quadsplat.train(
        data, tmp_path / "other", iterations=2, context=own_context, callback=wait, **SMALL)))
    other.start()
    began.wait(60)
    timers = [threading.Timer(0.2, os.kill, (os.getpid(), signal.SIGINT)), threading.Timer(0.8, may_end.set)]
    for timer in timers:
        timer.start()
    with pytest.raises(KeyboardInterrupt):
        quadsplat.train(data, tmp_path / "model", context=own_context, **SMALL)
    other.join()
    assert ends["other"].finished


def test_ctrl_c_ends_a_run_which_is_saved(data, tmp_path):
    code = f"""
import quadsplat
quadsplat.train({str(data)!r}, {str(tmp_path / "model")!r}, context=quadsplat.Context("cpu"),
                random_points=100, sh_degree=0,
                callback=lambda state: print(state.iteration, flush=True))
"""
    child = subprocess.Popen([sys.executable, "-B", "-c", code], stdout=subprocess.PIPE, text=True,
                             stderr=subprocess.PIPE,
                             env={**os.environ, "PYTHONPATH": str(ROOT / "python")})
    while child.stdout.readline().strip() != "3":
        assert child.poll() is None, child.stderr.read()
    child.send_signal(signal.SIGINT)
    out, error = child.communicate(timeout=300)
    last = int(("3 " + out).split()[-1])
    assert child.returncode == -signal.SIGINT and error.rstrip().endswith("KeyboardInterrupt"), error
    assert last < 30000 and gaussians(tmp_path / "model", last)


def test_other_threads_train_and_convert_at_the_same_time(quadsplat, scene, data, tmp_path):
    written = []

    def convert(state):
        target = tmp_path / f"{state.iteration}.ply"
        quadsplat.convert(scene, target, sh_degree=0)
        written.append(target.exists())

    ends = {}
    threads = [threading.Thread(target=lambda name=name: ends.update({name: quadsplat.train(
        data, tmp_path / name, iterations=3, context=quadsplat.Context("cpu", threads=1),
        callback=convert if name == "a" else None, **SMALL)})) for name in "ab"]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert ends["a"].finished and ends["b"].finished and written and all(written)
    assert gaussians(tmp_path / "a", 3) == gaussians(tmp_path / "b", 3)
    with pytest.raises(quadsplat.UsageError, match="exists already: choose another name, or replace "
                                                   "it with the option overwrite"):
        quadsplat.convert(scene, tmp_path / "0.ply", sh_degree=0)


def test_wrong_options_get_the_sentence_of_the_program(quadsplat, cpu, data, tmp_path):
    def refused(kind=quadsplat.UsageError, folder=data, **options):
        with pytest.raises(kind) as error:
            quadsplat.train(folder, tmp_path / "model", context=cpu, **options)
        return str(error.value)

    assert refused(iteration=3) == ("train: options[0]: there is no option '--iteration'; did you "
                                    "mean '--iterations'?")
    assert refused(iterations=0) == "--iterations: '0' is not a whole number from 1 to 10000000"
    assert refused(strategy="best").startswith("--strategy: 'best' is none of paced, adc, ")
    assert refused(backend="cpu").endswith("--backend belongs to the context")
    assert refused(seed=object()).startswith("train: seed is <object")
    assert refused(seed=float("nan")) == "train: seed is nan instead of a text or numbers"
    assert refused(color_field=True) == "--color-field: is for --strategy mask, not paced"
    missing = tmp_path / "missing"
    assert str(missing) in refused(quadsplat.InputError, missing)
    assert not (tmp_path / "model").exists()
    (tmp_path / "model").mkdir()
    (tmp_path / "model" / "a").touch()
    assert "is not empty: choose another name, or replace its files with --overwrite" in refused()
