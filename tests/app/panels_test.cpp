// SPDX-License-Identifier: MIT
//
// The panels drawn by ImGui without a window: characters and keys go in, actions come out.
#include "app/viewer/panels/panels.h"

#include <cmath>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <imgui.h>
#include <imgui_internal.h>

#include "app/driven_viewer.h"
#include "app/viewer/commands/commands.h"
#include "app/viewer/panels/style.h"
#include "io/bytes/json_text.h"
#include "support/temporary_folder.h"
#include "test_paths.h"

namespace qs {
namespace {

using test::DrivenScene;
using testing::IsEmpty;
using testing::SizeIs;

class PanelsTest : public testing::Test {
 protected:
  PanelsTest() {
    ImGui::CreateContext();
    ImGuiIO& io = ImGui::GetIO();
    io.IniFilename = nullptr;
    io.DisplaySize = {1280, 720};
    io.DeltaTime = 1.0f / 60;
    for (int key = 0; key < ImGuiKey_COUNT; ++key) io.KeyMap[key] = key;
    unsigned char* pixels = nullptr;
    int width = 0, height = 0;
    io.Fonts->GetTexDataAsAlpha8(&pixels, &width, &height);
    apply_style(1);
    std::ofstream(folder_ / "scene.ply") << "ply";
    driven_.apply([this](Viewer& viewer) { viewer.scene->path = folder_ / "open.ply"; });
  }
  ~PanelsTest() override { ImGui::DestroyContext(); }

  // One drawing of the panels, with a text typed and a key pressed since the last one.
  void draw(const std::string& text = "", ImGuiKey key = ImGuiKey_COUNT) {
    ImGuiIO& io = ImGui::GetIO();
    for (const char c : text) io.AddInputCharacter(static_cast<unsigned char>(c));
    if (key != ImGuiKey_COUNT) io.KeysDown[key] = true;
    Actions actions;
    ImGui::NewFrame();
    draw_panels(driven_.viewer, state_, actions);
    ImGui::EndFrame();
    if (key != ImGuiKey_COUNT) io.KeysDown[key] = false;
    driven_.apply_all(actions);
  }
  bool shows(const char* window) const {
    const ImGuiWindow* found = ImGui::FindWindowByName(window);
    return found != nullptr && found->Active;
  }

