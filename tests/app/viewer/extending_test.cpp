// SPDX-License-Identifier: MIT
//
// The samples of docs/extending.md: they compile, and their names and keys are free.
#include <algorithm>
#include <filesystem>
#include <map>
#include <regex>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "app/cli/command.h"
#include "app/cli/shared_options.h"
#include "app/viewer/commands/commands.h"
#include "app/viewer/panel_model/panel_model.h"
#include "app/viewer/state/actions.h"
#include "io/bytes/json_text.h"
#include "learn/run/strategy.h"
#include "support/paths.h"

// NOLINTBEGIN: text of the page, each in the namespaces of the files that it belongs to
namespace qs::sample_command {
#include "extending_command.h"
}
namespace qs::train::sample_strategy {
#include "extending_strategy.h"
}
namespace qs::action::sample_action {
#include "extending_action.h"
}
namespace qs::sample_panel {
#include "extending_panel.h"
}
// NOLINTEND

namespace qs {
namespace {

TEST(Extending, the_sample_command_declares_options_and_an_action) {
  Options options("count", "prints the number of Gaussians of a scene");
  const CommandAction action = sample_command::count_command(options);
  EXPECT_TRUE(action);
}

TEST(Extending, the_sample_action_draws_the_picture_anew) {
  Viewer viewer;
  viewer.settings.splat_scale = 2;
  const int before = viewer.view_version;
  action::sample_action::reset_splats(viewer);
  EXPECT_EQ(viewer.settings.splat_scale, 1);
  EXPECT_GT(viewer.view_version, before);
}

TEST(Extending, the_sample_strategy_drops_large_gaussians) {
  const train::Strategy row{.name = "small",
                            .summary = "drops large Gaussians",
                            .interval = 1000,
                            .change = train::sample_strategy::small_change};
  EXPECT_TRUE(row.changes_before({}, 1001));
  EXPECT_FALSE(row.changes_before({}, 1002));
  train::GaussianFacts facts;
  facts.means.resize(2);
  facts.rotations.resize(2);
  facts.opacity_logits.resize(2);
  facts.log_scales = {glm::vec3(0.1f), glm::vec3(-0.1f)};
  train::Plan plan;
  row.plan({{}, 1001, 1, {}}, facts, plan);
  EXPECT_EQ(plan.log_scales, std::vector{glm::vec3(-0.1f)});
}

TEST(Extending, the_sample_panel_has_controls_that_exist) {
  const Blocks blocks = sample_panel::count_blocks(Viewer());
  EXPECT_EQ(std::get<block::Text>(blocks.at(0)).text, "0 keyframes");
  for (const block::Placed& placed : std::get<block::Controls>(blocks.at(1)).controls)
    EXPECT_NE(find_control(placed.name), nullptr) << placed.name;
}

TEST(Extending, the_keys_of_the_samples_are_free) {
  const std::string page = read_text_file(test::source_path("docs/extending.md"), 1 << 20);
  const std::map<std::string, int> keys = {{"SLASH", GLFW_KEY_SLASH}, {"F7", GLFW_KEY_F7}};
  int found = 0;
  const std::regex name("GLFW_KEY_([A-Z0-9]+)");
  for (std::sregex_iterator it(page.begin(), page.end(), name), end; it != end; ++it) {
    ++found;
    const auto key = keys.find((*it)[1]);
    ASSERT_NE(key, keys.end()) << "add " << (*it)[1] << " to this test";
    EXPECT_EQ(find_key_command(key->second, 0), nullptr) << (*it)[1];
  }
  EXPECT_EQ(found, 2);
}

}  // namespace
}  // namespace qs
