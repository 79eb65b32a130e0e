// SPDX-License-Identifier: MIT
#include "io/scene/writer.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <string>

#include "base/fail.h"
#include "io/bytes/byte_text.h"
#include "io/scene/gltf/gltf.h"
#include "io/scene/ply/ply.h"
#include "io/scene/sog/sog.h"
#include "io/scene/splat/splat.h"
#include "io/scene/spz/spz.h"
#include "io/scene/usd/usd.h"

namespace qs {
namespace {

std::string loss_of_antialiasing(const GaussianCloud& cloud) {
  return cloud.antialiased
             ? "the format cannot say that the scene was trained antialiased: draw it with "
               "--antialiased on"
             : "";
}

// A longer extension precedes its suffixes.
constexpr std::array kWriters = {
    WriterRow{"compressed.ply", ".compressed.ply", "PlayCanvas's layout, 16 bytes and SH", "RDF", 3,
              "11/10/11 bits of 256 Gaussians' box, SH in steps of 1/32 within -4..4",
              write_compressed_ply},
    WriterRow{"ply", ".ply", "INRIA's layout", "RDF", 3, "nothing", write_ply, true},
    WriterRow{"spz", ".spz", "version 3, which most programs read", "RUB", 3,
              "positions in 1/4096, ln of scales in 1/16, SH in 1/16 and 1/8 within -1..1",
              write_spz, false, loss_in_spz},
    WriterRow{"spz-v4", ".spz", "version 4, smaller and read in parallel", "RUB", 3, "as spz",
              write_spz_v4, false, loss_in_spz},
    WriterRow{"splat", ".splat", "antimatter15's rows, largest first", "RDF", 0,
              "SH; colour and opacity in 8 bits, rotation in 4 x 8", write_splat, false,
              loss_of_antialiasing},
    WriterRow{
        "sog", ".sog", "PlayCanvas, version 2 in a zip", "RDF", 3,
        "positions in 16 bits of their logarithm, rotations and opacity in 8; scales, colours "
        "and SH from tables",
        write_sog},
    WriterRow{"glb", ".glb", "KHR_gaussian_splatting, floats", "LUF", 3, "rounding of exp and log",
              write_glb, false, loss_of_antialiasing},
    WriterRow{"usda", ".usda", "OpenUSD's ParticleField3DGaussianSplat, text", "RUB", 3,
              "rounding of exp and log", write_usda, false, loss_of_antialiasing},
    WriterRow{"usdz", ".usdz", "the same text in a zip without compression", "RUB", 3, "as usda",
              write_usdz, false, loss_of_antialiasing},
};

const WriterRow& choose_writer(const std::filesystem::path& path, std::string_view format) {
  if (const WriterRow* found = find_writer(path, format)) return *found;
  std::string known;
  for (const WriterRow& row : kWriters)
    known +=
        fmt::format("{} {}", known.empty() ? "" : ",", format.empty() ? row.extension : row.name);
  if (format.empty())
    fail(ErrorKind::usage, "{}: cannot write '{}' files; writable are:{}", path.string(),
         path.extension().string(), known);
  fail(ErrorKind::usage, "{}: cannot write '{}'; writable are:{}", path.string(), format, known);
}

}  // namespace

std::span<const WriterRow> writers() { return kWriters; }

const WriterRow* find_writer(const std::filesystem::path& path, std::string_view format) {
  const std::string name = lower_case(path.filename().string());
  const auto found = std::ranges::find_if(kWriters, [&](const WriterRow& row) {
    return format.empty() ? name.ends_with(row.extension) : format == row.name;
  });
  return found == kWriters.end() ? nullptr : &*found;
}

const WriterRow& write_scene(const GaussianCloud& cloud, const std::filesystem::path& path,
                             ThreadPool& pool, const Progress& progress, std::string_view format) {
  const WriterRow& writer = choose_writer(path, format);
  if (cloud.empty()) fail(ErrorKind::usage, "{}: there is no Gaussian to write", path.string());
  writer.write(cloud, path, pool, progress);
  return writer;
}

void write_trained_scene(const GaussianCloud& cloud, const std::filesystem::path& path,
                         ThreadPool& pool) {
  write_trained_ply(cloud, path, pool);
}

bool is_trained_scene(const std::filesystem::path& path) { return is_trained_ply(path); }

}  // namespace qs
