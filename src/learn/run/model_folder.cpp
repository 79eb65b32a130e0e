// SPDX-License-Identifier: MIT
#include "learn/run/model_folder.h"

#include <cstring>
#include <fstream>
#include <ostream>
#include <span>

#include <nlohmann/json.hpp>

#include "base/environment.h"
#include "base/fail.h"
#include "io/bytes/byte_cursor.h"
#include "io/bytes/file_guard.h"
#include "io/bytes/json_text.h"
#include "io/bytes/json_value.h"
#include "io/bytes/mapped_file.h"
#include "io/bytes/replace_file.h"
#include "io/camera/cameras.h"
#include "io/scene/reader.h"
#include "io/scene/writer.h"
#include "learn/run/field_model.h"
#include "learn/run/hash.h"
#include "raster/scene/image.h"
#include "raster/scene/place.h"

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

void write_points(const std::vector<ScenePoint>& points, const glm::dvec3& origin,
                  const std::filesystem::path& path) {
  write_file(path, [&](std::ostream& file) {
    file << "ply\nformat binary_little_endian 1.0\nelement vertex " << points.size() << '\n';
    for (const char* name : {"x", "y", "z", "nx", "ny", "nz"})
      file << "property float " << name << '\n';
    for (const char* name : {"red", "green", "blue"}) file << "property uchar " << name << '\n';
    if (origin != glm::dvec3(0)) file << "comment offset " << format_origin(origin) << '\n';
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
  for (const char* name : {"guard", "verdict", "pace"})
    if (log.contains(name)) result[name] = log[name];
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
            {"origin", {data.origin.x, data.origin.y, data.origin.z}},
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

constexpr std::string_view kMagic = "QSTRAIN6";
constexpr std::size_t kMaxTrainJson = std::size_t{1} << 28;

// Calls visit(array) for every array of the state, which all have their sizes.
template <class State, class Visit>
void for_each_stored(State& state, const Visit& visit) {
  for (auto* parameters : {&state.parameters, &state.adam.first, &state.adam.second, &state.summed})
    for_each_array([&](std::size_t, auto& array) { visit(array); }, *parameters);
  visit(state.density.sums);
  visit(state.density.views);
  visit(state.density.absolute);
  visit(state.color_field.field.grid_values);
  visit(state.color_field.field.weights);
  visit(state.color_field.first);
  visit(state.color_field.second);
  for (auto* codes : {&state.codes.scales, &state.codes.rotations}) {
    visit(codes->codebook.values);
    visit(codes->first);
    visit(codes->second);
  }
}

class HashedStream {
 public:
  explicit HashedStream(std::ostream& stream) : stream_(stream) {}

  void write(const void* data, std::size_t bytes) {
    hash_ = hash_of({static_cast<const std::byte*>(data), bytes}, hash_);
    stream_.write(static_cast<const char*>(data), static_cast<std::streamsize>(bytes));
  }
  std::uint64_t hash() const { return hash_; }

 private:
  std::ostream& stream_;
  std::uint64_t hash_ = hash_of({});
};

// A state with arrays for `gaussians` Gaussians and the kinds of arrays of `kind`, which has none.
// The size of the arrays is first compared with the remaining bytes.
ModelState sized_state(std::uint64_t gaussians, const Parameters& kind, bool absolute, bool sums,
                       std::uint64_t left, const std::string& where) {
  const std::uint64_t values =
      (sums ? 4 : 3) * (11 + (kind.has_masks ? 1 : 0) + 3 * std::uint64_t{kind.sh_stride()}) +
      (absolute ? 3 : 2);
  if (!fits(gaussians, 4 * values, left))
    fail("{}: cut off: {} Gaussians do not fit into {} bytes", where, gaussians, left);
  Parameters parameters;
  parameters.resize_like(kind);
  parameters.resize(gaussians);
  ModelState sized = ModelState::starting_with(std::move(parameters));
  if (absolute) sized.density.absolute.resize(gaussians);
  sized.summed.resize_like(kind);
  if (sums) sized.summed.resize(gaussians);
  return sized;
}

ordered_json field_json(const FieldState& state) {
  if (!state.exists()) return nullptr;
  const GridShape& grid = state.field.grid;
  return {{"levels", grid.levels}, {"log2_entries", grid.log2_entries}, {"base", grid.base},
          {"growth", grid.growth}, {"width", state.field.width},        {"steps", state.steps}};
}

// Null without codes.
ordered_json code_steps(const ShapeCodes& codes) {
  if (!codes.exist()) return nullptr;
  return codes.scales.steps;
}

ShapeCodes sized_codes(const ordered_json& json) {
  ShapeCodes codes;
  if (json.is_null()) return codes;
  const auto sized = [&](std::size_t dimensions) {
    ResidualCodebook book;
    book.dimensions = dimensions;
    book.values.resize(book.value_count());
    CodeState state = CodeState::starting_with(std::move(book));
    json_value(json, state.steps);
    return state;
  };
  return {sized(3), sized(4)};
}

// Allocates the arrays of a colour field after their size was compared with the remaining bytes.
FieldState sized_field(const ordered_json& json, std::uint64_t left, const std::string& where) {
  FieldState state;
  if (json.is_null()) return state;
  ColorField field;
  json_value(json.at("levels"), field.grid.levels);
  json_value(json.at("log2_entries"), field.grid.log2_entries);
  json_value(json.at("base"), field.grid.base);
  json_value(json.at("growth"), field.grid.growth);
  json_value(json.at("width"), field.width);
  const GridShape& grid = field.grid;
  const bool known = grid.levels >= 1 && grid.levels <= 16 && grid.log2_entries >= 3 &&
                     grid.log2_entries <= 24 && grid.base >= 1 && grid.base <= 1024 &&
                     grid.growth >= 1 && grid.growth <= 2 && field.width >= 16 &&
                     field.width <= 64 && field.width % 16 == 0;
  const std::uint64_t values = known ? grid_value_count(grid) + field.network().weight_count() : 0;
  if (!known || !fits(values, 3 * sizeof(float), left))
    fail("{}: is damaged: a colour field of another size", where);
  field.grid_values.resize(grid_value_count(grid));
  field.weights.resize(field.network().weight_count());
  state = FieldState::starting_with(std::move(field));
  json_value(json.at("steps"), state.steps);
  return state;
}

}  // namespace

void write_checkpoint(const CheckpointView& checkpoint, const std::filesystem::path& path) {
  const ModelState& model = checkpoint.model;
  const std::string header = json_line({{"settings", settings_json(checkpoint.settings)},
                                        {"data", checkpoint.data},
                                        {"log", log_json(checkpoint.log)},
                                        {"iteration", model.iteration},
                                        {"changed_before", model.changed_before},
                                        {"gaussians", model.size()},
                                        {"sh_degree", model.parameters.sh_degree},
                                        {"masks", model.parameters.has_masks},
                                        {"color_field", field_json(model.color_field)},
                                        {"code_steps", code_steps(model.codes)},
                                        {"absolute", !model.density.absolute.empty()},
                                        {"sums", model.summed.size() > 0},
                                        {"growth_initial", model.growth.initial},
                                        {"growth_budget", model.growth.budget},
                                        {"adam_steps", model.adam.steps},
                                        {"adam_rest_steps", model.adam.rest_steps}});
  write_file(path, [&](std::ostream& file) {
    HashedStream stream(file);
    const std::uint64_t bytes = header.size();
    stream.write(kMagic.data(), kMagic.size());
    stream.write(&bytes, sizeof bytes);
    stream.write(header.data(), header.size());
    for_each_stored(model, [&](const auto& array) {
      stream.write(array.data(), array.size() * sizeof array[0]);
    });
    const std::uint64_t hash = stream.hash();
    file.write(reinterpret_cast<const char*>(&hash), sizeof hash);
  });
}

void remove_checkpoint(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::string magic(kMagic.size(), '\0');
  if (!file.read(magic.data(), static_cast<std::streamsize>(magic.size())) || magic != kMagic)
    return;
  std::error_code error;
  if (!std::filesystem::remove(path, error) && error)
    fail("{}: cannot be removed: {}", path.string(), error.message());
}

Checkpoint read_checkpoint(const std::filesystem::path& path) {
  const std::string where = path.string();
  const MappedFile file(path);
  note_own(path);  // the run that continues replaces it
  const auto content = file.content();
  ByteCursor cursor(content, where);
  const auto magic = cursor.take(kMagic.size(), "the first bytes");
  if (std::memcmp(magic.data(), kMagic.data(), kMagic.size()) != 0)
    fail("{}: is no checkpoint of this version of quadsplat train", where);
  const auto header_bytes = cursor.read<std::uint64_t>("the header's size");
  const auto header = cursor.take(header_bytes, "the header");
  Checkpoint checkpoint;
  ModelState& model = checkpoint.model;
  try {
    const ordered_json json = parse_own_json(
        {reinterpret_cast<const char*>(header.data()), static_cast<std::size_t>(header.size())});
    checkpoint.settings = settings_of(json.at("settings"));
    checkpoint.data = json.at("data").get<std::string>();
    checkpoint.log = log_of(json.at("log"));
    const auto degree = json_value<int>(json.at("sh_degree"));
    if (degree < 0 || degree > kMaxShDegree) fail("{}: SH degree {}", where, degree);
    Parameters kind;
    kind.sh_degree = degree;
    kind.has_masks = json_value<bool>(json.at("masks"));
    model = sized_state(json_value<std::uint64_t>(json.at("gaussians")), kind,
                        json_value<bool>(json.at("absolute")), json_value<bool>(json.at("sums")),
                        cursor.left(), where);
    json_value(json.at("iteration"), model.iteration);
    json_value(json.at("changed_before"), model.changed_before);
    json_value(json.at("adam_steps"), model.adam.steps);
    json_value(json.at("adam_rest_steps"), model.adam.rest_steps);
    json_value(json.at("growth_initial"), model.growth.initial);
    json_value(json.at("growth_budget"), model.growth.budget);
    model.codes = sized_codes(json.at("code_steps"));
    model.color_field = sized_field(json.at("color_field"), cursor.left(), where);
  } catch (const nlohmann::json::exception& error) {
    fail("{}: its header is damaged: {}", where, error.what());
  }
  for_each_stored(model, [&](auto& array) {
    const std::size_t bytes = array.size() * sizeof array[0];
    const auto stored = cursor.take(bytes, "an array");
    if (bytes > 0) std::memcpy(static_cast<void*>(array.data()), stored.data(), bytes);
  });
  const std::uint64_t expected = hash_of(content.first(cursor.offset()));
  if (cursor.read<std::uint64_t>("the hash") != expected)
    fail("{}: is damaged: its hash does not match", where);
  return checkpoint;
}

std::filesystem::path checkpoint_path(const std::filesystem::path& folder) {
  return folder / "checkpoint";
}

std::filesystem::path gaussians_path(const std::filesystem::path& folder, int iteration) {
  return folder / "point_cloud" / fmt::format("iteration_{}", iteration) / "point_cloud.ply";
}

std::vector<Pace::Row> read_pace(const std::filesystem::path& train_json) {
  const std::string where = train_json.string();
  const std::string text = read_text_file(train_json, kMaxTrainJson);
  try {
    const ordered_json json = parse_own_json(text);
    if (!json.at("result").contains("pace"))
      fail("{}: its run had no --seconds, so there is no pace to repeat", where);
    return pace_of(json.at("result").at("pace"));
  } catch (const nlohmann::json::exception& error) {
    fail("{}: is no train.json of a model: {}", where, error.what());
  }
}

void write_model_start(const std::filesystem::path& folder, const TrainSettings& settings,
                       const DataSet& data) {
  replace_folder(folder, [&](const std::filesystem::path& hidden) {
    write_text(hidden / "cameras.json", format_cameras(data.cameras()));
    write_text(hidden / "cfg_args", cfg_args(folder, settings, data));
    write_points(data.points, data.origin, hidden / "input.ply");
  });
}

std::filesystem::path write_gaussians(const std::filesystem::path& folder,
                                      const TrainSettings& settings, const ModelState& model,
                                      const glm::dvec3& origin, ThreadPool& pool) {
  auto file = gaussians_path(folder, model.iteration);
  make_folder(file.parent_path());
  if (model.color_field.exists()) {
    write_field_model(model, file, pool);
  } else {
    GaussianCloud cloud = to_cloud(model.parameters, settings.antialiased);
    cloud.origin = origin;
    write_trained_scene(cloud, file, pool);
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
  auto file = write_gaussians(folder, checkpoint.settings, checkpoint.model, data.origin, pool);
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
