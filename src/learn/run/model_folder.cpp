// SPDX-License-Identifier: MIT
#include "learn/run/model_folder.h"

#include <cstring>
#include <ostream>

#include <nlohmann/json.hpp>

#include "base/environment.h"
#include "base/fail.h"
#include "io/bytes/file_guard.h"
#include "io/bytes/json_text.h"
#include "io/bytes/replace_file.h"
#include "io/camera/cameras.h"
#include "io/scene/reader.h"
#include "io/scene/writer.h"
#include "learn/run/field_model.h"
#include "raster/scene/image.h"

namespace qs::train {
namespace {

using nlohmann::ordered_json;

// A string literal of Python, on one line.
std::string python_text(const std::string& text) {
  std::string literal = "'";
  for (const char c : text) {
    if (c == '\'' || c == '\\') literal += '\\';
    if (static_cast<unsigned char>(c) < ' ' || c == '\x7f') {
      literal += fmt::format("\\x{:02x}", static_cast<unsigned char>(c));
    } else {
      literal += c;
    }
  }
  return literal + "'";
}

// The published trainer's arguments, as Python prints them.
std::string cfg_args(const std::filesystem::path& folder, const TrainSettings& settings,
                     const DataSet& data) {
  return fmt::format(
      "Namespace(sh_degree={}, source_path={}, model_path={}, images={}, resolution=1, "
      "white_background={}, data_device='cpu', eval={})",
      settings.sh_degree, python_text(data.folder.string()), python_text(folder.string()),
      python_text(data.photographs.filename().string()), settings.white() ? "True" : "False",
      data.test.empty() ? "False" : "True");
}

void write_points(const std::vector<ScenePoint>& points, const std::filesystem::path& path) {
  write_file(path, [&](std::ostream& file) {
    file << "ply\nformat binary_little_endian 1.0\nelement vertex " << points.size() << '\n';
    for (const char* name : {"x", "y", "z", "nx", "ny", "nz"})
      file << "property float " << name << '\n';
    for (const char* name : {"red", "green", "blue"}) file << "property uchar " << name << '\n';
    file << "end_header\n";
    for (const ScenePoint& point : points) {
      char row[6 * sizeof(float) + 3] = {};  // the normal is 0
      const glm::vec3 position(point.position);
      std::memcpy(row, &position, sizeof position);
      for (int c = 0; c < 3; ++c)
        row[6 * sizeof(float) + static_cast<std::size_t>(c)] =
            static_cast<char>(to_8bit(point.color[c]));
      file.write(row, sizeof row);
    }
  });
}

ordered_json result_json(const CheckpointView& checkpoint, const DataSet& data,
                         const std::string& backend, int threads) {
  const Environment environment = read_environment();
  const ordered_json log = log_json(checkpoint.log);
  ordered_json result = {{"iteration", checkpoint.model.iteration},
                         {"gaussians", count_existing(checkpoint.model.parameters)},
                         {"seconds", checkpoint.log.seconds},
                         {"stage_seconds", log["stage_seconds"]},
                         {"evaluation_seconds", checkpoint.log.evaluation_seconds}};
  if (const auto bytes = most_gpu_memory(checkpoint.log)) result["gpu_memory_bytes"] = *bytes;
  for (const ordered_json& row : log["rows"]) {
    if (!row.contains("test_ssim")) continue;
    result["test_iteration"] = row["iteration"];
    result["test_psnr"] = row["test_psnr"];
    result["test_ssim"] = row["test_ssim"];
  }
  if (const LogRow* best = best_row(checkpoint.log)) result["best_iteration"] = best->iteration;
  return {{"settings", settings_json(checkpoint.settings)},
          {"data",
           {{"folder", data.folder.string()},
            {"photographs", data.photographs.string()},
            {"training_views", data.training.size()},
            {"test_views", data.test.size()},
            {"width", data.training.front().camera.width},
            {"height", data.training.front().camera.height},
            {"points", data.points.size()},
            {"fingerprint", checkpoint.data}}},
          {"environment",
           {{"version", environment.version},
            {"commit", environment.commit},
            {"build_type", environment.build_type},
            {"backend", backend},
            {"cpu", environment.cpu},
            {"threads", threads},
            {"utc", environment.utc}}},
          {"result", result},
          {"log", log["rows"]}};
}

}  // namespace

std::filesystem::path checkpoint_path(const std::filesystem::path& folder) {
  return folder / "checkpoint";
}

std::filesystem::path gaussians_path(const std::filesystem::path& folder, int iteration) {
  return folder / "point_cloud" / fmt::format("iteration_{}", iteration) / "point_cloud.ply";
}

void write_model_start(const std::filesystem::path& folder, const TrainSettings& settings,
                       const DataSet& data) {
  replace_folder(folder, [&](const std::filesystem::path& hidden) {
    write_text(hidden / "cameras.json", format_cameras(data.cameras()));
    write_text(hidden / "cfg_args", cfg_args(folder, settings, data));
    write_points(data.points, hidden / "input.ply");
  });
}

std::filesystem::path write_gaussians(const std::filesystem::path& folder,
                                      const TrainSettings& settings, const ModelState& model,
                                      ThreadPool& pool) {
  auto file = gaussians_path(folder, model.iteration);
  make_folder(file.parent_path());
  if (model.color_field.exists()) {
    write_field_model(model, file, pool);
  } else {
    write_trained_scene(to_cloud(model.parameters, settings.antialiased), file, pool);
  }
  return file;
}

OldIterations remove_old_iterations(const std::filesystem::path& folder) {
  OldIterations old;
  const std::filesystem::path place = folder / "point_cloud";
  std::vector<std::filesystem::path> own;
  for (const auto& [iteration, file] : find_iterations(place)) {
    const bool is_link = std::filesystem::is_symlink(file) ||
                         std::filesystem::is_symlink(file.parent_path()) ||
                         std::filesystem::is_symlink(place);
    const bool is_own = !is_link && is_trained_scene(file);
    (is_own ? old.removed : old.foreign).push_back(iteration);
    if (is_own) own.push_back(file);
  }
  for (const std::filesystem::path& file : own) check_target(file);
  for (const std::filesystem::path& file : own) {
    std::error_code error;
    if (!std::filesystem::remove(file, error) || error)
      fail("{}: cannot be removed: {}", file.string(), error.message());
    for (const auto& form : other_forms(file)) std::filesystem::remove(form, error);
    std::filesystem::remove(file.parent_path(), error);  // it may hold files of others
  }
  return old;
}

FolderLock lock_model_folder(const std::filesystem::path& folder) {
  return FolderLock(folder, "another process trains into this folder");
}

std::filesystem::path write_model_state(const std::filesystem::path& folder,
                                        const CheckpointView& checkpoint, const DataSet& data,
                                        const std::string& backend, ThreadPool& pool, bool last) {
  // The checkpoint is written first, because it needs no memory and everything else can be made
  // from it.
  if (!last) write_checkpoint(checkpoint, checkpoint_path(folder));
  auto file = write_gaussians(folder, checkpoint.settings, checkpoint.model, pool);
  if (checkpoint.model.color_field.exists() &&
      checkpoint.model.iteration >= checkpoint.settings.iterations)
    write_coded_models(checkpoint.model, checkpoint.settings.seed, file, pool);
  write_text(folder / "train.csv", format_train_csv(checkpoint.log));
  write_text(folder / "train.json",
             json_file_text(result_json(checkpoint, data, backend, pool.size())));
  if (last) remove_checkpoint(checkpoint_path(folder));
  return file;
}

}  // namespace qs::train
