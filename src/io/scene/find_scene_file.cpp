// SPDX-License-Identifier: MIT
//
// Finds the scene file for a path. A training run writes
// MODEL/point_cloud/iteration_N/point_cloud.ply; the path may be the model, its point_cloud folder
// or one iteration's folder. Compact-3DGS may leave point_cloud.npz there instead.
#include <algorithm>
#include <array>
#include <charconv>
#include <optional>
#include <string_view>
#include <system_error>

#include "base/fail.h"
#include "io/scene/reader.h"

namespace qs {
namespace {

constexpr const char* kSceneFile = "point_cloud.ply";
constexpr std::array kSceneFiles = {kSceneFile, "point_cloud.npz", "point_cloud_pp.npz"};

bool is_file(const std::filesystem::path& path) {
  std::error_code error;
  return std::filesystem::is_regular_file(path, error);
}

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

}  // namespace

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
  if (iterations.empty()) {
    if (const auto file = scene_file_in(path)) return *file;
    if (is_file(path / "meta.json")) return path / "meta.json";
    if (is_file(path / "lod-meta.json")) return path / "lod-meta.json";
    fail("{}: a folder without point_cloud/iteration_*/{}; give a model folder or a splat file",
         path.string(), kSceneFile);
  }
  if (iteration < 0) return iterations.rbegin()->second;
  if (const auto chosen = iterations.find(iteration); chosen != iterations.end()) {
    return chosen->second;
  }
  std::string list;
  for (const auto& [number, file] : iterations) list += fmt::format(" {}", number);
  fail("{}: has no iteration {}; there are:{}", path.string(), iteration, list);
}

}  // namespace qs
