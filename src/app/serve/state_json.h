// SPDX-License-Identifier: MIT
//
// The state that a visitor's page shows, as sections of a JSON object:
//   {"type":"state", "version":7, "sections":{"view":{...}, ...}}
// A section is sent when it changed. Only what this file names is ever sent: no path of a file is.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "app/serve/visitor.h"

namespace qs {

/// Name of a section -> its value as JSON text.
using StateSections = std::map<std::string, std::string>;

/// `scenes`: all scenes of the server.
StateSections state_sections(const Visitor& visitor, const std::vector<const OpenedScene*>& scenes);

/// The message with the sections of `now` that differ from `before`; empty if none does.
std::string state_message(const StateSections& before, const StateSections& now,
                          std::uint32_t version);

}  // namespace qs
