// SPDX-License-Identifier: MIT
//
// Pixels and gestures of the real window against computations without it: colours of maps, mouse,
// keyboard, full screen.
#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/framing/camera_control.h"
#include "app/picture/legend.h"
#include "app/picture/palette.h"
#include "app/support/program_in_window.h"
#include "app/support/virtual_display.h"
#include "io/camera/cameras.h"
#include "io/picture/image_file.h"
#include "raster/api/renderer.h"
#include "support/pool.h"
#include "support/scene_files.h"

namespace qs {
namespace {

using nlohmann::json;

class ViewerWindow : public test::ProgramInWindow {
 protected:
  Camera camera(const std::string& name) const {
    return parse_camera(state(name)["camera"].dump(), name);
  }

  Frame frame(const char* mode) {
    const auto renderer = make_renderer(Backend::cpu, test::pool(2));
    renderer->upload(test::read_scene(path("scene.ply")).cloud, {});
    RenderSettings settings;
    settings.mode = find_culler(mode);
    Outputs outputs;
    outputs.pairs = true;
    return renderer->render(test::front_camera(320, 240), settings, outputs);
  }
};

float gray(const Image& image, int x, int y) {
  return 0.299f * image.at(x, y, 0) + 0.587f * image.at(x, y, 1) + 0.114f * image.at(x, y, 2);
}

// The map's colours, lightened and darkened by half of the picture's own contrast, which is the
// difference from the average around each pixel. `color(tile, gray, detail)` is the colour of a
// pixel.
template <class Color>
void expect_map(const Image& window, const Image& picture, const Color& color) {
  const int columns = picture.width / 16, rows = picture.height / 16;
  std::vector<float> averages(static_cast<std::size_t>(columns * rows), 0.0f);
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x)
      averages[static_cast<std::size_t>(y / 16 * columns + x / 16)] += gray(picture, x, y) / 256;
  }
  const auto average = [&](int column, int row) {
    return averages[static_cast<std::size_t>(std::clamp(row, 0, rows - 1) * columns +
                                             std::clamp(column, 0, columns - 1))];
  };
  constexpr int kAboveLegend = 96;
  double sum = 0;
  float largest = 0;
  for (int y = 0; y < kAboveLegend; ++y) {
    for (int x = 0; x < picture.width; ++x) {
      const float u = (static_cast<float>(x) + 0.5f) / 16 - 0.5f,
                  v = (static_cast<float>(y) + 0.5f) / 16 - 0.5f;
      const int left = static_cast<int>(std::floor(u)), top = static_cast<int>(std::floor(v));
      const float fx = u - std::floor(u), fy = v - std::floor(v);
      const float around =
          (average(left, top) * (1 - fx) + average(left + 1, top) * fx) * (1 - fy) +
          (average(left, top + 1) * (1 - fx) + average(left + 1, top + 1) * fx) * fy;
      const float here = gray(picture, x, y);
      const glm::vec3 map =
          color(static_cast<std::size_t>(y / 16 * columns + x / 16), here, here - around);
      for (int c = 0; c < 3; ++c) {
        const float expected = std::clamp(map[c], 0.0f, 1.0f);
        const float error = std::abs(window.at(x, y, c) - expected);
        sum += static_cast<double>(error);
        largest = std::max(largest, error);
      }
    }
  }
  EXPECT_LT(sum / (3 * kAboveLegend * picture.width), 1.5 / 255);
  EXPECT_LT(largest, 8.0f / 255);
}

