// SPDX-License-Identifier: MIT

#include "app/viewer/panel_model/panel_model.h"

namespace qs {

Ink ink_of(CullMode mode) { return {on_dark::mode_color(mode), mode_color(mode)}; }

std::span<const PanelRow> panel_rows() {
  static constexpr PanelRow kRows[] = {
      {&Panels::hud, "table", "FPS of all modes", table_blocks},
      {&Panels::split, "split", "Split", split_blocks},
      {&Panels::recorder, "recorder", "Zoom recorder", recorder_blocks},
      {&Panels::training, "training", "Training", training_blocks},
      {&Panels::crop, "crop", "Crop and clean", crop_blocks},
      {&Panels::measures, "measures", "Measure", measure_blocks},
      {&Panels::inspector, "inspector", "Inspector", inspector_blocks},
      {&Panels::cameras, "path", "Cameras and path", camera_blocks},
      {&Panels::info, "settings", "Scene and render settings", settings_blocks},
      {&Panels::messages, "messages", "Messages",
       [](const Viewer&) -> Blocks { return {block::Local::messages}; }},
  };
  return kRows;
}

}  // namespace qs
