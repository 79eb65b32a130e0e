#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Writes the small files with levels of detail of tests/data/corpus, byte by byte: lod_tree.rad, lod_tree.spz, lod_tree.hier and
lod_halves.hier. Usage: tests/data/make_lod.py FOLDER

A tree of 21 nodes: the root, 4 children and 16 leaves with random values. Needs no packages."""
import gzip
import json
import math
import random
import struct
import sys
import zlib

NODES, LEAVES, CHUNK = 21, 16, 8
rng = random.Random(58)


def unit(values):
    length = math.sqrt(sum(v * v for v in values))
    return [v / length for v in values]


def node(i):
    w, *xyz = unit([rng.gauss(0, 1) for _ in range(4)])
    sign = 1 if w >= 0 else -1
    return {
        'center': [rng.uniform(-2, 2) for _ in range(3)],
        'alpha': rng.uniform(0.05, 1) if i >= NODES - LEAVES else 1.5,
        'rgb': [rng.uniform(0, 1) for _ in range(3)],
        'scales': [math.exp(rng.uniform(-5, -1)) for _ in range(3)],
        'xyzw': [sign * v for v in [*xyz, w]],
        'sh': [rng.uniform(-0.5, 0.5) for _ in range(45)],
        'child_count': 4 if i < NODES - LEAVES else 0,
        'child_start': 4 * i + 1 if i < NODES - LEAVES else 0,
    }


nodes = [node(i) for i in range(NODES)]


def byte(value):
    return max(0, min(255, round(value)))


def padded(data):
    return data + bytes(-len(data) % 8)


# ---- RAD, with the encodings that Spark writes -----------------------------------------------------------------------------------


def planes(part, key, first=0, size=None):
    size = len(part[0][key]) - first if size is None else size
    return [n[key][first + d] for d in range(size) for n in part]


def octahedron(xyzw):
    angle = 2 * math.acos(min(1, xyzw[3]))
    x, y, z = unit(xyzw[:3])
    total = abs(x) + abs(y) + abs(z)
    u, v = x / total, y / total
    if z < 0:
        u, v = math.copysign(1 - abs(v), u), math.copysign(1 - abs(u), v)
    return [byte((u + 1) * 127.5), byte((v + 1) * 127.5), byte(angle / math.pi * 255)]


def deltas(values, rows):
    return bytes((v - (values[i - 1] if i % rows else 0)) % 256 for i, v in enumerate(values))


def rad_chunk(base):
    part = nodes[base:base + CHUNK]
    rows = len(part)
    floats = struct.pack(f'<{3 * rows}f', *planes(part, 'center'))
    properties = [
        ('center', 'f32_lebytes', b''.join(floats[b::4] for b in range(4)), {}),
        ('alpha', 'f16', struct.pack(f'<{rows}e', *[n['alpha'] for n in part]), {}),
        ('rgb', 'r8_delta', deltas([byte(v * 255) for v in planes(part, 'rgb')], rows), {'min': 0.0, 'max': 1.0}),
        ('scales', 'ln_0r8', bytes(1 + byte((math.log(v) + 12) * 254 / 21) for v in planes(part, 'scales')), {'min': -12.0, 'max': 9.0}),
        ('orientation', 'oct88r8', bytes(b for n in part for b in octahedron(n['xyzw'])), {}),
    ]
    for name, first, size in (('sh1', 0, 9), ('sh2', 9, 15), ('sh3', 24, 21)):
        data = bytes(round(v * 127) % 256 for v in planes(part, 'sh', first, size))
        properties.append((name, 's8', data, {'min': -1.0, 'max': 1.0}))
    properties.append(('child_count', 'u16', struct.pack(f'<{rows}H', *[n['child_count'] for n in part]), {}))
    properties.append(('child_start', 'u32', struct.pack(f'<{rows}I', *[n['child_start'] for n in part]), {}))
    listed, payload = [], b''
    for name, encoding, data, limits in properties:
        packer = zlib.compressobj(6, zlib.DEFLATED, -15)
        packed = packer.compress(data) + packer.flush()
        listed.append({'offset': len(payload), 'bytes': len(packed), 'property': name, 'encoding': encoding, 'compression': 'gz', **limits})
        payload += padded(packed)
    meta = {'version': 1, 'base': base, 'count': rows, 'payloadBytes': len(payload), 'maxSh': 3, 'lodTree': True, 'properties': listed}
    text = json.dumps(meta).encode()
    return b'RADC' + struct.pack('<I', len(text)) + padded(text) + struct.pack('<Q', len(payload)) + payload


def rad():
    chunks = [rad_chunk(base) for base in range(0, NODES, CHUNK)]
    offsets = [sum(map(len, chunks[:i])) for i in range(len(chunks))]
    meta = {'version': 1, 'type': 'gsplat', 'count': NODES, 'maxSh': 3, 'lodTree': True, 'chunkSize': CHUNK, 'allChunkBytes': sum(map(len, chunks)),
            'chunks': [{'offset': o, 'bytes': len(c)} for o, c in zip(offsets, chunks)],
            'splatEncoding': {'rgbMin': 0.0, 'rgbMax': 1.0, 'lnScaleMin': -12.0, 'lnScaleMax': 9.0, 'sh1Max': 1.0, 'sh2Max': 1.0,
                              'sh3Max': 1.0, 'lodOpacity': True}}
    text = json.dumps(meta, indent=2).encode()
    return b'RAD0' + struct.pack('<I', len(text)) + padded(text) + b''.join(chunks)


# ---- SPZ, version 2 --------------------------------------------------------------------------------------------------------------


def spz():
    data = b'NGSP' + struct.pack('<IIBBBB', 2, NODES, 1, 12, 0x80, 0)
    data += b''.join((round(v * 4096) % 2**24).to_bytes(3, 'little') for n in nodes for v in n['center'])
    data += bytes(byte(n['alpha'] * 127.5) for n in nodes)
    data += bytes(byte(((v - 0.5) / 0.28209479177387814 * 0.15 + 0.5) * 255) for n in nodes for v in n['rgb'])
    data += bytes(byte((math.log(v) + 10) * 16) for n in nodes for v in n['scales'])
    data += bytes(byte((v + 1) * 127.5) for n in nodes for v in n['xyzw'][:3])
    data += bytes(byte(v * 128 + 128) for n in nodes for v in n['sh'][:9])
    data += struct.pack(f'<{NODES}H', *[n['child_count'] for n in nodes])
    data += struct.pack(f'<{NODES}I', *[n['child_start'] for n in nodes])
    return gzip.compress(data, 9, mtime=0)


# ---- hierarchical-3d-gaussians ---------------------------------------------------------------------------------------------------


def hier(halves):
    letter = 'e' if halves else 'f'
    data = struct.pack('<i', -NODES if halves else NODES)
    data += struct.pack(f'<{3 * NODES}f', *[v for n in nodes for v in n['center']])
    wxyz = [v for n in nodes for v in [n['xyzw'][3], *n['xyzw'][:3]]]
    logs = [math.log(v) for n in nodes for v in n['scales']]
    sh = [v for n in nodes for v in [(c - 0.5) / 0.28209479177387814 for c in n['rgb']] + n['sh']]
    for values in (wxyz, logs, [n['alpha'] for n in nodes], sh):
        data += struct.pack(f'<{len(values)}{letter}', *values)
    data += struct.pack('<i', NODES)
    for i, n in enumerate(nodes):
        leaf = n['child_count'] == 0
        depth, parent = (0, -1) if i == 0 else (1 if i < 5 else 2, (i - 1) // 4)
        numbers = depth, parent, i, int(leaf), int(not leaf), n['child_start'], n['child_count']
        if halves:
            data += struct.pack('<3i4h', parent, i, n['child_start'], depth, n['child_count'], int(leaf), int(not leaf))
        else:
            data += struct.pack('<7i', *numbers)
    for n in nodes:
        extent = 6 * max(n['scales'])
        data += struct.pack(f'<8{letter}', *[v - extent / 2 for v in n['center']], extent, *[v + extent / 2 for v in n['center']], 0)
    return data


folder = sys.argv[1] + '/'
for name, data in (('lod_tree.rad', rad()), ('lod_tree.spz', spz()), ('lod_tree.hier', hier(False)), ('lod_halves.hier', hier(True))):
    with open(folder + name, 'wb') as file:
        file.write(data)
