// SPDX-License-Identifier: MIT
#include "io/reader.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <new>

#include "io/compressed_ply.h"
#include "io/inflate.h"
#include "io/mapped_file.h"
#include "io/ply.h"
#include "io/spz.h"
#include "raster/scene/fail.h"

namespace qs {
namespace {

constexpr std::array kReaders = {
    ReaderRow{"ply", ".ply", "as trained: INRIA, gsplat, Brush, PlayCanvas, 2DGS, ...",
              recognises_ply, read_ply},
    ReaderRow{"compressed.ply", ".compressed.ply .ply", "PlayCanvas, SuperSplat, gsplat",
              recognises_compressed_ply, read_compressed_ply},
    ReaderRow{"spz", ".spz", "Niantic, versions 1 to 4", recognises_spz, read_spz},
};

// Formats that are known but have no reader, for a helpful sentence. A magic is optional.
struct KnownFormat {
  std::string_view name, extension, magic;
};
constexpr std::array kKnownFormats = {
    KnownFormat{".splat (antimatter15)", ".splat", ""},
    KnownFormat{".ksplat (GaussianSplats3D)", ".ksplat", ""},
    KnownFormat{"SOG (PlayCanvas)", ".sog", "PK\x03\x04"},
    KnownFormat{"SOG (PlayCanvas)", "meta.json", ""},
    KnownFormat{"binary glTF", ".glb", "glTF"},
    KnownFormat{"glTF", ".gltf", ""},
};

bool starts_with(std::span<const std::byte> content, std::string_view magic) {
  const std::string_view text(reinterpret_cast<const char*>(content.data()), content.size());
  return !magic.empty() && text.starts_with(magic);
}

bool name_ends_with(const std::filesystem::path& path, std::string_view extension) {
  std::string name = path.filename().string();
  std::transform(name.begin(), name.end(), name.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return name.ends_with(extension);
}

bool has_extension_of(const ReaderRow& row, const std::filesystem::path& path) {
  std::string_view rest = row.extensions;
  while (!rest.empty()) {
    const std::size_t end = std::min(rest.find(' '), rest.size());
    if (name_ends_with(path, rest.substr(0, end))) return true;
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  return false;
}

[[noreturn]] void refuse(const std::string& path, std::string_view format) {
  std::string readable;
  for (const ReaderRow& row : kReaders) readable += fmt::format(" {}", row.name);
  if (format.empty()) fail("{}: unknown format; readable are:{}", path, readable);
  fail("{}: {} cannot be read yet; readable are:{}", path, format, readable);
}

// Content decides; of several rows that recognise it, one with the file's extension. A file that
// nobody recognises goes to the reader of its extension, which says what is wrong.
const ReaderRow& choose_reader(std::span<const std::byte> content,
                               const std::filesystem::path& path) {
  const ReaderRow* chosen = nullptr;
  for (const ReaderRow& row : kReaders) {
    if (!row.recognises(content, path)) continue;
    if (chosen == nullptr || has_extension_of(row, path)) chosen = &row;
  }
  if (chosen != nullptr) return *chosen;
  for (const KnownFormat& format : kKnownFormats) {
    if (starts_with(content, format.magic)) refuse(path.string(), format.name);
  }
  if (is_gzip(content)) fail("{}: gzip data; unpack it first", path.string());
  for (const ReaderRow& row : kReaders) {
    if (has_extension_of(row, path)) return row;
  }
  for (const KnownFormat& format : kKnownFormats) {
    if (name_ends_with(path, format.extension)) refuse(path.string(), format.name);
  }
  refuse(path.string(), "");
}

}  // namespace

std::span<const ReaderRow> readers() { return kReaders; }

Scene read_scene(const std::filesystem::path& path, const ReadOptions& options) {
  Scene scene;
  scene.path = find_scene_file(path, options.iteration);
  const MappedFile file(scene.path);
  scene.file_bytes = file.content().size();
  if (file.content().empty()) fail("{}: the file is empty", scene.path.string());
  const ReaderRow& reader = choose_reader(file.content(), scene.path);
  options.progress.update(0);
  try {
    reader.read(file.content(), scene.path, options, scene);
  } catch (const std::bad_alloc&) {
    fail(ErrorKind::device, "{}: not enough memory for this scene", scene.path.string());
  }
  options.progress.update(1);
  return scene;
}

}  // namespace qs
