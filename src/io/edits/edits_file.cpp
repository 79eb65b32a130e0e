// SPDX-License-Identifier: MIT
#include "io/edits/edits_file.h"

#include <algorithm>

#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>

#include "base/json_of.h"
#include "base/text.h"
#include "io/bytes/base64.h"
#include "io/bytes/byte_text.h"
#include "io/bytes/inflate.h"
#include "io/bytes/json_text.h"
#include "io/bytes/json_value.h"
#include "io/camera/cameras.h"
#include "io/edits/scene_entry.h"
#include "raster/select/edit_history.h"

namespace qs {
namespace {

using nlohmann::ordered_json;

constexpr int kVersion = 2;               // the newest; 1 has no bits
constexpr std::size_t kMostPairs = 1000;  // longer lists are written as bits
constexpr std::size_t kMostGaussians = std::size_t{1} << 32;

// The members of a select step that its tool uses.
enum Uses : unsigned {
  kPicture = 1,  // kind, weight, camera, pixels
  kRadius = 2,
  kPoint = 4,
  kNormal = 8,  // may be missing
  kBox = 16,
  kColor = 32,
  kTolerance = 64,
  kRange = 128,  // low, high; either may be missing
  kSteps = 256   // may be missing
};

struct ToolRow {
  SelectTool tool;
  unsigned uses;
  std::size_t fewest = 0, most = 0;  // pixels
};

constexpr ToolRow kTools[] = {{SelectTool::rectangle, kPicture, 2, 2},
                              {SelectTool::polygon, kPicture, 3, kMaxCorners},
                              {SelectTool::lasso, kPicture, 3, kMaxCorners},
                              {SelectTool::brush, kPicture | kRadius, 1, kMaxCorners},
                              {SelectTool::sphere, kPoint | kRadius},
                              {SelectTool::box, kBox},
                              {SelectTool::color, kColor | kTolerance},
                              {SelectTool::opacity, kRange},
                              {SelectTool::size, kRange},
                              {SelectTool::distance, kPoint | kNormal | kRange},
                              {SelectTool::list, 0},
                              {SelectTool::flood, kTolerance},
                              {SelectTool::grow, kSteps},
                              {SelectTool::shrink, kSteps},
                              {SelectTool::invert, 0},
                              {SelectTool::all, 0},
                              {SelectTool::none, 0}};
static_assert(std::size(kTools) == std::size(kSelectToolNames));

// The lists of a small file can be large in memory: this is left for them.
struct Room {
  std::size_t runs = EditHistory::kMostBytes / sizeof(GaussianRun);
  std::size_t bytes = kMostGaussians / 8;  // of unpacked bits

  void take(std::size_t& left, std::size_t count, const std::string& where) const {
    if (count > left) fail("{}: the lists of the file are too large", where);
    left -= count;
  }
};

// An object of the file.
struct Reading : SceneEntry {
  Room& room;

