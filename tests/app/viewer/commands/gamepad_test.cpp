// SPDX-License-Identifier: MIT
//
// The gamepad: sticks and triggers as motion, buttons as keys.
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <glm/geometric.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/framing/camera_control.h"
#include "app/support/driven_viewer.h"
#include "app/viewer/commands/input.h"

namespace qs {
namespace {

using test::DrivenScene;
using testing::IsEmpty;
using testing::SizeIs;

// A gamepad at rest.
GLFWgamepadstate resting() {
  GLFWgamepadstate pad{};
  pad.axes[GLFW_GAMEPAD_AXIS_LEFT_TRIGGER] = pad.axes[GLFW_GAMEPAD_AXIS_RIGHT_TRIGGER] = -1;
  return pad;
}

PadMotion moved(std::initializer_list<std::pair<int, float>> axes) {
  GLFWgamepadstate pad = resting();
  for (const auto& [axis, value] : axes) pad.axes[axis] = value;
  return pad_motion(pad);
}

TEST(Gamepad, sticks_and_triggers_move_and_turn) {
  EXPECT_EQ(moved({{GLFW_GAMEPAD_AXIS_LEFT_Y, -1}}).direction, glm::dvec3(0, 0, 1)) << "forward";
  EXPECT_EQ(moved({{GLFW_GAMEPAD_AXIS_LEFT_X, 1}}).direction, glm::dvec3(1, 0, 0)) << "right";
  EXPECT_EQ(moved({{GLFW_GAMEPAD_AXIS_LEFT_TRIGGER, 1}}).direction, glm::dvec3(0, 1, 0)) << "down";
  EXPECT_EQ(moved({{GLFW_GAMEPAD_AXIS_RIGHT_TRIGGER, 1}}).direction, glm::dvec3(0, -1, 0)) << "up";
  EXPECT_EQ(moved({{GLFW_GAMEPAD_AXIS_RIGHT_X, 1}}).turn, glm::dvec2(2, 0));
  EXPECT_EQ(moved({{GLFW_GAMEPAD_AXIS_RIGHT_Y, -1}}).turn, glm::dvec2(0, -2));
}

TEST(Gamepad, rests_inside_of_the_dead_zone_and_grows_from_nothing_at_its_edge) {
  const auto forward = [](float value) {
    return moved({{GLFW_GAMEPAD_AXIS_LEFT_Y, -value}}).direction.z;
  };
  EXPECT_EQ(forward(0), 0);
  EXPECT_EQ(forward(0.149f), 0);
  EXPECT_NEAR(forward(0.151f), 0.001 / 0.85, 1e-6);
  EXPECT_NEAR(forward(0.575f), 0.5, 1e-6);
  EXPECT_EQ(forward(1), 1);
  EXPECT_EQ(moved({{GLFW_GAMEPAD_AXIS_RIGHT_TRIGGER, -0.71f}}).direction, glm::dvec3(0));
  // Diagonally too: a stick in a corner is not faster, and the zone is a circle.
  EXPECT_NEAR(glm::length(moved({{0, 1.0f}, {1, 1.0f}}).direction), 1, 1e-12);
  EXPECT_EQ(moved({{0, 0.1f}, {1, 0.1f}}).direction, glm::dvec3(0));
  EXPECT_NE(moved({{0, 0.12f}, {1, 0.12f}}).direction, glm::dvec3(0));
}

TEST(Gamepad, flies_as_fast_as_keys_and_looks_to_the_right) {
  DrivenScene driven(0);
  Input input;
  GLFWgamepadstate pad = resting();
  const auto read = [&] {
    Actions actions;
    input.gamepad(&pad, 0.1, actions);
    driven.apply_all(actions);
    return actions.size();
  };
  EXPECT_EQ(read(), 0u);
  EXPECT_TRUE(input.busy()) << "the loop looks at it";
  EXPECT_FALSE(driven.viewer.moving()) << "nothing is drawn at rest";
  pad.axes[GLFW_GAMEPAD_AXIS_LEFT_Y] = -1;
  EXPECT_EQ(read(), 1u);
  EXPECT_TRUE(driven.viewer.moving());
  const glm::dvec3 wish = driven.viewer.flight.wish;
  driven.apply(action::fly, glm::dvec3(0, 0, 1), 1.0);
  EXPECT_EQ(driven.viewer.flight.wish, wish);
  pad.buttons[GLFW_GAMEPAD_BUTTON_LEFT_THUMB] = GLFW_PRESS;
  read();
  EXPECT_EQ(driven.viewer.flight.wish, 5.0 * wish);
  pad = resting();
  pad.axes[GLFW_GAMEPAD_AXIS_RIGHT_X] = 1;
  const ViewAxes before = view_axes(driven.viewer.camera);
  const glm::dvec3 place = driven.viewer.camera.position();
  EXPECT_EQ(read(), 1u);
  const glm::dvec3 forward = view_axes(driven.viewer.camera).forward;
  EXPECT_NEAR(glm::dot(forward, before.right), std::sin(0.2), 0.01) << "2 radians per second";
  EXPECT_LT(glm::distance(driven.viewer.camera.position(), place), 1e-9);
  pad = resting();
  pad.axes[GLFW_GAMEPAD_AXIS_RIGHT_Y] = -1;
  read();
  EXPECT_LT(glm::dot(view_axes(driven.viewer.camera).forward, before.down), -0.1) << "up";
}

TEST(Gamepad, buttons_do_what_keys_do_once) {
  DrivenScene driven(2);
  Input input;
  GLFWgamepadstate pad = resting();
  const auto press = [&](int button) {
    for (const bool is_down : {true, true, false}) {
      pad.buttons[button] = is_down ? GLFW_PRESS : GLFW_RELEASE;
      Actions actions;
      input.gamepad(&pad, 0.01, actions);
      driven.apply_all(actions);
    }
  };
  driven.apply(action::set_mode, 1);
  press(GLFW_GAMEPAD_BUTTON_LEFT_BUMPER);
  EXPECT_EQ(driven.viewer.mode(), culler_count());
  for (int i = 0; i < 2; ++i) press(GLFW_GAMEPAD_BUTTON_RIGHT_BUMPER);
  EXPECT_EQ(driven.viewer.mode(), 2);
  press(GLFW_GAMEPAD_BUTTON_X);
  EXPECT_TRUE(driven.viewer.heatmap) << "it did not toggle twice";
  press(GLFW_GAMEPAD_BUTTON_DPAD_RIGHT);
  EXPECT_EQ(driven.viewer.dataset_camera, 1);
  press(GLFW_GAMEPAD_BUTTON_A);
  EXPECT_EQ(driven.viewer.dataset_camera, 0);
  press(GLFW_GAMEPAD_BUTTON_B);
  EXPECT_EQ(driven.viewer.dataset_camera, 1);
  driven.press("Ctrl+O");
  press(GLFW_GAMEPAD_BUTTON_X);
  EXPECT_TRUE(driven.viewer.heatmap) << "not while a dialog is open";
}

TEST(Gamepad, without_one_nothing_happens) {
  Input input;
  Actions actions;
  GLFWgamepadstate pad = resting();
  pad.axes[GLFW_GAMEPAD_AXIS_LEFT_X] = 1;
  pad.buttons[GLFW_GAMEPAD_BUTTON_A] = GLFW_PRESS;
  input.gamepad(&pad, 0.01, actions);
  EXPECT_THAT(actions, SizeIs(2));
  actions.clear();
  input.gamepad(nullptr, 0.01, actions);
  EXPECT_THAT(actions, IsEmpty());
  EXPECT_FALSE(input.busy());
}

}  // namespace
}  // namespace qs
