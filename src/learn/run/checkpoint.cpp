// SPDX-License-Identifier: MIT
#include <cstring>
#include <fstream>
#include <ostream>
#include <span>

#include <nlohmann/json.hpp>

#include "base/fail.h"
#include "io/bytes/byte_cursor.h"
#include "io/bytes/file_guard.h"
#include "io/bytes/json_text.h"
#include "io/bytes/json_value.h"
#include "io/bytes/mapped_file.h"
#include "io/bytes/replace_file.h"
#include "learn/run/hash.h"
#include "learn/run/model_folder.h"

namespace qs::train {
namespace {

using nlohmann::ordered_json;

constexpr std::string_view kMagic = "QSTRAIN6";

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

}  // namespace qs::train
