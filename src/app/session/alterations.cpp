// SPDX-License-Identifier: MIT
#include "app/session/alterations.h"

#include <fmt/format.h>

#include "base/json_of.h"
#include "base/text.h"
#include "io/camera/cameras.h"
#include "raster/lens/lens_view.h"

namespace qs {
namespace {

// "fisheye of 180 degrees (numbers are sums over its faces, 24 all round)".
std::string lens_text(const LensView& lens) {
  std::string text = lens.text;
  if (lens.eye_distance > 0) text += fmt::format(" for eyes {:g} apart", lens.eye_distance);
  if (lens.up) text += ", level";
  if (!lens.is_parallel())
    text += fmt::format(" (numbers are sums over its faces, {} all round)", lens.faces);
  return text;
}

}  // namespace

void Alterations::add_to(nlohmann::ordered_json& object) const {
  if (!json.is_null()) object["altered"] = json;
}

Alterations alterations_of(const RenderSettings& settings, const SceneNature& scene) {
  Alterations all;
  const auto add = [&](bool is_altered, const char* name, const nlohmann::ordered_json& value,
                       const std::string& text, const std::string& brief) {
    if (!is_altered) return;
    all.json[name] = value;
    all.text += (all.text.empty() ? "" : ", ") + text;
    all.brief += (all.brief.empty() ? "" : ", ") + brief;
  };
  const auto add_setting = [&](bool is_altered, const char* name, const auto& value,
                               const std::string& text) {
    add(is_altered, name, value, text, text);
  };
  const EditFacts& edits = scene.edits;
  // A tree that is not read whole has steps, and the hash of their file.
  const std::string gaussians =
      edits.of > 0 ? fmt::format("{} of {} Gaussians", grouped(edits.kept), grouped(edits.of))
                   : std::string("each page");
  const glm::vec3 color = settings.background;
  const bool antialiased = settings.antialiased.value_or(scene.antialiased);
  add_setting(settings.splat_scale != 1, "splat_scale", settings.splat_scale,
              fmt::format("splat scale {:.3g}", settings.splat_scale));
  const char* style = kDrawStyleNames[static_cast<int>(settings.style)];
  add_setting(settings.style != DrawStyle::splats, "style", style,
              fmt::format("drawn as {}", style));
  add(edits.steps > 0, "edits",
      {{"steps", edits.steps}, {"kept", edits.kept}, {"of", edits.of}, {"hash", edits.crc}},
      fmt::format("edited: {} step{}, {}, {}", edits.steps, edits.steps == 1 ? "" : "s", gaussians,
                  edits.crc),
      "edited: " + gaussians);
  add_setting(edits.copies != glm::ivec2(1), "copies", std::vector{edits.copies.x, edits.copies.y},
              fmt::format("{} x {} copies", edits.copies.x, edits.copies.y));
  add_setting(scene.axes != scene.declared_axes, "axes", scene.axes,
              "read with axes " + scene.axes);
  add_setting(settings.sh_degree < scene.sh_degree, "sh_degree", settings.sh_degree,
              fmt::format("SH degree {} of {}", settings.sh_degree, scene.sh_degree));
  add_setting(color != glm::vec3(scene.white_background ? 1.0f : 0.0f), "background",
              json_of(color),
              fmt::format("background {:.3g},{:.3g},{:.3g}", color.x, color.y, color.z));
  add_setting(antialiased != scene.antialiased, "antialiased", antialiased,
              antialiased ? "antialiased" : "not antialiased");
  add_setting(settings.tile_px != kTileSize, "tile_px", settings.tile_px,
              fmt::format("tiles of {} pixels", settings.tile_px));
  add_setting(*scene.exact_colors != 0, "exact_colors", scene.exact_colors,
              fmt::format("exact colours: {}", scene.exact_colors));
  if (settings.lens) {
    const std::string text = lens_text(*settings.lens);
    add(true, "lens", text, "lens " + text, "lens " + settings.lens->text);
  }
  add_setting(scene.levels, "levels", true, "levels of detail");
  add_setting(settings.occlusion, "occlusion", true, "hidden Gaussians may be left out");
  if (!all.text.empty()) all.json["text"] = all.text;
  return all;
}

Alterations alterations_of(const Session& session) {
  if (!session.scene) return {};
  const Scene& scene = *session.scene;
  const bool exact = scene.network && session.network != NetworkUse::never;
  return alterations_of(session.settings, {scene.cloud.sh_degree, scene.cloud.antialiased,
                                           model_wants_white_background(scene.path), scene.axes,
                                           scene.declared_axes, edits_of(session),
                                           !exact                                     ? ""
                                           : session.network == NetworkUse::reference ? "reference"
                                                                                      : "all",
                                           scene.stream != nullptr});
}

std::string altered_clause(const Session& session) {
  const std::string text = alterations_of(session).text;
  return text.empty() ? "" : ", " + text;
}

}  // namespace qs