TEST_F(ViewerWindow, maps_have_the_colours_of_their_values) {
  const test::ProgramRun run = play("key Tab\nkey H\nwait\nshot " + path("heat.png") +
                                        "\nkey H\nkey C\nkey Shift+C\nkey Shift+C\n" +
                                        "key Shift+C\nwait\nshot " + path("pairs.png") + "\nquit\n",
                                    {path("scene.ply"), "--cull", "quadbox"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Frame quadbox = frame("quadbox"), box = frame("3dgs");
  const auto high = static_cast<float>(scale_for(box.pairs).maximum);  // of the baseline
  const auto counted = [&](std::size_t tile, float light, float detail) {
    const float place = std::min(1.0f, static_cast<float>(quadbox.pairs[tile]) / high);
    return quadbox.pairs[tile] == 0 ? glm::vec3(0.05f + 0.08f * light)
                                    : (1 + 0.5f * detail) * viridis(0.2f + 0.8f * place);
  };
  expect_map(read_image(path("heat.png")), quadbox.color, counted);
  std::vector<std::int32_t> differences;  // of the first variant minus the other
  for (std::size_t i = 0; i < box.pairs.size(); ++i)
    differences.push_back(static_cast<std::int32_t>(quadbox.pairs[i]) -
                          static_cast<std::int32_t>(box.pairs[i]));
  const auto most = static_cast<float>(scale_for_signed(differences).maximum);
  const auto compared = [&](std::size_t tile, float, float detail) {
    const float place = static_cast<float>(differences[tile]) / most;
    return (1 + 0.5f * detail) * diverging(std::clamp(place, -1.0f, 1.0f));
  };
  expect_map(read_image(path("pairs.png")), quadbox.color, compared);
}

TEST_F(ViewerWindow, mouse_and_wheel_move_the_camera_by_exact_angles) {
  const test::ProgramRun run =
      play("key Tab\nwait\nkey V\nstate " + path("a") +
               "\nmove 160 120\nsleep 0.1\ndrag 40 10 left\nwait\nstate " + path("b") +
               "\nwheel 2 Shift\nwait\nstate " + path("c") + "\nwheel 3 Ctrl\nwait\nstate " +
               path("d") + "\nkey Home\nkey V\nsleep 0.4\nmove 160 120\ndoubleclick\nwait\nstate " +
               path("e") + "\nmove 100 90\nclick\nwait\nstate " + path("f") + "\nquit\n",
           {path("scene.ply")});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto expect_camera = [](const Camera& actual, const Camera& expected) {
    for (int column = 0; column < 4; ++column)
      EXPECT_LT(glm::distance(actual.view_from_world[column], expected.view_from_world[column]),
                1e-9);
    EXPECT_NEAR(actual.focal_px.x, expected.focal_px.x, 1e-9);
    EXPECT_NEAR(actual.focal_px.y, expected.focal_px.y, 1e-9);
  };
  const glm::dvec3 up(0, -1, 0);
  const Camera a = camera("a"), b = camera("b"), c = camera("c");
  expect_camera(b, turned(a, up, -40 / a.focal_px.x, 10 / a.focal_px.y));
  expect_camera(c, with_vertical_fov(b, vertical_fov(b) * 0.94 * 0.94));
  expect_camera(camera("d"), rolled(c, glm::radians(6.0)));
  const auto pivots = [&](const char* name) {
    int count = 0;
    const json toasts = state(name)["toasts"];
    for (const json& toast : toasts)
      count += toast.get<std::string>().starts_with("pivot at ") ? 1 : 0;
    return count;
  };
  EXPECT_EQ(pivots("d"), 0);
  EXPECT_EQ(pivots("e"), 1);
  EXPECT_EQ(pivots("f"), 1);
}

TEST_F(ViewerWindow, full_screen_fills_the_display_and_the_window_comes_back) {
  const test::ProgramRun run =
      play("key Tab\nwait\nkey F11\nsleep 0.3\nwait\nstate " + path("full") +
               "\nkey F11\nsleep 0.3\nwait\nstate " + path("back") + "\nkey F11\nsleep 0.3\nquit\n",
           {path("scene.ply"), "--settings", path("kept.json")});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(camera("full").width, 1280);
  EXPECT_EQ(camera("full").height, 720);
  EXPECT_EQ(camera("back").width, 320);
  EXPECT_EQ(camera("back").height, 240);
  EXPECT_EQ(state("kept.json")["width"], 320);
  EXPECT_EQ(state("kept.json")["height"], 240);
}

TEST_F(ViewerWindow, a_grabbed_window_is_what_the_window_shows) {
  const test::ProgramRun run = play("key Tab\nwait\nshot " + path("shot.png") +
                                        "\nkey F12\nwait\nstate " + path("a") + "\nquit\n",
                                    {path("scene.ply")});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const std::string grabbed = path("screenshots/scene_window_0001.png");
  const Image shot = read_image(path("shot.png"));
  EXPECT_EQ(shot.width, 320);
  EXPECT_EQ(shot.height, 240);
  EXPECT_EQ(read_image(grabbed).values, shot.values);
  EXPECT_EQ(state("a")["toasts"][0], "wrote " + grabbed);
  const Image picture = frame("quadbox").color;
  for (std::size_t i = 0; i < shot.values.size(); ++i)
    ASSERT_EQ(to_8bit(shot.values[i]), to_8bit(picture.values[i])) << i;
}

// The first column at the right of the bar, from the colours of a row of pixels below its panels.
int end_of_left_bar(const Image& shot, int y) {
  int x = 0;
  const auto differs = [&](int at) {
    float most = 0;
    for (int c = 0; c < 3; ++c)
      most = std::max(most, std::abs(shot.at(at, y, c) - shot.at(2, y, c)));
    return most > 2.0f / 255;
  };
  while (x < shot.width && !differs(x)) ++x;
  return x;
}

TEST_F(ViewerWindow, a_bar_takes_exactly_the_width_that_it_draws_at_every_scale) {
  std::ofstream(path("kept.json")) << "{}";  // no first start, so no hints over the picture
  std::string script = "key Z\nwait\n";
  for (const std::string name : {"100", "125", "150"})
    script += "sleep 0.4\nwait\nstate " + path(name) + "\nshot " + path(name + ".png") +
              "\nkey Ctrl+=\nwait\n";
  script += "state " + path("last") + "\nquit\n";
  const test::ProgramRun run =
      play(script, {path("scene.ply"), "--size", "1280x700", "--background", "0.5,0.5,0.5",
                    "--settings", path("kept.json")});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  int before = 0;
  for (const std::string name : {"100", "125", "150"}) {
    SCOPED_TRACE(name);
    const Image shot = read_image(path(name + ".png"));
    const int bar = end_of_left_bar(shot, 600);
    // At most two fifths of the window.
    EXPECT_GT(bar, std::min(before, 512 - 1));
    EXPECT_EQ(camera(name).width, 1280 - bar);
    before = bar;
  }
  EXPECT_LT(camera("last").height, camera("100").height) << "the lines above and below grow";
  EXPECT_EQ(state("kept.json")["interface_scale"], 1.75);
}

}  // namespace
}  // namespace qs
