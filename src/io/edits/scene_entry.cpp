// SPDX-License-Identifier: MIT
#include "io/edits/scene_entry.h"

namespace qs {

EditedScene SceneEntry::scene(std::vector<std::string>& warnings) {
  EditedScene scene;
  if (!reads("scene")) return scene;
  SceneEntry entry{child("scene"), origin};
  if (entry.reads("name")) scene.name = entry.text("name");
  if (entry.reads("hash")) scene.hash = entry.text("hash");
  if (entry.reads("bytes")) scene.bytes = entry.whole("bytes");
  if (entry.reads("gaussians")) scene.gaussians = entry.whole("gaussians");
  if (entry.reads("axes")) scene.axes = entry.text("axes");
  entry.warn_unknown(warnings);
  return scene;
}

void SceneEntry::warn_unknown(std::vector<std::string>& warnings) const {
  for (const auto& [name, value] : object.items())
    if (!known.contains(name))
      warnings.push_back(fmt::format("{}: the member {} is not known", where, printable(name)));
}

nlohmann::ordered_json json_of(const EditedScene& scene) {
  return {{"name", scene.name},
          {"hash", scene.hash},
          {"bytes", scene.bytes},
          {"gaussians", scene.gaussians},
          {"axes", scene.axes}};
}

}  // namespace qs
