// SPDX-License-Identifier: MIT
//
// The state that a visitor's page shows, as sections of a JSON object:
//   {"type":"state", "version":7, "sections":{"view":{...}, ...}}
// A section is sent when it changed. Only what this file names is ever sent: no path of a file is.
#pragma once

#include <map>
#include <span>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "app/serve/visitor.h"
#include "app/viewer/panel_model/panel_model.h"

namespace qs {

/// Name of a section -> its value as JSON text.
using StateSections = std::map<std::string, std::string>;

/// `scenes`: all scenes of the server.
StateSections state_sections(const Visitor& visitor, const std::vector<const OpenedScene*>& scenes);

/// The message with the sections of `now` that differ from `before`; empty if none does.
std::string state_message(const StateSections& before, const StateSections& now,
                          std::uint32_t version);

// The sections for the panels that a visitor has opened, and for what is drawn over the picture.
// Panels are the window's (app/viewer/panel_model): here their blocks become JSON.

/// The list of `json_of(one)` of each element; null is left out.
template <class Range, class JsonOf>
nlohmann::json json_list(const Range& range, const JsonOf& json_of) {
  nlohmann::json list = nlohmann::json::array();
  for (const auto& one : range)
    if (nlohmann::json json = json_of(one); !json.is_null()) list.push_back(std::move(json));
  return list;
}

/// The content of a block; null for what only the window draws.
nlohmann::json to_json(const Block& block, const Viewer& viewer);

/// Section -> value. The first of these are always there; the value is null while there is nothing
/// to show.
///
///   panels       which panels there are and are open: [{name, title, key, open}]
///   NAME         of a panel: the names of the sections of its blocks, in order; null: it is closed
///   NAME/KIND    a block of it; the second of a kind is NAME/KIND2
///   divider      names and place of a split      grid     the labels of all modes
///   box          of the crop in the picture      job      the visitor's running job
///   status       the line below the picture
nlohmann::json panel_sections(const Visitor& visitor,
                              std::span<const PanelRow> panels = panel_rows());

/// The text without paths of files: the scene's path becomes its name, other paths their last part.
std::string public_text(const Viewer& viewer, std::string text);

}  // namespace qs
