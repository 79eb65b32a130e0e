# SPDX-License-Identifier: MIT
"""The ctypes layer is quadsplat.h: its structs, numbers and functions."""
import ctypes
import re

import pytest

from conftest import ROOT

HEADER = (ROOT / "src" / "quadsplat" / "quadsplat.h").read_text()


@pytest.fixture(scope="module")
def ffi(quadsplat):
    from quadsplat import _ffi

    return _ffi


def test_structs_have_the_members_and_offsets_of_the_header(ffi):
    bodies = dict(re.findall(r"typedef struct (\w+) \{(.*?)\n\} \1;", HEADER, re.S))
    for struct in ffi.STRUCT_BYTES:
        name = struct.__name__
        body = bodies[name]
        members = []
        for line in re.findall(r"^  (?!/\*)([^;\n(]+;\s*/\*[^*]+)", body, re.M):
            declared, comment = line.split(";", 1)
            names = re.findall(r"(\w+)(?:\[\w+\])?(?=,|$)", declared)
            offsets = re.match(r"\s*/\*\s*([\d, ]+)", comment).group(1)
            members += zip(names, map(int, re.findall(r"\d+", offsets)))
        members += [(member, int(offset)) for offset, member in re.findall(
            r"/\* (\d+): (?:(?!\*/).)*\*/\s+\w+\*? \(\*(\w+)\)\(", body, re.S)]  # callbacks
        assert [member for member, *_ in struct._fields_] == [member for member, _ in members], name
        for member, offset in members:
            assert getattr(struct, member).offset == offset, (name, member)
        assert ctypes.sizeof(struct) == ffi.STRUCT_BYTES[struct]


def test_sizes_are_those_of_the_header(ffi):
    found = {}
    for comment, name in re.findall(r"/\*((?:[^*]|\*(?!/))*)\*/\ntypedef struct (\w+) \{", HEADER):
        found[name] = int(re.findall(r"(\d+)[\s*]+bytes", comment)[-1])
    known = {struct.__name__: size for struct, size in ffi.STRUCT_BYTES.items()}
    assert known == {name: found[name] for name in known}


def test_functions_have_the_parameters_of_the_header(ffi):
    declared = dict(re.findall(r"QS_LIBRARY_FUNCTION\s+[^(]*?\b(qs_\w+)\(([^;]*)\);", HEADER))
    for name in [*ffi.FUNCTIONS, *ffi.PLAIN_FUNCTIONS]:
        parameters = declared[name]
        count = parameters.count(",") + 1
        if name in ffi.FUNCTIONS:
            assert re.search(r"char\* message$", parameters) and len(ffi.FUNCTIONS[name]) == count - 1
        else:
            assert len(ffi.PLAIN_FUNCTIONS[name][1]) == count, name


def test_numbers_are_those_of_the_header(ffi, quadsplat):
    numbers = {name: int(value) for name, value in
               re.findall(r"^#define QS_(\w+) \(?(-?\d+)u?\)?(?:\s|$)", HEADER, re.M)}
    expected = {"LIBRARY_VERSION": ffi.LIBRARY_VERSION, "MESSAGE_BYTES": ffi.MESSAGE_BYTES,
                "MEMORY_HOST": ffi.MEMORY_HOST, "FIRST_GPU": ffi.FIRST_GPU,
                "COLORS_SH": ffi.COLORS_SH, "COLORS_RGB": ffi.COLORS_RGB,
                "ANTIALIASED_AS_TRAINED": ffi.ANTIALIASED[None],
                "ANTIALIASED_ON": ffi.ANTIALIASED[True], "ANTIALIASED_OFF": ffi.ANTIALIASED[False]}
    for name in ("FLOAT32", "FLOAT64", "UINT8", "INT32", "UINT32", "INT64", "UINT64"):
        expected[name] = getattr(ffi, name)
    for prefix, table in [("BACKEND", ffi.BACKENDS), ("PIPELINE", ffi.PIPELINES),
                          ("METRIC", ffi.METRICS), ("BORDER", ffi.BORDERS), ("RADII", ffi.RADII)]:
        expected.update({f"{prefix}_{word.upper()}": number for word, number in table.items()})
    expected.update({f"STAGE_{name.upper()}": i for i, name in enumerate(ffi.STAGES)})
    assert expected == {name: numbers[name] for name in expected}
    from quadsplat._errors import OF_RESULT

    assert OF_RESULT == {numbers["USAGE"]: quadsplat.UsageError, numbers["INPUT"]: quadsplat.InputError,
                         numbers["DEVICE"]: quadsplat.DeviceError,
                         numbers["CANCELLED"]: quadsplat.Cancelled}


def test_usual_settings_are_those_of_the_header(ffi, quadsplat):
    from quadsplat import _settings

    struct = _settings.struct_of("test", {}, False)
    usual = re.search(r"#define QS_SETTINGS(.*?)\n\n", HEADER, re.S).group(1).replace("\\", "")
    pipeline, background, scale, dilation = re.search(
        r"(QS_PIPELINE_\w+), 0, \{([^}]*)\}, ([\d.]+), ([\d.]+)", usual).groups()
    assert pipeline == "QS_PIPELINE_FAST" and struct.pipeline == ffi.PIPELINES["fast"]
    assert list(struct.background) == [float(value) for value in background.split(",")]
    assert (struct.splat_scale, struct.dilation_px2) == (float(scale), float(dilation))
    assert "QS_ALL_SH_DEGREES" in usual and struct.sh_degree == 3 and struct.tile_px == 16
    assert struct.antialiased == 0 and struct.cull == b"quadbox"


def test_a_library_that_does_not_fit_is_refused_on_import(python, tmp_path):
    code = """
try:
    import quadsplat
    print("imported")
except ImportError as error:
    print(error)
"""
    missing = python(code, QUADSPLAT_LIBRARY=str(tmp_path / "none.so"))
    assert missing.startswith(f"quadsplat: the library {tmp_path}/none.so cannot be loaded: ")
    assert "is too old for this package: " in python(code, QUADSPLAT_LIBRARY="libm.so.6")
    version = python(f"""
import ctypes
real = ctypes.CDLL
class Newer:
    def __init__(self, path):
        self.library = real(path)
    def __getattr__(self, name):
        if name == "qs_version":
            return lambda text: 99
        return getattr(self.library, name)
ctypes.CDLL = Newer
{code}""")
    assert "has version 99 of the interface, but this package needs version 1" in version
    bytes_of = python(f"""
import ctypes
real = ctypes.sizeof
ctypes.sizeof = lambda struct: real(struct) + (getattr(struct, "__name__", "") == "QsCamera")
{code}""")
    assert "QsCamera has 321 bytes on this machine instead of 320" in bytes_of