  TemporaryFolder folder_;
  DrivenScene driven_{2};
  PanelState state_;
};

TEST_F(PanelsTest, the_dialog_open_takes_what_is_typed_from_its_first_frame_on) {
  driven_.press("Ctrl+O");
  for (const char* letter : {"sc", "e", "n", "e", ".", "p", "l", "y"}) draw(letter);
  draw();
  EXPECT_TRUE(ImGui::GetIO().WantTextInput);
  EXPECT_EQ(state_.chooser.typed(), "scene.ply");
  draw("", ImGuiKey_Enter);
  ASSERT_THAT(driven_.opened, SizeIs(1));
  EXPECT_EQ(driven_.opened[0].path, folder_ / "scene.ply");
  EXPECT_FALSE(driven_.viewer.panels.open);
  draw();
  draw();
  EXPECT_FALSE(shows("Open"));
  EXPECT_FALSE(ImGui::GetIO().WantTextInput);
}

TEST_F(PanelsTest, enter_right_after_the_text_opens_it) {
  driven_.press("Ctrl+O");
  draw("scene.ply", ImGuiKey_Enter);
  ASSERT_THAT(driven_.opened, SizeIs(1));
  EXPECT_EQ(driven_.opened[0].path, folder_ / "scene.ply");
}

TEST_F(PanelsTest, the_dialog_open_closes_by_escape_and_begins_again) {
  driven_.press("Ctrl+O");
  for (const char* letter : {"", "s", "c"}) draw(letter);
  EXPECT_TRUE(shows("Open"));
  draw("", ImGuiKey_Escape);
  EXPECT_FALSE(driven_.viewer.panels.open);
  EXPECT_THAT(driven_.opened, IsEmpty());
  draw();
  driven_.press("Ctrl+O");
  for (int i = 0; i < 3; ++i) draw();
  EXPECT_EQ(state_.chooser.typed(), "");
  EXPECT_TRUE(ImGui::GetIO().WantTextInput);
}

TEST_F(PanelsTest, the_dialog_open_is_drawn_while_all_other_panels_are_hidden) {
  driven_.press("Tab");
  driven_.press("F1");
  driven_.press("Ctrl+O");
  draw();
  draw();
  EXPECT_TRUE(shows("Open"));
  EXPECT_FALSE(shows("Help"));
}

TEST_F(PanelsTest, arrow_keys_and_enter_open_a_row) {
  driven_.press("Ctrl+O");
  draw();
  draw();
  draw("", ImGuiKey_DownArrow);  // ../
  draw();
  draw("", ImGuiKey_DownArrow);  // scene.ply
  draw();
  draw("", ImGuiKey_Enter);
  ASSERT_THAT(driven_.opened, SizeIs(1));
  EXPECT_EQ(driven_.opened[0].path, folder_ / "scene.ply");
}

TEST_F(PanelsTest, the_verdict_of_the_reference_stays_until_the_view_or_the_mode_changes) {
  const auto verdict_shows = [this] {
    draw();
    return shows("Reference");
  };
  ReferenceComparison comparison;
  comparison.view_version = driven_.viewer.view_version;
  comparison.variant = driven_.viewer.variant();
  driven_.apply(action::compared_with_reference, comparison);
  EXPECT_THAT(driven_.viewer.toasts, IsEmpty()) << "the panel shows it";
  EXPECT_TRUE(verdict_shows());
  driven_.apply(action::tick, Turn{1000}, 1000.0);
  EXPECT_TRUE(verdict_shows());
  driven_.press("H");  // the same view with a heat map
  EXPECT_TRUE(verdict_shows());
  driven_.press("2");
  EXPECT_FALSE(verdict_shows());
  driven_.press("5");
  EXPECT_TRUE(verdict_shows());
  driven_.apply(action::dismiss_comparison);
  EXPECT_FALSE(verdict_shows());
  driven_.apply(action::compared_with_reference, comparison);
  driven_.apply(action::orbit, glm::dvec2(3, 4));
  EXPECT_FALSE(verdict_shows());
}

// Relative luminance and contrast as the Web Content Accessibility Guidelines define them.
double luminance(ImVec4 color) {
  const auto linear = [](float value) {
    const auto v = static_cast<double>(value);
    return v <= 0.03928 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
  };
  return 0.2126 * linear(color.x) + 0.7152 * linear(color.y) + 0.0722 * linear(color.z);
}

TEST_F(PanelsTest, a_slider_s_value_is_legible_over_its_grab) {
  const ImVec4* colors = ImGui::GetStyle().Colors;
  for (const int grab : {ImGuiCol_SliderGrab, ImGuiCol_SliderGrabActive, ImGuiCol_FrameBg}) {
    const double contrast =
        (luminance(colors[ImGuiCol_Text]) + 0.05) / (luminance(colors[grab]) + 0.05);
    EXPECT_GT(contrast, 4.5) << grab;
  }
}

TEST(CommandHints, name_commands_that_exist_and_their_keys) {
  EXPECT_EQ(command_hint("Flip the split"), "Flip the split (X)");
  EXPECT_EQ(command_hint("Open a file"), "Open a file (Ctrl+O)");
  const std::string call = "command_tooltip(\"";
  const std::filesystem::path panels =
      std::filesystem::path(QUADSPLAT_SOURCE_DIR) / "src/app/viewer/panels";
  int hints = 0;
  for (const auto& file : std::filesystem::directory_iterator(panels)) {
    const std::string text = read_text_file(file.path(), 1 << 20);
    for (std::size_t at = text.find(call); at != std::string::npos; at = text.find(call, at + 1)) {
      const std::size_t begin = at + call.size();
      const std::string help = text.substr(begin, text.find('"', begin) - begin);
      EXPECT_NE(command_hint(help), help) << file.path();
      ++hints;
    }
  }
  EXPECT_GT(hints, 5);
}

}  // namespace
}  // namespace qs
