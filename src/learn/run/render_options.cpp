// SPDX-License-Identifier: MIT
#include "learn/run/render_options.h"

#include <fmt/format.h>

#include "raster/scene/gaussian_cloud.h"

namespace qs {

std::vector<std::string> mode_list() {
  std::vector<std::string> names;
  for (CullMode mode = 0; mode <= mode_count(); ++mode) names.emplace_back(mode_name(mode));
  return names;
}

void declare_backend_option(OptionTable& options, std::optional<Backend>& backend,
                            const std::string& work) {
  options.choice(
      "--backend", {"auto", kBackendNames[0], kBackendNames[1]},
      [&backend](int chosen) {
        backend = chosen == 0 ? std::nullopt : std::optional(static_cast<Backend>(chosen - 1));
      },
      work + " (default: auto, cuda where it works, else cpu)");
}

void declare_device_option(OptionTable& options, int& device) {
  options.integer("--device", "N", 0, 1024, device,
                  "GPU of the CUDA backend, numbered as in quadsplat --list-gpus (default: the "
                  "first that works)");
}

void declare_threads_option(OptionTable& options, int& threads) {
  options.integer("--threads", "N", 1, 1024, threads,
                  "CPU threads (default: one per hardware thread)");
}

void declare_sh_degree_option(OptionTable& options, int& degree, const std::string& usual) {
  options.integer("--sh-degree", "N", 0, kMaxShDegree, degree,
                  fmt::format("highest degree of view-dependent colour (default: {})", usual));
}

void declare_background_option(OptionTable& options,
                               const std::function<void(const glm::vec3& color)>& chosen,
                               const std::string& usual, bool* random) {
  OptionTable::Samples samples = {"1,0.5,0"};
  if (random != nullptr) samples.emplace_back("random");
  options.value(
      "--background", "R,G,B",
      fmt::format("behind the scene, each 0..1{} (default: {})",
                  random != nullptr ? ", or random: another colour in every iteration" : "", usual),
      samples, [chosen, random](const std::string& text) {
        if (random != nullptr) *random = text == "random";
        if (text != "random" || random == nullptr) chosen(parse_color("--background", text));
      });
}

void declare_mode_option(OptionTable& options, const std::string& name,
                         const std::function<void(CullMode mode)>& chosen,
                         const std::string& help) {
  std::vector<std::string> names = mode_list();
  names.erase(names.begin() + kReferenceMode);
  options.choice(
      name, names, [chosen](int index) { chosen(index + 1); }, help);
}

}  // namespace qs
