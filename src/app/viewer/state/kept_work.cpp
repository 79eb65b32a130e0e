// SPDX-License-Identifier: MIT
#include "app/viewer/state/kept_work.h"

#include <algorithm>
#include <sstream>
#include <tuple>

#include <fmt/format.h>

#include "app/viewer/state/actions.h"
#include "base/error.h"
#include "base/text.h"

namespace qs {
namespace {

// "3 keyframes", "a crop": the parts that there are. One keyframe is no path.
std::vector<std::string> work_of(const Viewer& v) {
  std::vector<std::string> parts;
  if (v.keyframes.size() > 1) parts.push_back(fmt::format("{} keyframes", v.keyframes.size()));
  if (!applied_wishes(v.crop).empty()) parts.emplace_back("a crop");
  return parts;
}

bool is_filming(const Viewer& v) { return v.loading && v.loading->what == kFilming; }

// The values of a crop, in the order in which they are kept.
auto values_of(auto& crop) {
  auto& [low, high] = crop.box;
  auto& f = crop.floaters;
  return std::tie(crop.boxed, low.x, low.y, low.z, high.x, high.y, high.z, crop.cleans, f.faint,
                  f.large, f.isolated, f.least_opacity, f.largest_size, f.fewest_neighbours);
}

std::string format_crops(const std::vector<CropWish>& crops) {
  std::string text;
  const auto add = [&](const auto&... value) { ((text += fmt::format("{} ", +value)), ...); };
  for (const CropWish& crop : crops)
    if (crop.boxed || crop.cleans) std::apply(add, values_of(crop));
  return text;
}

std::vector<CropWish> parse_crops(const std::string& text) {
  std::vector<CropWish> crops;
  std::istringstream in(text);
  const auto read = [&](auto&... value) { (in >> ... >> value); };
  for (CropWish crop; std::apply(read, values_of(crop)), in;) crops.push_back(crop);
  return crops;
}

}  // namespace

// Work refers to the axes that the file was read with.
std::string work_name(const ViewedScene& scene) {
  return fmt::format("{} {}", scene.path.string(), scene.axes);
}

std::vector<CropWish> applied_wishes(const Crop& crop) {
  std::vector<CropWish> wishes = crop.done;
  if (crop.applied) wishes.push_back(crop.wish);
  return wishes;
}

std::string unsaved_text(const Viewer& v, const std::filesystem::path& opens) {
  std::vector<std::string> parts;
  if (v.scene && !v.keeps_work) parts = work_of(v);
  const std::vector<CropWish> crops = applied_wishes(v.crop);
  if (v.scene && v.keeps_work && !v.selecting.saved &&
      std::ranges::any_of(crops, [](const CropWish& crop) { return crop.selected != nullptr; }))
    parts.emplace_back("Gaussians that were selected and removed (Ctrl+S saves them)");
  if (opens.empty() && !v.unsaved_results.empty()) parts.push_back("a " + v.unsaved_results);
  if (v.zoom.running) parts.emplace_back("a zoom that is being recorded");
  if (is_filming(v))
    parts.push_back(fmt::format("a film of which {:.0f} % are drawn", 100 * v.loading->fraction));
  return joined(parts, " and ");
}

namespace action {

void keep_work(Viewer& v) {
  if (!v.scene) return;
  const std::string name = work_name(*v.scene);
  v.kept_paths.erase(name);
  v.kept_crops.erase(name);
  if (!v.keyframes.empty()) v.kept_paths[name] = format_camera_path(v.keyframes);
  const std::vector<CropWish> crops = applied_wishes(v.crop);
  // The visitors of a page share the crop.
  if (const std::string text = format_crops(crops); !text.empty() && !v.is_remote)
    v.kept_crops[name] = text;
}

void restore_work(Viewer& v, bool another) {
  const std::string name = work_name(*v.scene);
  v.crop = {};
  v.selecting = {};
  v.cross.reset();
  if (another) {
    v.measures = {};
    v.keyframes.clear();
    v.keyframe_history = {};
  }
  try {
    if (const auto kept = v.kept_paths.find(name); another && kept != v.kept_paths.end())
      v.keyframes = parse_camera_path(kept->second, "settings");
    if (const auto kept = v.kept_crops.find(name); kept != v.kept_crops.end())
      v.crop.done = parse_crops(kept->second);
  } catch (const Error&) {  // the settings were edited by hand
  }
  if (!v.crop.done.empty()) {
    v.crop.wish = v.crop.done.back();
    v.crop.done.pop_back();
    v.crop.applied = true;
  }
  const std::string work = joined(work_of(v), " and ");
  if (another && !work.empty())
    notify(v, fmt::format("restored {} of this scene{}", work,
                          v.crop.applied ? "; Shift+R undoes a crop" : ""));
}

void leave(Viewer& v, Host& host, const std::filesystem::path& opens) {
  // Cameras and paths of cameras join the scene.
  const bool joins = opens.extension() == ".json";
  if (joins || unsaved_text(v, opens).empty()) return leave_now(v, host, opens, true);
  v.leaving = opens;
}

void leave_now(Viewer& v, Host& host, const std::filesystem::path& opens, bool keeps) {
  v.leaving.reset();
  if (v.zoom.running || is_filming(v)) host.leave_job(keeps);
  opens.empty() ? host.quit() : host.open(opens, {});
}

}  // namespace action
}  // namespace qs