  CropBox box() {
    known.insert("box");
    const json& ends = get("box");
    if (!ends.is_array() || ends.size() != 2) fail("{}: box is not a list of 2 corners", where);
    const CropBox box{glm::vec3(vector<3>(ends[0], "box") - origin),
                      glm::vec3(vector<3>(ends[1], "box") - origin)};
    if (!glm::all(glm::lessThanEqual(box.low, box.high))) fail("{}: box has a side below 0", where);
    return box;
  }
};

// The runs of ones in packed bits, the least significant first.
std::vector<GaussianRun> parse_bits(Reading& entry) {
  const std::string where = entry.where + ": bits";
  const Array<std::byte> packed = decode_data_uri(entry.text("bits"), where);
  Inflater inflater({packed.data(), packed.size()}, where, DeflateForm::deflate);
  std::vector<GaussianRun> runs;
  std::vector<std::byte> piece(1 << 16);
  for (std::uint64_t first = 0;; first += 8 * piece.size()) {
    const std::size_t size = inflater.read(piece);
    entry.room.take(entry.room.bytes, size, where);
    for (GaussianRun run : GaussianSet::of_bytes(8 * size, piece).runs()) {
      run.first += first;
      if (!runs.empty() && runs.back().first + runs.back().count == run.first) {
        runs.back().count += run.count;
      } else {
        entry.room.take(entry.room.runs, 1, where);
        runs.push_back(run);
      }
    }
    if (size == piece.size()) continue;
    if (inflater.left() > 0) fail("{}: {} bytes behind its data", where, inflater.left());
    return runs;
  }
}

std::vector<GaussianRun> parse_members(Reading& entry) {
  entry.known.insert("members");
  if (entry.reads("bits")) return parse_bits(entry);
  const nlohmann::json& list = entry.get("members");
  if (!list.is_array() || list.size() % 2 != 0)
    fail("{}: members is not a list of pairs", entry.where);
  std::vector<GaussianRun> runs;
  std::uint64_t end = 0;
  for (std::size_t i = 0; i < list.size(); i += 2) {
    const auto [first, count] = runs.emplace_back(
        GaussianRun{entry.whole(list[i], "members"), entry.whole(list[i + 1], "members")});
    if (count == 0 || first < end || first + count > kMostGaussians)
      fail("{}: members {} + {} are no ascending run", entry.where, first, count);
    end = first + count;
  }
  entry.room.take(entry.room.runs, runs.size(), entry.where);
  return runs;
}

bool is_long(const SelectStep& step) { return step.members && step.members->size() > kMostPairs; }

std::string packed_bits(const std::vector<GaussianRun>& runs) {
  GaussianSet set(static_cast<std::size_t>(runs.back().first + runs.back().count));
  for (const GaussianRun& run : runs)
    for (std::uint64_t i = 0; i < run.count; ++i) set.add(static_cast<std::size_t>(run.first + i));
  const std::span<const std::byte> bytes = set.bytes();
  constexpr int kLevel = 6;
  return "data:application/octet-stream;base64," +
         base64(deflated({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, kLevel));
}

void parse_picture(Reading& entry, const ToolRow& row, SelectStep& step) {
  step.kind = entry.word("kind", kSelectKindNames, step.kind);
  if (entry.reads("weight")) step.weight = static_cast<float>(entry.number_within("weight", 0, 1));
  entry.known.insert({"camera", "pixels"});
  step.camera = camera_of(ordered_json(entry.child("camera").object), entry.where + ": camera");
  const nlohmann::json& pixels = entry.get("pixels");
  if (!pixels.is_array() || pixels.size() < row.fewest || pixels.size() > row.most)
    fail("{}: pixels is not a list of {} to {} points", entry.where, row.fewest, row.most);
  for (const nlohmann::json& each : pixels) {
    constexpr double kFar = 1e7;
    const auto pixel = entry.vector<2>(each, "pixels");
    if (!(glm::length(pixel) <= kFar)) fail("{}: pixels are outside of any picture", entry.where);
    step.pixels.emplace_back(pixel);
  }
}

SelectStep parse_select(Reading& entry) {
  SelectStep step;
  step.tool = entry.word<SelectTool>("tool", kSelectToolNames);
  const ToolRow& row = kTools[static_cast<std::size_t>(step.tool)];
  if (!changes_selection(step.tool)) step.how = entry.word("how", kSelectHowNames, step.how);
  if (row.uses & kPicture) parse_picture(entry, row, step);
  if (row.uses & kRadius) step.radius = entry.number_within("radius", 1e-9, 1e9);
  if (row.uses & kPoint) step.point = entry.place("point");
  if (row.uses & kNormal && entry.reads("normal")) {
    step.normal = entry.vector<3>("normal");
    if (!(glm::length(*step.normal) > 1e-9)) fail("{}: normal has no direction", entry.where);
  }
  if (row.uses & kBox) step.box = entry.box();
  if (row.uses & kColor) {
    entry.known.insert("color");
    step.color = entry.vector<3>("color");
  }
  if (row.uses & kTolerance) step.tolerance = entry.number_within("tolerance", 0, 1000);
  if (row.uses & kRange) {
    step.range = {-1e30, 1e30};
    if (entry.reads("low")) step.range.low = entry.number("low");
    if (entry.reads("high")) step.range.high = entry.number("high");
  }
  if (row.uses & kSteps && entry.reads("steps"))
    step.steps = static_cast<int>(entry.number_within("steps", 1, 1000));
  if (entry.reads("count")) step.count = entry.whole("count");
  if (entry.reads("crc")) step.crc = entry.text("crc");
  if (step.tool == SelectTool::list || entry.reads("members") || entry.reads("bits"))
    step.members = parse_members(entry);
  return step;
}

// Criteria that are missing are off, unless all are.
Floaters parse_floaters(Reading& entry) {
  Floaters floaters;
  const bool faint = entry.reads("opacity"), large = entry.reads("size");
  const bool isolated = entry.reads("neighbours");
  if (!faint && !large && !isolated) return floaters;
  if (faint) floaters.least_opacity = static_cast<float>(entry.number_within("opacity", 0, 1));
  if (large) floaters.largest_size = static_cast<float>(entry.number_within("size", 0, 1e9));
  if (isolated)
    floaters.fewest_neighbours = static_cast<int>(entry.number_within("neighbours", 0, 1e6));
  floaters.faint = faint;
  floaters.large = large;
  floaters.isolated = isolated;
  return floaters;
}

EditStep parse_step(Reading& entry) {
  EditStep step;
  step.kind = entry.word<EditKind>("step", kEditKindNames);
  switch (step.kind) {
    case EditKind::select:
      step.select = parse_select(entry);
      break;
    case EditKind::crop:
      step.box = entry.box();
      break;
    case EditKind::floaters:
      step.floaters = parse_floaters(entry);
      break;
    case EditKind::scale:
      step.factor = entry.number_within("factor", 1e-9, 1e9);
      if (entry.reads("unit")) step.unit = entry.text("unit");
      break;
    case EditKind::level: {
      entry.known.insert("rotation");
      const auto q = entry.vector<4>("rotation");
      if (!(glm::length(q) > 1e-9)) fail("{}: rotation has no direction", entry.where);
      step.rotation = glm::normalize(glm::dquat(q.w, q.x, q.y, q.z));
      break;
    }
    default:
      break;
  }
  return step;
}

ordered_json box_json(const CropBox& box, const glm::dvec3& origin) {
  return {json_of(glm::dvec3(box.low) + origin), json_of(glm::dvec3(box.high) + origin)};
}

void add_select(const SelectStep& step, const glm::dvec3& origin, ordered_json& json) {
  const unsigned uses = kTools[static_cast<std::size_t>(step.tool)].uses;
  json["tool"] = kSelectToolNames[static_cast<std::size_t>(step.tool)];
  if (!changes_selection(step.tool))
    json["how"] = kSelectHowNames[static_cast<std::size_t>(step.how)];
  if (uses & kPicture) {
    json["kind"] = kSelectKindNames[static_cast<std::size_t>(step.kind)];
    if (step.kind == SelectKind::visible) json["weight"] = step.weight;
    json["camera"] = camera_json(step.camera);
    for (const glm::dvec2& pixel : step.pixels) json["pixels"].push_back({pixel.x, pixel.y});
  }
  if (uses & kRadius) json["radius"] = step.radius;
  if (uses & kPoint) json["point"] = json_of(step.point + origin);
  if (uses & kNormal && step.normal) json["normal"] = json_of(*step.normal);
  if (uses & kBox) json["box"] = box_json(step.box, origin);
  if (uses & kColor) json["color"] = json_of(step.color);
  if (uses & kTolerance) json["tolerance"] = step.tolerance;
  if (uses & kRange) {
    json["low"] = step.range.low;
    json["high"] = step.range.high;
  }
  if (uses & kSteps) json["steps"] = step.steps;
  if (step.count) json["count"] = *step.count;
  if (!step.crc.empty()) json["crc"] = step.crc;
  if (!step.members) return;
  if (is_long(step)) {
    json["bits"] = packed_bits(*step.members);
    return;
  }
  json["members"] = ordered_json::array();
  for (const GaussianRun& run : *step.members) {
    json["members"].push_back(run.first);
    json["members"].push_back(run.count);
  }
}

ordered_json step_json(const EditStep& step, const glm::dvec3& origin) {
  ordered_json json = {{"step", kEditKindNames[static_cast<std::size_t>(step.kind)]}};
  if (step.kind == EditKind::select) add_select(step.select, origin, json);
  if (step.kind == EditKind::crop) json["box"] = box_json(step.box, origin);
  if (step.kind == EditKind::floaters) {
    const Floaters& floaters = step.floaters;
    if (floaters.faint) json["opacity"] = floaters.least_opacity;
    if (floaters.large) json["size"] = floaters.largest_size;
    if (floaters.isolated) json["neighbours"] = floaters.fewest_neighbours;
  }
  if (step.kind == EditKind::scale) {
    json["factor"] = step.factor;
    if (!step.unit.empty()) json["unit"] = step.unit;
  }
  if (step.kind == EditKind::level)
    json["rotation"] = {step.rotation.x, step.rotation.y, step.rotation.z, step.rotation.w};
  return json;
}

}  // namespace

EditsFile read_edits(const std::filesystem::path& path, const glm::dvec3& origin) {
  return parse_edits(read_text_file(path, kMaxEditBytes), path.string(), origin);
}

EditsFile parse_edits(std::string_view text, const std::string& source, const glm::dvec3& origin) {
  const nlohmann::json json = parse_json(text, source);
  if (!json.is_object()) fail("{}: is not a file of edits: it has no object", source);
  Room room;
  Reading file{{{json, source}, origin}, room};
  if (!file.reads("version") || !file.reads("steps"))
    fail("{}: is not a file of edits: it has no version or no steps", source);
  if (const double version = file.number("version"); version != 1 && version != kVersion)
    fail("{}: version {} is not readable, only 1 and {}", source, version, kVersion);
  EditsFile edits;
  edits.scene = file.scene(edits.warnings);
  const nlohmann::json& steps = file.get("steps");
  if (!steps.is_array() || steps.size() > kMaxEditSteps)
    fail("{}: steps is not a list of at most {} objects", source, grouped(kMaxEditSteps));
  for (const nlohmann::json& each : steps) {
    const std::string where = fmt::format("{}: step {}", source, edits.steps.size() + 1);
    if (!each.is_object()) fail("{}: is not an object", where);
    Reading entry{{{each, where}, origin}, room};
    edits.steps.push_back(parse_step(entry));
    entry.warn_unknown(edits.warnings);
  }
  file.warn_unknown(edits.warnings);
  return edits;
}

std::string format_edits(const EditsFile& edits, const glm::dvec3& origin) {
  const bool has_bits = std::ranges::any_of(edits.steps, is_long, &EditStep::select);
  std::string text = fmt::format("{{\"version\": {},\n \"scene\": {},\n \"steps\": [",
                                 has_bits ? kVersion : 1, json_line(json_of(edits.scene)));
  const char* between = "\n  ";
  for (const EditStep& step : edits.steps) {
    text += between + json_line(step_json(step, origin));
    between = ",\n  ";
  }
  return text + "\n ]}\n";
}

}  // namespace qs
