# SPDX-License-Identifier: MIT
"""Threads, processes, and the lazy import."""
import concurrent.futures
import gc
import os
import threading
import time

import numpy as np
import pytest

from conftest import PLUSH


def test_threads_share_a_scene_in_turn(quadsplat, scene):
    cameras = [camera.resized(64, 48) for camera in scene.cameras()[:6]]
    expected = [quadsplat.render(scene, camera).color for camera in cameras]
    with concurrent.futures.ThreadPoolExecutor(4) as pool:
        drawn = list(pool.map(lambda camera: quadsplat.render(scene, camera).color, cameras * 4))
    for color, wanted in zip(drawn, expected * 4):
        assert np.array_equal(color, wanted)


def test_threads_with_their_own_contexts_draw_at_the_same_time(quadsplat, one):
    camera = quadsplat.Camera(64, 48, 50)
    expected = quadsplat.render(one(), camera).color

    def work(_):
        with quadsplat.Context("cpu", threads=1) as context:
            scene = one(context=context)
            return all(np.array_equal(quadsplat.render(scene, camera).color, expected)
                       for _ in range(20))

    with concurrent.futures.ThreadPoolExecutor(4) as pool:
        assert all(pool.map(work, range(8)))


def test_a_scene_is_freed_while_another_thread_draws(quadsplat, scene, cpu, one):
    camera = scene.cameras()[0].resized(200, 150)
    expected = quadsplat.render(scene, camera).color
    done = threading.Event()

    def drop_scenes():
        while not done.is_set():
            one(context=cpu)
            gc.collect()

    thread = threading.Thread(target=drop_scenes)
    thread.start()
    try:
        for _ in range(10):
            assert np.array_equal(quadsplat.render(scene, camera).color, expected)
    finally:
        done.set()
        thread.join()


def test_another_thread_stops_a_call(quadsplat, scene):
    with quadsplat.Context("cpu") as context:
        own = quadsplat.load(PLUSH, context=context)
        camera = own.cameras()[0]
        context.stop()  # without a call it does nothing
        quadsplat.render(own, camera.resized(16, 16))
        done = threading.Event()

        def stop():
            while not done.is_set():
                context.stop()
                time.sleep(0.01)

        thread = threading.Thread(target=stop)
        thread.start()
        try:
            with pytest.raises(quadsplat.Cancelled):
                quadsplat.render(own, camera, cull="reference")
        finally:
            done.set()
            thread.join()
        quadsplat.render(own, camera.resized(16, 16))
    context.stop()


def in_child(act):
    """Runs act() in a forked child. Returns its text."""
    read, write = os.pipe()
    child = os.fork()
    if child == 0:
        try:
            os.write(write, act().encode())
        except BaseException as error:  # the child must not go on with the tests
            os.write(write, f"{type(error).__name__}: {error}".encode())
        finally:
            os._exit(0)
    os.close(write)
    with os.fdopen(read) as pipe:
        text = pipe.read()
    os.waitpid(child, 0)
    return text


def test_a_forked_child_may_not_use_the_parents_scene(quadsplat, one):
    scene, camera = one(), quadsplat.Camera(8, 8, 8)
    quadsplat.render(scene, camera)
    for act in (lambda: str(quadsplat.render(scene, camera)),
                lambda: str(quadsplat.tile_lists(scene, camera)),
                lambda: str(one())):
        text = in_child(act)
        assert text.startswith("UsageError: ") and "was forked" in text and "spawn" in text

    def leaves_things_alone():
        scene.close()
        scene.context.stop()
        scene.context.close()
        gc.collect()
        return "left alone"

    assert in_child(leaves_things_alone) == "left alone"
    quadsplat.render(scene, camera)


def test_a_forked_child_of_a_busy_parent_is_refused_at_once(quadsplat, scene, camera):
    busy = scene.context._use("test")
    with busy:
        assert "was forked" in in_child(lambda: str(quadsplat.render(scene, camera)))


def test_a_forked_child_opens_its_own(quadsplat, scene, one):
    camera = quadsplat.Camera(8, 8, 8)
    expected = quadsplat.render(one(), camera).color

    def draws():
        with quadsplat.Context("cpu", threads=2) as context:
            color = quadsplat.render(one(context=context), camera).color
            assert np.array_equal(color, expected)
        assert quadsplat.compare(color, expected).psnr == float("inf")
        return "drawn"

    quadsplat.compare(expected, expected)
    assert in_child(draws) == "drawn"


def test_importing_loads_neither_torch_nor_cuda_and_starts_no_thread(python):
    assert python("""
import sys, os
import quadsplat
assert "torch" not in sys.modules and "cupy" not in sys.modules and "jax" not in sys.modules
assert len(os.listdir("/proc/self/task")) == 1
maps = open("/proc/self/maps").read()
assert "libcuda.so" not in maps and "libtorch" not in maps
print(quadsplat.__version__)
""", OPENBLAS_NUM_THREADS="1", OMP_NUM_THREADS="1").strip()


def test_the_reason_for_the_cpu_is_said_once(python, quadsplat):
    reason = quadsplat.report().cuda_problem
    if not reason:
        pytest.skip("this machine has a GPU")
    printed = python(f"""
import warnings
import quadsplat
with warnings.catch_warnings(record=True) as caught:
    warnings.simplefilter("always")
    scene = quadsplat.load({str(PLUSH)!r})
    quadsplat.Context()
    quadsplat.Context("cpu")
assert scene.context.backend == "cpu"
print([(str(warning.message), warning.filename, warning.lineno) for warning in caught])
""")
    assert printed.strip() == str([(f"quadsplat draws on the CPU: {reason}", "<string>", 6)])


def test_a_missing_backend_is_a_device_error(quadsplat):
    if not quadsplat.report().cuda_problem:
        pytest.skip("this machine has a GPU")
    with pytest.raises(quadsplat.DeviceError):
        quadsplat.Context("cuda")


def test_the_report_names_library_and_devices(quadsplat):
    report = quadsplat.report()
    assert report.version == quadsplat.__version__ and report.threads >= 1
    assert (report.first_gpu is None) == bool(report.cuda_problem)
    assert quadsplat.devices() == report.devices
    assert report.version in str(report) and report.cuda_problem in str(report)


def test_a_process_ends_with_open_scenes(python):
    assert python(f"""
import warnings; warnings.simplefilter("ignore")
import quadsplat
scene = quadsplat.load({str(PLUSH)!r})
other = quadsplat.load({str(PLUSH)!r}, context=quadsplat.Context("cpu"))
quadsplat.render(scene, scene.cameras()[0].resized(20, 10))
scene.itself = scene
print("end")
""") == "end\n"
