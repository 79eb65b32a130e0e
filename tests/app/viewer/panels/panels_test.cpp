// SPDX-License-Identifier: MIT
//
// The panels drawn by ImGui without a window: characters and keys go in, actions come out.
#include "app/viewer/panels/panels.h"

#include <cmath>
#include <fstream>
#include <functional>
#include <regex>
#include <string_view>
#include <vector>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <imgui.h>
#include <imgui_internal.h>

#include "app/support/driven_viewer.h"
#include "app/viewer/commands/commands.h"
#include "app/viewer/commands/controls.h"
#include "app/viewer/panels/style.h"
#include "app/viewer/state/select_actions.h"
#include "app/viewer/state/training_actions.h"
#include "app/viewer/state/zoom_actions.h"
#include "io/bytes/json_text.h"
#include "support/paths.h"
#include "support/temporary_folder.h"

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
#if IMGUI_VERSION_NUM < 18700
    for (int key = 0; key < ImGuiKey_COUNT; ++key) io.KeyMap[key] = key;
#endif
    unsigned char* pixels = nullptr;
    int width = 0, height = 0;
    io.Fonts->GetTexDataAsAlpha8(&pixels, &width, &height);
    apply_style(1);
    std::ofstream(folder_ / "scene.ply") << "ply";
    driven_.apply([this](Viewer& viewer) { viewer.scene->path = folder_ / "open.ply"; });
  }
  ~PanelsTest() override { ImGui::DestroyContext(); }

  // One drawing of the panels, with a text typed and a key pressed since the last drawing.
  void draw(const std::string& text = "", ImGuiKey key = ImGuiKey_COUNT) {
    ImGuiIO& io = ImGui::GetIO();
    for (const char c : text) io.AddInputCharacter(static_cast<unsigned char>(c));
    set_key(key, true);
    Actions actions;
    ImGui::NewFrame();
    draw_panels(driven_.viewer, state_, actions);
    ImGui::EndFrame();
    set_key(key, false);
    driven_.apply_all(actions);
  }
  static void set_key(ImGuiKey key, bool down) {
    if (key == ImGuiKey_COUNT) return;
#if IMGUI_VERSION_NUM >= 18700
    ImGui::GetIO().AddKeyEvent(key, down);
#else
    ImGui::GetIO().KeysDown[key] = down;
#endif
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

TEST_F(PanelsTest, escape_closes_what_is_on_top_first) {
  driven_.press("F1");
  driven_.press("Ctrl+O");  // the help stands back behind a dialog
  for (int i = 0; i < 3; ++i) draw();
  EXPECT_TRUE(shows("Open"));
  draw("", ImGuiKey_Escape);
  EXPECT_FALSE(driven_.viewer.panels.open);
  EXPECT_TRUE(driven_.viewer.panels.help);
  draw();
  draw();
  EXPECT_TRUE(shows("Help"));
  draw("", ImGuiKey_Escape);
  EXPECT_FALSE(driven_.viewer.panels.help);
}

TEST_F(PanelsTest, one_escape_closes_one_thing_and_the_last_cancels_what_runs) {
  driven_.apply([](Viewer& viewer) {
    viewer.scene->candidates.resize(2);
    viewer.view_choice.pictures = std::make_shared<Image>(64, 18, 3);
    viewer.loading = Loading{"/a.mp4", kFilming, 0.5f};
  });
  state_.candidates = 1;
  driven_.press("Ctrl+O");
  for (int i = 0; i < 3; ++i) draw();
  const auto left = [&] {
    draw("", ImGuiKey_Escape);
    draw();
    return std::tuple(driven_.viewer.panels.open, driven_.viewer.view_choice.pictures != nullptr,
                      driven_.cancelled);
  };
  EXPECT_EQ(left(), std::tuple(false, true, 0));
  EXPECT_EQ(left(), std::tuple(false, false, 0));
  EXPECT_EQ(left(), std::tuple(false, false, 1));
  driven_.apply(action::zoom_began, ZoomRecord());
  left();
  EXPECT_EQ(driven_.stopped, 1);
}

TEST_F(PanelsTest, the_palette_finds_a_command_by_its_words_and_runs_it) {
  driven_.press("Ctrl+Shift+P");
  for (const char* letter : {"m", "a", "p", " ", "h", "e", "a"}) draw(letter);
  draw();
  EXPECT_TRUE(shows("Find a command"));
  EXPECT_EQ(state_.words, "map hea");
  draw("", ImGuiKey_Enter);
  EXPECT_TRUE(driven_.viewer.heatmap);
  EXPECT_FALSE(driven_.viewer.panels.palette);
  draw();
  draw();
  EXPECT_FALSE(shows("Find a command"));
  driven_.press("Ctrl+Shift+P");
  for (int i = 0; i < 3; ++i) draw();
  EXPECT_EQ(state_.words, "") << "it begins again";
  draw("quit");
  draw("", ImGuiKey_Escape);
  EXPECT_FALSE(driven_.viewer.panels.palette);
  EXPECT_EQ(driven_.quits, 0);
}

TEST_F(PanelsTest, the_palette_uses_the_controls_of_panels_by_their_words) {
  const auto use = [&](const char* words) {
    driven_.press("Ctrl+Shift+P");
    for (int i = 0; i < 3; ++i) draw();
    draw(words);
    draw("", ImGuiKey_Enter);
    EXPECT_FALSE(driven_.viewer.panels.palette) << words;
    draw();
    draw();
  };
  use("floaters: on");
  EXPECT_TRUE(driven_.viewer.crop.wish.cleans);
  use("FAINT off");
  EXPECT_FALSE(driven_.viewer.crop.wish.floaters.faint);
  use("floaters off");
  EXPECT_FALSE(driven_.viewer.crop.wish.cleans);
  use("select with lasso");
  EXPECT_EQ(driven_.viewer.selecting.tool, SelectTool::lasso);
  use("weight 0.25");
  EXPECT_EQ(driven_.viewer.selecting.weight, 0.25f);
  use("known length 3");
  EXPECT_EQ(driven_.viewer.measures.known, 3);
  EXPECT_THAT(find_uses("weight 7", driven_.viewer), IsEmpty()) << "7 is none of its values";
  EXPECT_THAT(find_uses("weight", driven_.viewer), IsEmpty()) << "a value is missing";
  EXPECT_THAT(find_uses("", driven_.viewer), IsEmpty());
}

TEST_F(PanelsTest, the_arrow_keys_choose_a_command_of_the_palette) {
  driven_.press("Ctrl+Shift+P");
  for (int i = 0; i < 3; ++i) draw();
  draw("interface");
  const std::vector<const KeyCommand*> found = find_commands("interface", driven_.viewer);
  ASSERT_THAT(found, SizeIs(3));
  for (int i = 0; i < 3; ++i) {
    draw("", ImGuiKey_DownArrow);
    draw();
  }
  EXPECT_EQ(state_.chosen_command, 2);
  draw("", ImGuiKey_Enter);
  EXPECT_EQ(driven_.viewer.interface_scale, 1) << found[2]->help;
}

TEST_F(PanelsTest, unsaved_work_is_asked_about_and_escape_goes_back) {
  driven_.apply([](Viewer& viewer) { viewer.unsaved_results = "bench"; });
  driven_.press("Ctrl+Q");
  for (int i = 0; i < 2; ++i) draw();
  EXPECT_TRUE(shows("Not saved"));
  draw("", ImGuiKey_Escape);
  EXPECT_FALSE(driven_.viewer.leaving);
  EXPECT_EQ(driven_.quits, 0);
  draw();
  draw();
  EXPECT_FALSE(shows("Not saved"));
}

TEST_F(PanelsTest, the_help_shows_whole_texts_at_every_size) {
  for (const ImVec2 size : {ImVec2(640, 400), ImVec2(1280, 720), ImVec2(3840, 2160)}) {
    ImGui::GetIO().DisplaySize = size;
    driven_.press("F1");
    for (int i = 0; i < 3; ++i) draw();
    const ImGuiWindow* help = ImGui::FindWindowByName("Help");
    ASSERT_TRUE(help != nullptr && help->Active) << size.x;
    EXPECT_LE(help->ContentSize.x, help->Size.x) << size.x;
    EXPECT_LE(help->Pos.x + help->Size.x, size.x) << size.x;
    driven_.press("F1");
    draw();
  }
}

TEST_F(PanelsTest, drawing_crop_and_clean_changes_nothing) {
  CropWish wish;
  wish.boxed = wish.cleans = true;
  wish.box = {{-0.123456789f, -1, -1}, {1, 1, 1.5f}};
  driven_.press("R");
  driven_.apply(action::change_crop, wish);
  for (const bool cropped : {false, true}) {
    const auto gone = cropped ? std::make_shared<const GaussianSet>(500) : nullptr;
    driven_.apply([gone](Viewer& viewer) { viewer.editing.gone = gone; });
    for (int i = 0; i < 3; ++i) draw();
    EXPECT_TRUE(shows("right bar"));
    EXPECT_TRUE(shows("crop handle 0"));
    EXPECT_EQ(driven_.viewer.crop.wish, wish);
    EXPECT_EQ(driven_.viewer.editing.gone, gone);
  }
}

TEST_F(PanelsTest, drawing_the_zoom_recorder_searches_earlier_zooms_once_and_changes_nothing_else) {
  ZoomRecord record;
  record.scene = "plush";
  record.folder = "zoom/plush_0001";
  record.steps = 3;
  record.modes = {1, 5};
  for (std::uint64_t step = 0; step < 2; ++step) {
    for (const char* mode : {"3dgs", "quadbox"}) {
      BenchRow row;
      row.mode = mode;
      row.view = step;
      row.ms_median = row.ms_p05 = row.ms_p95 = 4;
      row.frames = 20;
      record.rows.push_back(row);
    }
  }
  driven_.press("Z");
  draw();
  EXPECT_THAT(driven_.jobs, SizeIs(1)) << "the search";
  driven_.apply(action::zooms_found, std::vector<ZoomRecord>{record, record});
  driven_.apply(action::show_zoom, std::size_t{0});
  const ZoomPlan before = driven_.viewer.zoom.plan;
  for (const ImVec2 size : {ImVec2(1280, 720), ImVec2(640, 400), ImVec2(320, 240)}) {
    ImGui::GetIO().DisplaySize = size;
    ImGui::GetIO().MousePos = {0.2f * size.x, 0.4f * size.y};
    for (int i = 0; i < 3; ++i) draw();
  }
  EXPECT_TRUE(shows("left bar"));
  EXPECT_EQ(driven_.viewer.zoom.plan, before);
  EXPECT_EQ(driven_.viewer.zoom.shown, 0u);
  EXPECT_THAT(driven_.jobs, SizeIs(1));
  EXPECT_EQ(driven_.text, "");
  EXPECT_THAT(driven_.opened_outside, IsEmpty());
}

TEST_F(PanelsTest, a_handle_of_the_box_follows_the_mouse_until_it_is_let_go) {
  CropWish wish;
  wish.boxed = true;
  wish.box = {glm::vec3(-1), glm::vec3(1)};
  driven_.press("R");
  driven_.apply(action::change_crop, wish);
  draw();
  const ImGuiWindow* handle = ImGui::FindWindowByName("crop handle 1");
  ASSERT_NE(handle, nullptr);
  ImGuiIO& io = ImGui::GetIO();
  io.MousePos = handle->Rect().GetCenter();
  draw();
  draw();
  io.MouseDown[0] = true;
  draw();
  EXPECT_NEAR(driven_.viewer.crop.wish.box.high.x, 1, 0.05);
  const float before = driven_.viewer.crop.wish.box.high.x;
  for (int i = 0; i < 5; ++i) {
    io.MousePos.x += 4;
    draw();
  }
  io.MouseDown[0] = false;
  draw();
  EXPECT_NE(driven_.viewer.crop.wish.box.high.x, before);
  EXPECT_EQ(driven_.viewer.crop.wish.box.low, wish.box.low);
  const float after = driven_.viewer.crop.wish.box.high.x;
  io.MousePos.x += 40;
  draw();
  EXPECT_EQ(driven_.viewer.crop.wish.box.high.x, after) << "once it was let go";
}

TEST_F(PanelsTest, a_folder_is_chosen_for_the_dialog_train_which_then_returns) {
  std::filesystem::create_directory(folder_ / "photos");
  driven_.press("Ctrl+Shift+T");
  for (int i = 0; i < 3; ++i) draw();
  EXPECT_TRUE(shows("Train from photographs"));
  driven_.apply(action::toggle_open_dialog, Choosing::photographs);
  for (int i = 0; i < 3; ++i) draw();
  EXPECT_TRUE(shows("Folder of the photographs"));
  EXPECT_FALSE(shows("Train from photographs"));
  draw("photos");
  draw("", ImGuiKey_Enter);
  EXPECT_FALSE(driven_.viewer.panels.open);
  EXPECT_EQ(driven_.viewer.train_form.data, (folder_ / "photos").string());
  for (int i = 0; i < 3; ++i) draw();
  EXPECT_TRUE(shows("Train from photographs"));
  EXPECT_THAT(driven_.opened, IsEmpty());
  EXPECT_THAT(driven_.trained, IsEmpty()) << "Enter was the other dialog's";
  draw("", ImGuiKey_Enter);
  ASSERT_THAT(driven_.trained, SizeIs(1));
  EXPECT_EQ(driven_.trained[0].data, folder_ / "photos");
}

TEST_F(PanelsTest, a_test_view_fits_its_panel_in_every_window_and_its_buttons_step) {
  auto views = std::make_shared<TestViews>();
  for (const glm::ivec2 size : {glm::ivec2(4000, 3000), glm::ivec2(300, 400), glm::ivec2(4000, 5)})
    views->cameras.push_back(look_at({0, 0, -3}, {0, 0, 0}, {0, -1, 0}, 1, size.x, size.y));
  driven_.apply(action::training_began, driven_.viewer.scene->path,
                std::shared_ptr<const TestViews>(views));
  for (const ImVec2 size : {ImVec2(320, 240), ImVec2(640, 400), ImVec2(3840, 2160)}) {
    ImGui::GetIO().DisplaySize = size;
    for (int view = 0; view < 3; ++view) {
      for (int i = 0; i < 3; ++i) draw();
      const ImGuiWindow* bar = ImGui::FindWindowByName("right bar");
      ASSERT_TRUE(bar != nullptr && bar->Active);
      EXPECT_LE(bar->ContentSize.x, bar->InnerRect.GetWidth() + 1) << size.x << ", view " << view;
      driven_.apply(action::step_test_view, 1);
    }
  }
  EXPECT_EQ(driven_.viewer.training->test_view.view, 0u);
}

// The texts that ImGui drew in a panel behind the call of log_panel().
std::string g_logged;
void log_panel() {
  ImGui::GetIO().SetClipboardTextFn = [](void*, const char* text) { g_logged = text; };
  ImGui::LogToClipboard();
}

TEST_F(PanelsTest, a_panel_of_the_table_is_drawn) {
  std::vector<PanelRow> rows(panel_rows().begin(), panel_rows().end());
  rows.push_back({&Panels::cameras, "count", "Count", [](const Viewer& v) -> Blocks {
                    log_panel();
                    return {block::Text{std::to_string(v.keyframes.size()) + " keyframes"},
                            block::Controls{{{"Set here"}}}};
                  }});
  state_.rows = rows;
  draw();
  EXPECT_EQ(g_logged, "") << "it is closed";
  driven_.press("L");
  driven_.press("K");
  for (int i = 0; i < 2; ++i) draw();
  EXPECT_THAT(g_logged, testing::HasSubstr("1 keyframes"));
  EXPECT_THAT(g_logged, testing::HasSubstr("Set here"));
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

// The panels' windows, apart from the invisible handles of edges and ImGui's own.
std::vector<Rect> opaque_windows() {
  std::vector<Rect> rects;
  for (const ImGuiWindow* window : ImGui::GetCurrentContext()->Windows) {
    if (!window->Active || (window->Flags & ImGuiWindowFlags_NoBackground) != 0 ||
        std::string_view(window->Name).starts_with("Debug"))
      continue;
    const ImRect rect = window->Rect();
    rects.push_back({{rect.Min.x, rect.Min.y}, {rect.Max.x, rect.Max.y}});
  }
  return rects;
}

TEST_F(PanelsTest, no_panel_covers_the_picture) {
  driven_.apply([](Viewer& viewer) {
    viewer.panels = {};
    viewer.panels.hud = viewer.panels.info = viewer.panels.cameras = viewer.panels.recorder = true;
    viewer.panels.inspector = viewer.panels.split = viewer.panels.messages = true;
  });
  for (const ImVec2 size : {ImVec2(1280, 720), ImVec2(1024, 640), ImVec2(1920, 1080)}) {
    ImGui::GetIO().DisplaySize = size;
    for (int i = 0; i < 3; ++i) draw();
    const Rect picture =
        layout_of(driven_.viewer, {{size.x, size.y}, ImGui::GetFontSize(), ImGui::GetFrameHeight()})
            .picture;
    EXPECT_GT(picture.size().x, 0.35f * size.x);
    const std::vector<Rect> rects = opaque_windows();
    EXPECT_GE(rects.size(), 3u);  // the menu and two bars
    for (const Rect& rect : rects) {
      const Rect both{glm::max(rect.low, picture.low), glm::min(rect.high, picture.high)};
      EXPECT_TRUE(both.empty()) << rect.low.x << " " << rect.low.y << " to " << rect.high.x << " "
                                << rect.high.y;
    }
  }
}

TEST_F(PanelsTest, a_bar_is_resized_by_its_edge_and_a_panel_closed_by_its_header) {
  driven_.press("F10");
  draw();
  const float edge = layout_of(driven_.viewer, {{1280, 720}, ImGui::GetFontSize(), 20}).left.high.x;
  ImGuiIO& io = ImGui::GetIO();
  const auto mouse = [&](float x, bool down) {
    io.MousePos = {x, 400};
    io.MouseDown[0] = down;
    draw();
  };
  mouse(edge, false);
  mouse(edge, true);
  mouse(edge - 60, true);
  mouse(edge - 60, false);
  EXPECT_NEAR(driven_.viewer.bars.left * ImGui::GetFontSize(), edge - 60, 1);
  EXPECT_EQ(driven_.viewer.bars.right, 0);
}

// Presses and releases the left button at a place; true if a panel takes the mouse.
bool clicked_at(const std::function<void()>& draw, ImVec2 at) {
  ImGuiIO& io = ImGui::GetIO();
  io.MousePos = at;
  draw();
  draw();
  const bool captured = io.WantCaptureMouse;
  io.MouseDown[0] = true;
  draw();
  io.MouseDown[0] = false;
  draw();
  draw();
  return captured;
}

TEST_F(PanelsTest, a_written_file_is_opened_and_its_path_copied_from_its_message) {
  const auto draw_it = [this] { draw(); };
  const std::filesystem::path file = "/a/very/long/path" + std::string(300, 'x') + "/picture.png";
  driven_.apply(action::notify_file, file, std::string());
  draw();
  draw();
  const ImGuiWindow* toast = ImGui::FindWindowByName("toast 0");
  ASSERT_NE(toast, nullptr);
  EXPECT_LT(toast->Size.x, 0.6f * 1280) << "the path is shortened";
  const ImGuiStyle& style = ImGui::GetStyle();
  const float y =
      toast->Pos.y + toast->Size.y - style.WindowPadding.y - 0.5f * ImGui::GetFrameHeight();
  const float open = toast->Pos.x + style.WindowPadding.x + 10;
  const float copy =
      open + ImGui::CalcTextSize("Open").x + 2 * style.FramePadding.x + style.ItemSpacing.x;
  EXPECT_TRUE(clicked_at(draw_it, {open, y}));
  EXPECT_THAT(driven_.opened_outside, testing::ElementsAre(file));
  EXPECT_TRUE(driven_.viewer.toasts_held);
  EXPECT_TRUE(clicked_at(draw_it, {copy, y}));
  EXPECT_EQ(driven_.text, file.string());
  ImGui::GetIO().MousePos = {640, 200};
  draw();
  draw();
  EXPECT_FALSE(driven_.viewer.toasts_held);
  EXPECT_FALSE(ImGui::GetIO().WantCaptureMouse);
}

TEST_F(PanelsTest, a_click_on_a_message_takes_it_away_and_does_not_reach_the_picture) {
  driven_.apply(action::notify, "here");
  draw();
  draw();
  const ImGuiWindow* toast = ImGui::FindWindowByName("toast 0");
  ASSERT_NE(toast, nullptr);
  EXPECT_TRUE(clicked_at([this] { draw(); }, toast->Rect().GetCenter()));
  EXPECT_THAT(driven_.viewer.toasts, IsEmpty());
}

TEST_F(PanelsTest, a_click_of_a_tool_reaches_the_picture_below_a_message_without_buttons) {
  driven_.apply(action::choose_tool, std::optional(SelectTool::lasso));
  driven_.apply(action::notify, "here");
  draw();
  draw();
  const ImGuiWindow* toast = ImGui::FindWindowByName("toast 0");
  ASSERT_NE(toast, nullptr);
  EXPECT_FALSE(clicked_at([this] { draw(); }, toast->Rect().GetCenter()));
  driven_.apply(action::notify_file, std::filesystem::path("/a.png"), std::string());
  draw();
  draw();
  EXPECT_TRUE(clicked_at([this] { draw(); }, toast->Rect().GetCenter()));
}

TEST_F(PanelsTest, messages_and_the_strip_of_first_views_are_visible_in_their_first_drawing) {
  driven_.apply(action::notify_file, std::filesystem::path("/a.png"), std::string());
  driven_.apply([](Viewer& viewer) {
    viewer.scene->candidates = {viewer.scene->framing, viewer.scene->framing};
    viewer.view_choice.pictures = std::make_shared<const Image>(480, 135, 3);
  });
  state_.candidates = 1;
  draw();
  for (const char* name : {"toast 0", "First view"}) {
    const ImGuiWindow* window = ImGui::FindWindowByName(name);
    ASSERT_NE(window, nullptr) << name;
    EXPECT_FALSE(window->Hidden) << name;
    EXPECT_LE(window->ContentSize.y, window->InnerRect.GetHeight()) << name;
  }
}

TEST_F(PanelsTest, the_strip_of_first_views_chooses_by_a_click_and_closes_by_escape) {
  driven_.apply([](Viewer& viewer) {
    viewer.scene->cameras.clear();
    viewer.scene->candidates = {viewer.scene->framing, viewer.scene->framing};
    viewer.scene->candidates[1].eye = {4, -1, 0};
    viewer.view_choice.pictures = std::make_shared<const Image>(480, 135, 3);
  });
  state_.candidates = 1;
  for (const bool escapes : {true, false}) {
    driven_.apply([](Viewer& viewer) {
      viewer.view_choice.pictures = std::make_shared<const Image>(480, 135, 3);
    });
    for (int i = 0; i < 3; ++i) draw();
    ASSERT_TRUE(shows("First view"));
    if (escapes) {
      draw("", ImGuiKey_Escape);
    } else {
      const ImRect rect = ImGui::FindWindowByName("First view")->Rect();
      const ImVec2 right{rect.Max.x - 60, rect.Max.y - 40};
      EXPECT_TRUE(clicked_at([this] { draw(); }, right));
    }
    draw();
    EXPECT_FALSE(shows("First view"));
    EXPECT_EQ(driven_.viewer.first_views.size(), escapes ? 0u : 1u);
  }
  EXPECT_LT(glm::distance(driven_.viewer.camera.position(), glm::dvec3(4, -1, 0)), 1e-9);
}

TEST_F(PanelsTest, a_bookmark_is_renamed_in_its_field) {
  const PanelRow row{&Panels::cameras, "bookmarks", "Bookmarks",
                     [](const Viewer&) -> Blocks { return {block::Local::bookmarks}; }};
  state_.rows = {&row, 1};
  driven_.press("Ctrl+D");
  for (int i = 0; i < 3; ++i) draw();
  const ImRect bar = ImGui::FindWindowByName("right bar")->Rect();
  const ImGuiStyle& style = ImGui::GetStyle();
  const float y =
      bar.Min.y + style.WindowPadding.y + 1.5f * ImGui::GetFrameHeight() + style.ItemSpacing.y;
  EXPECT_TRUE(clicked_at([this] { draw(); }, {bar.Max.x - 30, y}));
  draw(" of the door");
  draw();
  EXPECT_THAT(bookmarks_of(driven_.viewer)[0].first, testing::HasSubstr(" of the door"));
}

TEST_F(PanelsTest, without_a_scene_the_window_welcomes) {
  driven_.apply([](Viewer& viewer) { viewer.scene.reset(); });
  draw();
  EXPECT_TRUE(shows("Welcome"));
  driven_.apply([](Viewer& viewer) { viewer.loading = Loading{"/a.ply", "reading", 0}; });
  draw();
  EXPECT_FALSE(shows("Welcome"));
  EXPECT_TRUE(shows("Loading"));
}

TEST(Hints, each_goes_away_once_it_is_followed) {
  DrivenScene driven(0);
  driven.apply([](Viewer& viewer) { viewer.hints = {true, true, true, true}; });
  driven.press("H");
  EXPECT_FALSE(driven.viewer.hints.map);
  driven.apply(action::fly, glm::dvec3(0, 0, 1), 1.0);
  EXPECT_FALSE(driven.viewer.hints.fly);
  driven.press("Z");
  EXPECT_FALSE(driven.viewer.hints.zoom);
  EXPECT_TRUE(driven.viewer.hints.modes);
  driven.press("1");
  EXPECT_FALSE(driven.viewer.hints.modes);
}

// Relative luminance and contrast as the Web Content Accessibility Guidelines define them.
double luminance(ImVec4 color) {
  const auto linear = [](float value) {
    const auto v = static_cast<double>(value);
    return v <= 0.03928 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
  };
  return 0.2126 * linear(color.x) + 0.7152 * linear(color.y) + 0.0722 * linear(color.z);
}

double contrast(const ImVec4& a, const ImVec4& b) {
  const auto [low, high] = std::minmax({luminance(a), luminance(b)});
  return (high + 0.05) / (low + 0.05);
}

TEST_F(PanelsTest, every_text_is_legible_on_its_backgrounds_in_both_themes) {
  const ImVec4* colors = ImGui::GetStyle().Colors;
  // Text, faint text and the other tones, on the backgrounds that they are drawn on.
  const std::pair<std::vector<int>, std::vector<const ImVec4*>> cases[] = {
      {{ImGuiCol_FrameBgHovered, ImGuiCol_FrameBgActive, ImGuiCol_Button, ImGuiCol_ButtonHovered,
        ImGuiCol_ButtonActive, ImGuiCol_HeaderActive, ImGuiCol_SliderGrab,
        ImGuiCol_SliderGrabActive, ImGuiCol_PlotHistogram, ImGuiCol_TitleBg, ImGuiCol_TitleBgActive,
        ImGuiCol_TitleBgCollapsed},
       {&palette::kText}},
      {{ImGuiCol_FrameBg, ImGuiCol_Header, ImGuiCol_HeaderHovered, ImGuiCol_TableHeaderBg},
       {&palette::kText, &palette::kFaint}},
      {{ImGuiCol_WindowBg, ImGuiCol_PopupBg, ImGuiCol_MenuBarBg},
       {&palette::kText, &palette::kFaint, &palette::kAccent, &palette::kCaution,
        &palette::kError}}};
  for (const bool is_light : {false, true}) {
    apply_style(1, is_light);
    for (const auto& [backgrounds, texts] : cases) {
      for (const int background : backgrounds) {
        for (std::size_t i = 0; i < texts.size(); ++i)
          EXPECT_GT(contrast(*texts[i], colors[background]), 4.5)
              << ImGui::GetStyleColorName(background) << ", text " << i << ", light " << is_light;
      }
    }
    EXPECT_EQ(luminance(palette::kPanel) > 0.5, is_light);
  }
  apply_style(1);
}

TEST_F(PanelsTest, the_colour_of_every_mode_is_legible_on_plates_in_both_themes) {
  for (const bool is_light : {false, true}) {
    apply_style(1, is_light);
    for (CullMode mode = 1; mode <= culler_count(); ++mode)
      EXPECT_GT(contrast(palette::text_of(ink_of(mode)), palette::kPanel), 4.5)
          << mode_name(mode) << ", light " << is_light;
  }
  apply_style(1);
}

// Rows of all modes with FPS from 100 to 1000.
void measure(Viewer& viewer) {
  viewer.numbers.version = viewer.view_version;
  for (CullMode mode = 1; mode <= culler_count(); ++mode) {
    BenchRow& row = viewer.numbers.rows.emplace_back();
    row.mode = mode_name(mode);
    row.round_ms = {1.0 * mode, 1.001 * mode, 0.999 * mode};
    row.ms_median = mode;
    row.fps_median = 1000.0 / mode;
    row.frames = 3;
  }
}

TEST_F(PanelsTest, no_number_of_the_table_stands_on_a_bar) {
  driven_.apply(measure);
  driven_.press("F10");
  for (const ImVec2 size : {ImVec2(640, 400), ImVec2(1280, 720), ImVec2(3840, 2160)}) {
    ImGui::GetIO().DisplaySize = size;
    for (int i = 0; i < 3; ++i) draw();
    const ImVector<ImDrawVert>& points = ImGui::FindWindowByName("left bar")->DrawList->VtxBuffer;
    const ImU32 text = ImGui::GetColorU32(palette::kText);
    int bars = 0;
    for (int i = 0; i + 3 < points.Size; ++i) {
      const ImVec2 low = points[i].pos, high = points[i + 2].pos;
      const bool is_bar = points[i].col >> IM_COL32_A_SHIFT == 115 &&
                          points[i].col == points[i + 2].col && high.x > low.x && high.y > low.y;
      if (!is_bar) continue;
      ++bars;
      for (const ImDrawVert& point : points) {
        const bool is_on_it = point.pos.x > low.x + 1 && point.pos.x < high.x - 1 &&
                              point.pos.y > low.y && point.pos.y < high.y;
        ASSERT_FALSE(point.col == text && is_on_it) << size.x;
      }
    }
    EXPECT_GE(bars, culler_count()) << size.x;
  }
}

TEST_F(PanelsTest, the_tooltip_of_a_row_covers_no_row) {
  driven_.apply(measure);
  driven_.press("F10");
  for (int i = 0; i < 3; ++i) draw();
  const ImRect bar = ImGui::FindWindowByName("left bar")->Rect();
  const float line = ImGui::GetTextLineHeight() + 2 * ImGui::GetStyle().CellPadding.y;
  ImGui::GetIO().MousePos = {bar.Min.x + 40, bar.Min.y + 2 * ImGui::GetFrameHeight() + 2 * line};
  for (int i = 0; i < 3; ++i) draw();
  const ImGuiWindow* tooltip = ImGui::FindWindowByName("##Tooltip_00");
  ASSERT_TRUE(tooltip != nullptr && tooltip->Active);
  EXPECT_GE(tooltip->Pos.x, bar.Max.x);
}

TEST_F(PanelsTest, arrow_keys_and_enter_choose_in_an_open_list) {
  const PanelRow row{
      &Panels::hud, "sizes", "Sizes", [](const Viewer&) -> Blocks {
        return {block::Controls{{{"measure at", block::kWholeLine, false, {}, "measure at"}}}};
      }};
  state_.rows = {&row, 1};
  driven_.press("F10");
  for (int i = 0; i < 3; ++i) draw();
  EXPECT_EQ(ImGui::GetIO().ConfigFlags & ImGuiConfigFlags_NavEnableKeyboard, 0);
  const ImRect bar = ImGui::FindWindowByName("left bar")->Rect();
  const ImGuiStyle& style = ImGui::GetStyle();
  const float y =
      bar.Min.y + style.WindowPadding.y + 1.5f * ImGui::GetFrameHeight() + style.ItemSpacing.y;
  clicked_at([this] { draw(); }, {bar.Max.x - 60, y});
  ImGui::GetIO().MousePos = {640, 600};
  for (int i = 0; i < 3; ++i) draw();
  EXPECT_NE(ImGui::GetIO().ConfigFlags & ImGuiConfigFlags_NavEnableKeyboard, 0);
  draw("", ImGuiKey_DownArrow);
  draw();
#if IMGUI_VERSION_NUM >= 18700
  draw("", ImGuiKey_Enter);
#else
  draw("", ImGuiKey_Space);  // the window gives this name to Enter
#endif
  for (int i = 0; i < 3; ++i) draw();
  EXPECT_EQ(driven_.viewer.measured_size, 1u);
  EXPECT_EQ(ImGui::GetIO().ConfigFlags & ImGuiConfigFlags_NavEnableKeyboard, 0);
}

TEST_F(PanelsTest, a_map_that_is_computed_has_its_title_at_once) {
  const auto legend_height = [this] {
    for (int i = 0; i < 2; ++i) draw();
    return shows("Heat map") ? ImGui::FindWindowByName("Heat map")->Size.y : 0;
  };
  EXPECT_EQ(legend_height(), 0);
  driven_.press("H");
  const float waits = legend_height();
  EXPECT_GT(waits, 0);
  driven_.apply([](Viewer& viewer) {
    viewer.shown.heatmap = Heatmap{HeatQuantity::pairs, 1, 1, 640, {5}};
    viewer.shown.map_scale = {1, 5};
  });
  EXPECT_GT(legend_height(), waits + 20) << "the scale is shown";
  driven_.press("Shift+H");
  EXPECT_FLOAT_EQ(legend_height(), waits) << "the scale of the map before is not shown";
}

TEST_F(PanelsTest, what_floats_does_not_overlap_in_the_smallest_window) {
  ImGui::GetIO().DisplaySize = {320, 240};
  driven_.apply([](Viewer& viewer) {
    viewer.shown.heatmap = Heatmap{HeatQuantity::pairs, 1, 1, 640, {5}};
    viewer.shown.map_scale = {1, 5};
    viewer.heatmap = HeatQuantity::pairs;
    viewer.loading = Loading{"/a/long/name/of/a/scene/garden.ply", "reading", 0.5f};
  });
  driven_.apply(action::notify, "a message of some words that needs several lines");
  driven_.press("I");
  for (int i = 0; i < 3; ++i) draw();
  EXPECT_TRUE(shows("toast 0"));
  const std::vector<Rect> rects = opaque_windows();
  for (std::size_t i = 0; i < rects.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const Rect both{glm::max(rects[i].low, rects[j].low), glm::min(rects[i].high, rects[j].high)};
      EXPECT_TRUE(both.empty()) << i << ", " << j;
    }
  }
}

TEST(CommandHints, name_commands_that_exist_and_their_keys) {
  EXPECT_EQ(command_hint("Flip the split"), "Flip the split (X)");
  EXPECT_EQ(command_hint("Open a file"), "Open a file (Ctrl+O)");
  const std::filesystem::path viewer = test::source_path("src/app/viewer");
  const std::regex call(R"re(command_(?:tooltip|hint|row)\((?:"[^"]*",\s*)?"([^"]*)")re");
  int hints = 0;
  for (const char* folder : {"panels", "commands"})
    for (const auto& file : std::filesystem::directory_iterator(viewer / folder)) {
      const std::string text = read_text_file(file.path(), 1 << 20);
      for (std::sregex_iterator at(text.begin(), text.end(), call), end; at != end; ++at, ++hints)
        EXPECT_NE(command_hint((*at)[1].str()), (*at)[1].str()) << file.path();
    }
  EXPECT_GT(hints, 12);
}

}  // namespace
}  // namespace qs
