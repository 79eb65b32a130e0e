# SPDX-License-Identifier: MIT
"""Writes the small Compact-3DGS model of the tests with PyTorch and NumPy: make_compact.py tests/data

corpus/valid/compact_small.{ply,pth,npz} and compact_small_pp.npz hold the same values in all three forms, with a hash
grid of 2^6 entries per level. corpus/broken/compact_* would do harm to a program that trusts them. tensors/ gets small
files of PyTorch and pickles. The committed files were written with PyTorch 1.13.0a0 and NumPy 1.24.2 of Debian 12; old
streams of PyTorch number storages by their addresses, so they differ from run to run. dahuffman is not needed: its
tables are dictionaries, and the class of its end symbol is declared here under its name."""
import collections
import heapq
import io
import pickle
import sys
import types

import numpy as np
import torch

COUNT, STAGES, BITS, LOG2_ENTRIES = 150, 6, 6, 6
PHI = 0.6180339887498949


def fractions(count, first=0):
    """frac((k + 1) PHI) in 0..1: the same values everywhere."""
    k = np.arange(first, first + count, dtype=np.float64) + 1.0
    return k * PHI - np.floor(k * PHI)


huffmancodec = types.ModuleType("dahuffman.huffmancodec")
sys.modules["dahuffman"], sys.modules["dahuffman.huffmancodec"] = types.ModuleType("dahuffman"), huffmancodec


class _EndOfFileSymbol:
    pass


_EndOfFileSymbol.__module__ = "dahuffman.huffmancodec"
huffmancodec._EndOfFileSymbol = _EndOfFileSymbol
END = _EndOfFileSymbol()


def huffman_table(symbols):
    """{symbol: (bits, value)} with the end symbol, the shortest codes."""
    heap = [(n, i, [(s, 0, 0)]) for i, (s, n) in enumerate(sorted(collections.Counter(symbols).items()))]
    heap.append((1, len(heap), [(END, 0, 0)]))
    heapq.heapify(heap)
    number = len(heap)
    while len(heap) > 1:
        zero, one = heapq.heappop(heap), heapq.heappop(heap)
        codes = [(s, b + 1, v) for s, b, v in zero[2]] + [(s, b + 1, v + (1 << b)) for s, b, v in one[2]]
        heapq.heappush(heap, (zero[0] + one[0], number, codes))
        number += 1
    return {s: (b, v) for s, b, v in heap[0][2]}


