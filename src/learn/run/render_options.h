// SPDX-License-Identifier: MIT
//
// Options that both rendering commands and training have, a function each. A command names the
// variable, and the words of the help that differ between commands.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

#include "options/option_table.h"
#include "raster/api/renderer.h"
#include "raster/kernel/cull/mode.h"

namespace qs {

/// The names of all modes, `reference` first.
std::vector<std::string> mode_list();

/// --backend. `work` says what the backend does.
void declare_backend_option(OptionTable& options, std::optional<Backend>& backend,
                            const std::string& work);

/// --device.
void declare_device_option(OptionTable& options, int& device);

/// --threads.
void declare_threads_option(OptionTable& options, int& threads);

/// --sh-degree. `usual` names the default.
void declare_sh_degree_option(OptionTable& options, int& degree, const std::string& usual);

/// --background. `usual` names the default. If `random` is not null, the option also takes the word
/// "random" and sets `*random` to true if it was given, else to false.
void declare_background_option(OptionTable& options,
                               const std::function<void(const glm::vec3& color)>& chosen,
                               const std::string& usual, bool* random = nullptr);

/// One mode, 3dgs or later in the table, for the option `name`.
void declare_mode_option(OptionTable& options, const std::string& name,
                         const std::function<void(CullMode mode)>& chosen, const std::string& help);

}  // namespace qs
