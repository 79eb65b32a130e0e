// SPDX-License-Identifier: MIT
#include "io/scene/reader.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <chrono>
#include <fstream>
#include <new>
#include <optional>
#include <sstream>
#include <string_view>
#include <system_error>

#include "base/error.h"
#include "base/fail.h"
#include "base/path_kind.h"
#include "base/seconds.h"
#include "base/text.h"
#include "io/bytes/byte_text.h"
#include "io/bytes/inflate.h"
#include "io/bytes/mapped_file.h"
#include "io/cloud/axes.h"
#include "io/cloud/cloud_memory.h"
#include "io/cloud/scene.h"
#include "io/scene/compact/compact.h"
#include "io/scene/gltf/gltf.h"
#include "io/scene/hier/hier.h"
#include "io/scene/instances.h"
#include "io/scene/ply/ply.h"
#include "io/scene/rad/rad.h"
#include "io/scene/rad/rad_pages.h"
#include "io/scene/sog/sog.h"
#include "io/scene/splat/splat.h"
#include "io/scene/spz/spz.h"
#include "io/scene/usd/usd.h"
#include "raster/pages/page_stream.h"
#include "raster/scene/cloud_order.h"
#include "raster/scene/place.h"
#include "raster/scene/transform.h"

namespace qs {

namespace {

constexpr std::array kReaders = {
    ReaderRow{"ply", ".ply", "as trained: INRIA, gsplat, Brush, PlayCanvas, 2DGS, ...", "RDF",
              "0-4", "ascii and both byte orders; lists only outside of the vertices",
              recognises_ply, read_ply},
    ReaderRow{"compressed.ply", ".compressed.ply .ply", "PlayCanvas, SuperSplat, gsplat", "RDF",
              "0-4", "SH values within -4..4", recognises_compressed_ply, read_compressed_ply},
    ReaderRow{"zipped ply", ".zip", "one .ply in a zip archive", "RDF", "0-4",
              "at most 16 times its size and 8 MiB unpacked", recognises_zipped_ply,
              read_zipped_ply},
    ReaderRow{"compact-3dgs", ".ply .npz", "Compact-3DGS: .ply with .pth beside it, .npz, _pp.npz",
              "RDF", "3, fitted", "colours of the network only with --exact-color",
              recognises_compact, read_compact},
    ReaderRow{"spz", ".spz", "Niantic, versions 1 to 4", "RUB, or as its extension says", "0-4",
              "leaves of Spark's trees of levels; at most 1032 times its size unpacked",
              recognises_spz, read_spz},
    ReaderRow{"splat", ".splat", "antimatter15", "RDF", "0", "opacity and colour in 8 bits",
              recognises_splat, read_splat},
    ReaderRow{"ksplat", ".ksplat", "GaussianSplats3D, version 0.1, levels 0 to 2", "RDF", "0-2",
              "opacity and colour in 8 bits", recognises_ksplat, read_ksplat},
    ReaderRow{"streamed sog", "lod-meta.json", "PlayCanvas, finest level and environment", "RDF",
              "0-3", "folders only; as sog", recognises_streamed_sog, read_streamed_sog},
    ReaderRow{"sog", ".sog .sogs .zip meta.json", "PlayCanvas, versions 1 and 2, zip or folder",
              "RDF", "0-3", "lossless WebP only; at most 8 Gaussians per byte", recognises_sog,
              read_sog},
    ReaderRow{"gltf", ".glb .gltf", "KHR_gaussian_splatting, also its draft and compressed as spz",
              "LUF", "0-4", "buffers inside, in base64 or in its folder", recognises_gltf,
              read_gltf},
    ReaderRow{"rad", ".rad .radc", "Spark's levels of detail: their leaves", "RDF", "0-3",
              "version 1; at most 8 nodes per byte", recognises_rad, read_rad},
    ReaderRow{"hier", ".hier", "hierarchical-3d-gaussians, floats or halves: its leaves", "RDF",
              "3", "no sky box and exposures, which are other files", recognises_hier, read_hier},
    ReaderRow{"instances", ".instances.json", "similarity transforms of a scene beside it", "RDF",
              "as the scene's", "as many Gaussians as half of the memory holds",
              recognises_instances, read_instances},
    ReaderRow{"usd", ".usda .usdz .usd .usdc", "OpenUSD's ParticleField3DGaussianSplat, text",
              "RUB, or RFU with Z up", "0-4", "no .usdc; no references, variants and time samples",
              recognises_usd, read_usd},
};

bool has_extension_of(const ReaderRow& row, const std::filesystem::path& path) {
  const std::string name = lower_case(path.filename().string());
  std::istringstream extensions(row.extensions);
  for (std::string extension; extensions >> extension;)
    if (name.ends_with(extension)) return true;
  return false;
}

// Chooses by content; if several rows recognise the content, the row with the file's extension. If
// no row does, it chooses the reader of the extension, whose message names the defect.
const ReaderRow& choose_reader(ByteSpan content, const std::filesystem::path& path) {
  const ReaderRow* chosen = nullptr;
  for (const ReaderRow& row : kReaders) {
    if (!row.recognises(content, path)) continue;
    if (chosen == nullptr || has_extension_of(row, path)) chosen = &row;
  }
  if (chosen != nullptr) return *chosen;
  if (is_gzip(content)) fail("{}: gzip data; unpack it first", path.string());
  std::string readable;
  for (const ReaderRow& row : kReaders) {
    if (has_extension_of(row, path)) return row;
    readable += fmt::format("{} {}", readable.empty() ? "" : ",", row.name);
  }
  fail("{}: unknown format; readable are:{}", path.string(), readable);
}

constexpr const char* kSceneFile = "point_cloud.ply";
constexpr std::array kSceneFiles = {kSceneFile, "point_cloud.npz", "point_cloud_pp.npz"};
constexpr const char* kFinishOfLiteGs = "finish";  // its last model, in place of iteration_N

// The first of kSceneFiles in a folder.
std::optional<std::filesystem::path> scene_file_in(const std::filesystem::path& folder) {
  for (const char* name : kSceneFiles)
    if (is_file(folder / name)) return folder / name;
  return std::nullopt;
}

// N of "iteration_N".
std::optional<int> iteration_of(const std::string& name) {
  constexpr std::string_view kPrefix = "iteration_";
  if (!name.starts_with(kPrefix)) return std::nullopt;
  int iteration = 0;
  const char* const end = name.data() + name.size();
  const auto [stop, error] = std::from_chars(name.data() + kPrefix.size(), end, iteration);
  if (error != std::errc() || stop != end) return std::nullopt;
  return iteration;
}

// Opens a tree as Scene::stream. False if the file is to be read whole.
bool stream_tree(const ReadOptions& options, ThreadPool& pool, Scene& scene) {
  if (options.streams == StreamedTrees::none || !is_rad_file(scene.path)) return false;
  const auto file = std::make_shared<const RadPages>(scene.path);
  const RadHeader& header = file->header();
  if (!header.has_tree || !is_streamed(options, header.count)) return false;
  LodPage first = file->read(0);
  if (!options.keeps_place) move_near_origin(first.cloud);
  const auto placed = [axes = options.axes, origin = first.cloud.origin](LodPage page) {
    Scene part;
    part.cloud = std::move(page.cloud);
    place(part.cloud, origin);
    if (!axes.empty()) assume_axes(part, axes);
    page.cloud = std::move(part.cloud);
    return page;
  };
  LodPages tree{header.count, header.chunk_nodes, header.footprint};
  tree.pages.resize(header.chunks.size());
  tree.pages[0] = std::make_shared<const LodPage>(placed(std::move(first)));
  scene.format = "rad";
  scene.file_bytes = file->file_bytes();
  PageSource source{scene.path.string(),
                    [file, placed](std::size_t i) {
                      return std::make_shared<const LodPage>(placed(file->read(i)));
                    },
                    [file] { return file->is_unchanged(); }};
  for (const RadHeader::Range& chunk : header.chunks) source.stored_bytes.push_back(chunk.bytes);
  set_stream(std::move(tree), std::move(source), options, pool, scene);
  return true;
}

}  // namespace

std::span<const ReaderRow> readers() { return kReaders; }

bool is_streamed(const ReadOptions& options, std::uint64_t nodes) {
  constexpr std::uint64_t kNodeBytes = 300;  // of memory
  return options.streams == StreamedTrees::all ||
         (options.streams == StreamedTrees::large && nodes * kNodeBytes >= available_memory() / 2);
}

void set_stream(LodPages tree, PageSource source, const ReadOptions& options, ThreadPool& pool,
                Scene& scene) {
  std::vector<std::uint32_t> finest;
  cut_of(
      tree, [](const LodPage&, std::size_t) { return 1.0f; }, {}, pool)
      .parts[0]
      .for_each([&](std::size_t row) { finest.push_back(static_cast<std::uint32_t>(row)); });
  scene.cloud = select(tree.pages[0]->cloud, finest);
  if (!options.axes.empty()) scene.axes = options.axes;
  scene.levels = {0, tree.count, 0, 0, tree.footprint > 0, !tree.pages[0]->numbers.empty()};
  const std::uint64_t memory = available_memory() / 2;
  scene.stream = std::make_shared<PageStream>(
      std::move(tree), std::move(source),
      options.page_memory > 0 ? std::min(options.page_memory, memory) : memory);
}

void assume_axes(Scene& scene, std::string_view axes) {
  if (!is_axes(axes))
    fail(ErrorKind::usage,
         "axes: '{}' is no right-handed frame of three letters for x, y, z: R or L, D or U, B or F",
         axes);
  const glm::dmat3 turn = rdf_from(axes) * glm::inverse(rdf_from(scene.axes));
  const AxisSigns signs{static_cast<float>(turn[0].x), static_cast<float>(turn[1].y),
                        static_cast<float>(turn[2].z)};
  if (signs.x * signs.y * signs.z != 0) {  // the axes are parallel
    flip_axes(scene.cloud, 0, scene.cloud.size(), signs);
  } else {
    const Transform transform((glm::dmat4(turn)));
    for (std::size_t i = 0; i < scene.cloud.size(); ++i) transform.apply(scene.cloud, i);
  }
  scene.cloud.origin = turn * scene.cloud.origin;
  // The file's vertical axis belongs to the frame that it declares.
  if (scene.axes != axes) scene.vertical_axis.clear();
  scene.axes = axes;
}

Scene read_scene(const std::filesystem::path& path, ThreadPool& pool, const ReadOptions& given) {
  bool sampled = false;
  ReadOptions options = given;
  if (given.sampling.take)
    options.sampling.take = [&](SceneSample sample) {
      sampled = true;
      if (!options.keeps_place && sample.scene.cloud.origin == glm::dvec3(0))
        move_near_origin(sample.scene.cloud);
      sample.scene.declared_axes = sample.scene.axes;
      if (!options.axes.empty()) assume_axes(sample.scene, options.axes);
      given.sampling.take(std::move(sample));
    };
  Scene scene;
  scene.path = find_scene_file(path, options.iteration);
  if (stream_tree(options, pool, scene)) return scene;
  if (options.streams == StreamedTrees::all)
    scene.warn("It has no tree of levels of detail, so it is drawn whole.");
  const MappedFile file(scene.path);
  scene.file_bytes = file.content().size();
  if (file.content().empty()) fail("{}: the file is empty", scene.path.string());
  const ReaderRow& reader = choose_reader(file.content(), scene.path);
  options.progress.update(0);
  const auto start = std::chrono::steady_clock::now();
  try {
    reader.read(file.content(), scene.path, pool, options, scene);
  } catch (const std::bad_alloc&) {
    fail(ErrorKind::device, "{}: not enough memory for this scene", scene.path.string());
  }
  scene.unpack_ms = milliseconds_since(start) - scene.fill_ms;
  scene.declared_axes = scene.axes;
  // A network knows the positions of its file.
  if (!options.keeps_place && !scene.network) move_near_origin(scene.cloud);
  if (!options.axes.empty()) assume_axes(scene, options.axes);
  if (!sampled && is_sampled(scene.cloud.size(), options.sampling))
    given.sampling.take(sample_of(scene, options.sampling));
  options.progress.update(1);
  return scene;
}

// A training run writes MODEL/point_cloud/iteration_N/point_cloud.ply; the path may be the model,
// its point_cloud folder or one iteration's folder. Compact-3DGS may leave point_cloud.npz there
// instead.
std::map<int, std::filesystem::path> find_iterations(const std::filesystem::path& folder) {
  std::map<int, std::filesystem::path> found;
  std::error_code error;
  for (std::filesystem::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    const auto iteration = iteration_of(entry->path().filename().string());
    if (!iteration) continue;
    if (const auto file = scene_file_in(entry->path())) found.emplace(*iteration, *file);
  }
  return found;
}

std::filesystem::path find_scene_file(const std::filesystem::path& path, int iteration) {
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  if (!std::filesystem::exists(status)) {
    const bool missing = !error || error == std::errc::no_such_file_or_directory;
    const bool through_file = error == std::errc::not_a_directory;
    fail("{}: {}", path.string(),
         missing        ? "does not exist"
         : through_file ? "is a file, but its name is written as a folder's"
                        : error.message());
  }
  if (!std::filesystem::is_directory(status)) return path;

  auto iterations = find_iterations(path / "point_cloud");
  if (iterations.empty()) iterations = find_iterations(path);
  auto finish = scene_file_in(path / "point_cloud" / kFinishOfLiteGs);
  if (!finish) finish = scene_file_in(path / kFinishOfLiteGs);
  if (iteration < 0 && finish) return *finish;
  if (iterations.empty()) {
    if (const auto file = scene_file_in(path)) return *file;
    if (is_file(path / "meta.json")) return path / "meta.json";
    if (is_file(path / "lod-meta.json")) return path / "lod-meta.json";
    fail("{}: a folder without point_cloud/iteration_*/{}; give a model folder or a splat file",
         path.string(), kSceneFile);
  }
  if (iteration < 0) return iterations.rbegin()->second;
  if (const auto chosen = iterations.find(iteration); chosen != iterations.end())
    return chosen->second;
  std::string list;
  for (const auto& [number, file] : iterations) list += fmt::format(" {}", number);
  fail("{}: has no iteration {}; there are:{}", path.string(), iteration, list);
}

bool reads_ending(const std::string& ending) {
  const auto has = [&](const ReaderRow& row) {
    return std::ranges::count(separated(row.extensions, ' '), ending) > 0;
  };
  return std::ranges::any_of(readers(), has);
}

bool holds_scene(const std::filesystem::path& path) try {
  find_scene_file(path);
  return true;
} catch (const Error&) {
  return false;
}

}  // namespace qs