def huffman_encode(table, symbols):
    bits = "".join(format(table[s][1], f"0{table[s][0]}b") for s in symbols)
    if len(bits) % 8:
        end = format(table[END][1], f"0{table[END][0]}b")
        bits = (bits + end)[: -(-len(bits) // 8) * 8]
        bits += "0" * (-len(bits) % 8)
    return np.array([int(bits[i : i + 8], 2) for i in range(0, len(bits), 8)], np.uint8)


class Parameters(torch.nn.Module):
    def __init__(self, values):
        super().__init__()
        self.params = torch.nn.Parameter(torch.from_numpy(values.astype(np.float32)))


class Codebook(torch.nn.Module):
    def __init__(self, embed):
        super().__init__()
        self.register_buffer("initted", torch.Tensor([True]))
        self.register_buffer("cluster_size", torch.ones(1, 2**BITS))
        self.register_buffer("embed_avg", embed.clone())
        self.register_buffer("embed", embed)


class Stage(torch.nn.Module):
    def __init__(self, embed):
        super().__init__()
        self._codebook = Codebook(embed)


class ResidualCodes(torch.nn.Module):
    def __init__(self, values):  # (layers, codes, dimensions)
        super().__init__()
        self.layers = torch.nn.ModuleList([Stage(torch.from_numpy(v[None].copy())) for v in values])


def codebook(dimensions, first):
    """The first layer holds whole vectors, the others ever smaller differences."""
    values = (2 * fractions(STAGES * 64 * dimensions, first) - 1).reshape(STAGES, 64, dimensions)
    values *= (0.5 ** np.arange(STAGES))[:, None, None]
    if dimensions == 3:  # scales
        values = values * 0.01
        values[0] += 0.05
    else:  # rotations: of about unit length
        values[0] /= np.linalg.norm(values[0], axis=-1, keepdims=True)
        values[1:] *= 0.1
    return values.astype(np.float32)


def packed(codes):
    return np.packbits(np.unpackbits(codes.astype(np.uint8)[..., None], axis=-1, count=BITS, bitorder="little").flatten())


def decoded(values, codes):
    total = np.zeros((len(codes), values.shape[-1]), np.float32)
    for layer in range(STAGES):
        total += values[layer][codes[:, layer]]
    return total


def write_ply(path, columns):
    names = "x y z nx ny nz opacity scale_0 scale_1 scale_2 rot_0 rot_1 rot_2 rot_3".split()
    header = f"ply\nformat binary_little_endian 1.0\nelement vertex {COUNT}\n"
    header += "".join(f"property float {name}\n" for name in names) + "end_header\n"
    with open(path, "wb") as file:
        file.write(header.encode() + columns.astype("<f4").tobytes())


def write_model(base):
    xyz = (2 * fractions(3 * COUNT, 1000) - 1).reshape(COUNT, 3) * 1.5
    xyz[:3] = [[0.3, -0.2, 0.5], [2.5, -1, 0.75], [-8, 40, 3]]
    xyz = xyz.astype(np.float16)
    codes = {name: np.floor(64 * fractions(COUNT * STAGES, first)).astype(np.int64).reshape(COUNT, STAGES)
             for name, first in (("scale", 5000), ("rotation", 9000))}
    books = {"scale": codebook(3, 100), "rotation": codebook(4, 20000)}
    # Both are exact in all forms: q/256, and -1/4 + q/512, mostly 0.
    q_opacity = np.floor(256 * fractions(COUNT, 77))
    q_opacity[:2] = [0, 255]
    minmax_opacity = np.array([0, 255 / 256], np.float32)
    entries = 16 * 2**LOG2_ENTRIES * 2
    q_hash = np.where(np.arange(entries) % 3 == 0, np.floor(256 * fractions(entries, 333)), 128.0)
    minmax_hash = np.array([-0.25, -0.25 + 255 / 512], np.float32)
    opacity = (q_opacity / 256).astype(np.float32)[:, None]
    grid = (-0.25 + q_hash / 512).astype(np.float32)
    shapes = [(64, 48), (64, 64), (16, 64)]
    mlp = np.concatenate([(2 * fractions(r * c, 40000 + 5000 * i) - 1) * np.sqrt(6 / (r + c))
                          for i, (r, c) in enumerate(shapes)]).astype(np.float16)

    scales, rotations = decoded(books["scale"], codes["scale"]), decoded(books["rotation"], codes["rotation"])
    write_ply(base + ".ply", np.concatenate([xyz, np.zeros_like(xyz), opacity, scales, rotations], axis=1))
    torch.save(torch.nn.ModuleList([Parameters(grid), Parameters(mlp)]).state_dict(), base + ".pth")
    arrays = {"xyz": xyz, "opacity": opacity.astype(np.float16), "scale": packed(codes["scale"]),
              "rotation": packed(codes["rotation"]), "hash": grid.astype(np.float16), "mlp": mlp}
    shared = {"codebook_scale": ResidualCodes(books["scale"]).state_dict(),
              "codebook_rotation": ResidualCodes(books["rotation"]).state_dict(),
              "rvq_info": np.array([STAGES, BITS])}
    np.savez(base + ".npz", **arrays, **shared)
    tables = {}
    for name, symbols in (("opacity", q_opacity.tolist()), ("scale", codes["scale"].reshape(-1).tolist()),
                          ("rotation", codes["rotation"].reshape(-1).tolist()), ("hash", q_hash.tolist())):
        tables["huftable_" + name] = huffman_table(symbols)
        arrays[name] = huffman_encode(tables["huftable_" + name], symbols)
    np.savez_compressed(base + "_pp.npz", **arrays, **tables, **shared,
                        minmax_opacity=minmax_opacity, minmax_hash=minmax_hash)
    return tables["huftable_opacity"], arrays["opacity"]


def write_tensors(folder, table, stream):
    tensors = collections.OrderedDict()
    tensors["floats"] = torch.arange(6, dtype=torch.float32).reshape(2, 3) / 4
    tensors["halves"] = torch.tensor([1.5, -2, float("inf"), 6e-8], dtype=torch.float16)
    tensors["part"] = torch.arange(10, dtype=torch.float32)[3:7]
    tensors["turned"] = torch.arange(6, dtype=torch.float32).reshape(2, 3).t()
    tensors["parameter"] = torch.nn.Parameter(torch.tensor([[7.0]]))
    tensors["empty"] = torch.zeros(0, 3)
    torch.save(tensors, folder + "/zip.pth")
    torch.save(tensors, folder + "/stream.pth", _use_new_zipfile_serialization=False)
    values = {"text": "b\u00e4r", "bytes": b"\x00\xff", "numbers": [0, 255, 65535, -1, 2**40, -(2**70)],
              "reals": (0.5, -1e300), "flags": [True, False, None], "nested": {"list": [[], {}, ()]}}
    values["again"] = values["numbers"]
    for protocol in (3, 4, 5):
        with open(f"{folder}/protocol_{protocol}.pkl", "wb") as file:
            pickle.dump(values, file, protocol)
    for protocol in (2, 4):
        text = io.BytesIO()
        np.save(text, np.array(table, dtype=object), allow_pickle=True)
        with open(f"{folder}/table_{protocol}.huffman", "wb") as file:  # a table, and a stream of codes
            pickle.dump(table, file, protocol)
            file.write(stream.tobytes())
    with open(folder + "/table.npy", "wb") as file:
        file.write(text.getvalue())


class RunsCode:
    def __reduce__(self):
        return print, ("this code must not run",)


def write_broken(folder):
    """Models of one Gaussian whose first codebook is a pickle that does harm, and a .ply without its network."""
    deep = []
    for _ in range(400):
        deep = [deep]
    own = []
    own.append(own)
    bombs = []
    for _ in range(80):
        bombs = [bombs, bombs]
    for name, item in (("code", RunsCode()), ("deep", deep), ("own", own), ("bomb", bombs)):
        np.savez_compressed(f"{folder}/compact_{name}.npz", xyz=np.zeros((1, 3), np.float16),
                            opacity=np.ones((1, 1), np.float16), rvq_info=np.array([STAGES, BITS]),
                            codebook_scale={"layers.0._codebook.embed": item})
    write_ply(folder + "/compact_no_network.ply", np.ones((COUNT, 14)))


def main():
    folder = sys.argv[1]
    table, stream = write_model(folder + "/corpus/valid/compact_small")
    write_tensors(folder + "/tensors", table, stream)
    write_broken(folder + "/corpus/broken")


if __name__ == "__main__":
    main()
