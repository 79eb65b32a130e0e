// SPDX-License-Identifier: MIT
//
// The scale of the interface and the size of the first window.
#include <gtest/gtest.h>

#include "app/support/driven_viewer.h"
#include "app/viewer/state/layout.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

namespace qs {
namespace {

using test::Driven;
using namespace action;

TEST(InterfaceScale, is_the_system_s_or_follows_the_size_of_the_screen) {
  EXPECT_EQ(guessed_scale(1, {1280, 720}), 1);
  EXPECT_EQ(guessed_scale(1, {1920, 1080}), 1);
  EXPECT_EQ(guessed_scale(1, {640, 400}), 1);
  EXPECT_EQ(guessed_scale(1, {2560, 1440}), 1);
  EXPECT_GE(guessed_scale(1, {3840, 2160}), 1.5f);
  EXPECT_LE(guessed_scale(1, {3840, 2160}), 2.0f);
  EXPECT_EQ(guessed_scale(1, {7680, 4320}), 2);
  EXPECT_EQ(guessed_scale(1.5f, {3840, 2160}), 1.5f) << "the system knows better";
  EXPECT_EQ(guessed_scale(1.33f, {1920, 1080}), 1.25f);
  EXPECT_EQ(guessed_scale(5, {1920, 1080}), 3);
}

TEST(InterfaceScale, keys_step_from_75_to_300_percent_and_back_to_100) {
  Driven driven;
  driven.apply([](Viewer& viewer) { viewer.screen_scale = 1.75f; });
  EXPECT_EQ(interface_scale(driven.viewer), 1.75f);
  driven.press("Ctrl+=");
  EXPECT_EQ(interface_scale(driven.viewer), 2);
  EXPECT_EQ(driven.viewer.toasts.back().text, "interface at 200 %");
  for (int i = 0; i < 9; ++i) driven.press("Ctrl+=");
  EXPECT_EQ(interface_scale(driven.viewer), 3);
  for (int i = 0; i < 20; ++i) driven.press("Ctrl+-");
  EXPECT_EQ(interface_scale(driven.viewer), 0.75f);
  driven.press("Ctrl+0");
  EXPECT_EQ(interface_scale(driven.viewer), 1);
  const KeyCommand* larger = find_key_command(GLFW_KEY_EQUAL, GLFW_MOD_CONTROL);
  EXPECT_EQ(find_key_command(GLFW_KEY_EQUAL, GLFW_MOD_CONTROL | GLFW_MOD_SHIFT), larger);
  EXPECT_EQ(find_key_command(GLFW_KEY_KP_ADD, GLFW_MOD_CONTROL), larger);
  EXPECT_EQ(find_key_command(GLFW_KEY_KP_SUBTRACT, GLFW_MOD_CONTROL),
            find_key_command(GLFW_KEY_MINUS, GLFW_MOD_CONTROL));
}

TEST(FirstWindow, takes_four_fifths_of_the_screen) {
  EXPECT_EQ(first_window_size({1920, 1080}), glm::ivec2(1536, 864));
  EXPECT_EQ(first_window_size({3840, 2160}), glm::ivec2(3072, 1728));
  EXPECT_EQ(first_window_size({700, 410}), glm::ivec2(640, 400));
  EXPECT_EQ(first_window_size({320, 240}), glm::ivec2(320, 240));
}

}  // namespace
}  // namespace qs
