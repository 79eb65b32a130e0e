# SPDX-License-Identifier: MIT
"""Tile lists, and the pairs of every mode."""
import json

import numpy as np
import pytest

from conftest import PLUSH


def test_counts_are_those_of_tile_lists_and_frames(quadsplat, scene, camera):
    counted = quadsplat.counts(scene, camera)
    known = [mode.name for mode in quadsplat.modes() if not mode.is_peer][1:]
    assert list(counted) == known and "quadbox" in known
    for mode, count in counted.items():
        lists = quadsplat.tile_lists(scene, camera, cull=mode)
        frame = quadsplat.render(scene, camera, cull=mode, outputs="pairs")
        assert count.tile_pairs == len(lists.listed) == frame.counts.tile_pairs
        assert count.visible == len(lists.gaussians) == frame.counts.visible
        assert np.array_equal(lists.pairs(), frame.pairs)
    assert counted["exact"].tile_pairs <= counted["quadbox"].tile_pairs <= counted["3dgs"].tile_pairs


def test_counts_are_those_of_the_program(quadsplat, scene, camera, program, tmp_path):
    program("render", PLUSH, "--backend", "cpu", "--camera-index", 32, "--size", "150x101", "--cull",
            "all", "--repeats", 1, "--stats", tmp_path / "a.json")
    text = (tmp_path / "a.json").read_text()
    for mode, count in quadsplat.counts(scene, camera).items():
        assert f'"{mode}"' in text and str(count.tile_pairs) in text
    json.loads(text)


def test_lists_are_sorted_front_to_back_and_cover_their_tiles(quadsplat, scene, camera):
    lists = quadsplat.tile_lists(scene, camera)
    depth_of = dict(zip(lists.gaussians.tolist(), lists.depths.tolist()))
    assert (np.diff(lists.gaussians.astype(np.int64)) > 0).all()
    total = 0
    for row in range(lists.tile_rows):
        for column in range(lists.tile_columns):
            numbers = lists.of_tile(row, column).tolist()
            depths = [depth_of[number] for number in numbers]
            assert depths == sorted(depths) and len(set(numbers)) == len(numbers)
            total += len(numbers)
    assert total == len(lists.listed) == lists.tile_begin[-1]
    xx, xy, yy = lists.covariances.T.astype(np.float64)
    a, b, c = lists.conics.T.astype(np.float64)
    assert a * xx + b * xy == pytest.approx(np.ones(len(a)), rel=1e-2)
    assert lists.means_px.shape == (len(a), 2) and lists.colors.shape == (len(a), 3)
    assert (lists.opacities > 1 / 255).all() and (lists.opacities <= 1).all()
    kept = lists.listed.copy()
    quadsplat.tile_lists(scene, camera, cull="3dgs")
    assert np.array_equal(lists.listed, kept)


def test_the_reference_mode_lists_every_gaussian_once(quadsplat, one):
    lists = quadsplat.tile_lists(one(), quadsplat.Camera(40, 30, 20), cull="reference")
    assert lists.listed.tolist() == [0]


def test_tiles_that_do_not_exist_are_refused(quadsplat, one):
    lists = quadsplat.tile_lists(one(), quadsplat.Camera(40, 30, 20))
    assert (lists.tile_rows, lists.tile_columns) == (2, 3)
    for row, column in [(2, 0), (0, 3), (-1, 0), (0, 1.5)]:
        with pytest.raises(quadsplat.UsageError, match="^TileLists.of_tile: "):
            lists.of_tile(row, column)


def test_modes_are_described(quadsplat):
    modes = {mode.name: mode for mode in quadsplat.modes()}
    assert list(modes)[0] == "reference" and all(mode.summary for mode in modes.values())
    assert modes["quadbox"].is_lossless and not modes["quadbox"].is_peer
    assert not modes["dualbox"].is_lossless and modes["3dgs"].keeps_faint
