// SPDX-License-Identifier: MIT
#include "app/framing/first_view.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <glm/geometric.hpp>
#include <glm/gtc/constants.hpp>
#include <gtest/gtest.h>

#include "app/framing/camera_control.h"
#include "io/camera/cameras.h"
#include "io/scene/reader.h"
#include "raster/api/renderer.h"
#include "support/built_scenes.h"
#include "support/pool.h"
#include "support/scenes.h"
#include "support/shared.h"

namespace qs {
namespace {

Camera first_camera(const GaussianCloud& cloud, int width = 1280, int height = 720,
                    const std::optional<glm::dvec3>& up = {}) {
  return framed_camera(choose_framing(cloud, up, test::pool(2)), width, height);
}

glm::dvec3 direction_of(const Framing& framing) {
  return glm::normalize(framing.target - framing.eye);
}

Image picture(const GaussianCloud& cloud, const Camera& camera) {
  const auto renderer = make_renderer(Backend::cpu, test::pool(2));
  renderer->upload(cloud, {});
  return renderer->render(camera).color;
}

bool is_drawn(const Image& image, int x, int y) {
  return image.at(x, y, 0) + image.at(x, y, 1) + image.at(x, y, 2) > 0.1f;
}

double drawn_share(const Image& image) {
  int drawn = 0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) drawn += is_drawn(image, x, y);
  }
  return static_cast<double>(drawn) / (image.width * image.height);
}

/// A box in the picture, as fractions of its height from its centre.
struct Shown {
  glm::dvec2 low{1e9}, high{-1e9};
  double height() const { return high.y - low.y; }
  glm::dvec2 center() const { return 0.5 * (low + high); }
};

// The 5th to 95th percentile of each axis of the positions, in the picture. All Gaussians of the
// scenes below are equally opaque.
Shown shown_box(const std::vector<glm::vec3>& positions, const Camera& camera) {
  glm::dvec3 low, high;
  std::vector<float> values(positions.size());
  for (int axis = 0; axis < 3; ++axis) {
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = positions[i][axis];
    std::sort(values.begin(), values.end());
    low[axis] = static_cast<double>(values[values.size() / 20]);
    high[axis] = static_cast<double>(values[values.size() - 1 - values.size() / 20]);
  }
  Shown shown;
  for (int corner = 0; corner < 8; ++corner) {
    const glm::dvec3 at(corner & 1 ? low.x : high.x, corner & 2 ? low.y : high.y,
                        corner & 4 ? low.z : high.z);
    const glm::dvec3 view = camera.view_from_world * glm::dvec4(at, 1);
    EXPECT_GT(view.z, camera.near_depth);
    const glm::dvec2 pixel = camera.focal_px * glm::dvec2(view) / view.z / (1.0 * camera.height);
    shown.low = glm::min(shown.low, pixel);
    shown.high = glm::max(shown.high, pixel);
  }
  return shown;
}

void expect_in_the_middle(const Shown& shown, const Camera& camera, const std::string& what) {
  EXPECT_GT(shown.height(), 0.45) << what;
  EXPECT_LT(shown.height(), 0.9) << what;
  EXPECT_LT(std::abs(shown.center().y), 0.1) << what;
  EXPECT_LT(std::abs(shown.center().x), 0.1 * camera.width / camera.height) << what;
}

std::vector<glm::vec3> positions_of(const GaussianCloud& cloud) {
  return {cloud.positions.begin(), cloud.positions.end()};
}

TEST(FirstView, shows_the_subject_in_the_middle_of_pictures_of_any_size) {
  const auto built = [](const std::string& what, float scale) {
    test::SceneBuilder builder(8);
    const glm::vec3 at(5 * scale, -2 * scale, scale);
    if (what == "ball") builder.ball(3000, at, scale);
    if (what == "floor") builder.disc(3000, at, {0.1f, -1, 0.2f}, scale);
    if (what == "wall") builder.rectangle(3000, at, {1.5f * scale, 0, 0}, {0, scale, 0});
    if (what == "tower") builder.rectangle(3000, at, {0.3f * scale, 0, 0}, {0, 2 * scale, 0});
    if (what == "table") {
      builder.disc(3000, at, {0, -1, 0.5f}, scale);
      builder.ball(2000, at + glm::vec3(0, -0.3f, 0.15f) * scale, 0.3f * scale);
    }
    return builder.cloud;
  };
  for (const char* what : {"ball", "floor", "wall", "tower", "table"}) {
    for (const float scale : {0.01f, 1.0f, 1000.0f}) {
      const GaussianCloud cloud = built(what, scale);
      const Framing framing = choose_framing(cloud, {}, test::pool(2));
      for (const glm::ivec2 size : {glm::ivec2(1280, 720), glm::ivec2(640, 480)}) {
        const Camera camera = framed_camera(framing, size.x, size.y);
        expect_in_the_middle(shown_box(positions_of(cloud), camera), camera,
                             std::string(what) + " " + std::to_string(scale));
      }
      const Shown narrow = shown_box(positions_of(cloud), framed_camera(framing, 400, 900));
      EXPECT_LT(narrow.high.x - narrow.low.x, 1.3 * 400 / 900) << what;
    }
  }
}

TEST(FirstView, ignores_floaters_and_far_groups) {
  test::SceneBuilder builder(8);
  builder.disc(5000, {0, 0, 0}, {0, -1, 0}, 1);
  builder.ball(5000, {0, -0.4f, 0}, 0.4f);
  const std::vector<glm::vec3> subject = positions_of(builder.cloud);
  builder.floaters(200, {0, 0, 0}, 20, 0.1f);
  builder.ball(300, {30, 5, 40}, 0.3f);
  const Camera camera = first_camera(builder.cloud);
  expect_in_the_middle(shown_box(subject, camera), camera, "with floaters");
}

TEST(FirstView, is_upright_and_from_above) {
  const glm::dvec3 up = glm::normalize(glm::dvec3(0.2, -0.9, -0.4));
  test::SceneBuilder builder(8);
  builder.disc(5000, {0, 0, 0}, glm::vec3(up), 1);
  builder.ball(2000, 0.3f * glm::vec3(up), 0.3f);
  const ViewAxes axes = view_axes(first_camera(builder.cloud));
  EXPECT_NEAR(glm::dot(axes.right, up), 0, 0.04);
  EXPECT_LT(glm::dot(axes.down, up), -0.6);
  EXPECT_LT(glm::dot(axes.forward, up), -0.1);
  const ViewAxes given = view_axes(first_camera(builder.cloud, 64, 48, glm::dvec3(0, 0, 1)));
  EXPECT_NEAR(given.right.z, 0, 1e-9);
  EXPECT_LT(given.down.z, -0.6);
}

TEST(FirstView, looks_past_what_hides_the_subject) {
  test::SceneBuilder builder(8);
  builder.ball(6000, {0, 0, 0}, 1);
  for (glm::vec3& c : builder.cloud.sh) c = glm::vec3(1.5f, -1.7f, -1.7f);  // red
  const std::size_t subject = builder.cloud.size();
  // Few and large, at three sides: in front of the usual view, at the left and behind.
  for (const glm::vec3 side : {glm::vec3(0, 0, -1), glm::vec3(-1, 0, 0), glm::vec3(0, 0, 1)})
    builder.rectangle(40, 1.7f * side, {1.7f * side.z, 0, -1.7f * side.x}, {0, 1.7f, 0});
  for (std::size_t i = subject; i < builder.cloud.size(); ++i) {
    builder.cloud.sh[i] = glm::vec3(-1.7f, -1.7f, 1.5f);  // blue
    builder.cloud.log_scales[i] += std::log(2.0f);
  }
  const Image image = picture(builder.cloud, first_camera(builder.cloud, 160, 90));
  int red = 0;
  for (int y = 40; y < 50; ++y) {
    for (int x = 75; x < 85; ++x) red += image.at(x, y, 0) > 0.5f && image.at(x, y, 2) < 0.2f;
  }
  EXPECT_GT(red, 80);
}

/// A scene that is seen from inside. The eye should be nearer to the middle than `reach`, and its
/// picture full up to the share `sky`.
struct Surrounding {
  std::string name;
  GaussianCloud cloud;
  glm::dvec3 reach;
  double sky = 0.02;
};

std::vector<Surrounding> surroundings() {
  const auto built = [](const auto& build) {
    test::SceneBuilder builder(8);
    build(builder);
    return std::move(builder.cloud);
  };
  const auto furniture = [](test::SceneBuilder& b) {
    b.box(9000, {-2.3f, -0.4f, 0}, {0.5f, 0.4f, 1.2f});
    b.box(5000, {2.5f, -1, 2}, {0.3f, 1, 0.8f});
    b.box(4000, {0.3f, -0.25f, 0.3f}, {0.5f, 0.25f, 0.7f});
    b.floaters(300, {0, -1.4f, 0}, 9, 0.05f);
  };
  return {
      {"empty room",
       built([](auto& b) {
         b.room({3, 1.4f, 4}, true);
       }),
       {3, 2.8, 4}},
      {"room with furniture",
       built([&](auto& b) {
         b.room({3, 1.4f, 4}, true);
         furniture(b);
       }),
       {3, 2.8, 4}},
      {"room without a ceiling",
       built([&](auto& b) {
         b.room({3, 1.4f, 4}, false);
         furniture(b);
       }),
       {3, 2.8, 4},
       0.4},
      {"kitchen around a dense thing on a table",
       built([](auto& b) {
         b.room({2.5f, 1.3f, 3}, true);
         b.box(3000, {0, -0.4f, 0}, {0.6f, 0.4f, 0.9f});
         b.ball(9000, {0, -1, 0}, 0.2f);
         b.box(9000, {-2.2f, -0.5f, 0}, {0.3f, 0.5f, 2.5f});
       }),
       {2.5, 2.6, 3}},
      {"street",
       built([](auto& b) {
         b.rectangle(9000, {0, 0, 0}, {4, 0, 0}, {0, 0, 30});
         for (const float side : {-1.0f, 1.0f})
           b.rectangle(9000, {5 * side, -4, 0}, {0, 4, 0}, {0, 0, 30});
       }),
       {5, 8, 30},
       0.5},
      {"garden",
       built([](auto& b) {
         b.disc(9000, {0, 0, 0}, {0, -1, 0}, 6);
         b.disc(4000, {0, -0.8f, 0}, {0, -1, 0}, 0.8f);
         b.ball(3000, {0, -1, 0}, 0.25f);
         b.trees(24, 10, 2.3f);
       }),
       {8, 5, 8},
       0.5},
  };
}

TEST(FirstView, is_inside_what_surrounds_it) {
  for (const Surrounding& scene : surroundings()) {
    const Camera camera = first_camera(scene.cloud, 160, 90);
    const glm::dvec3 eye = camera.position();
    for (int axis = 0; axis < 3; ++axis)
      EXPECT_LT(std::abs(eye[axis]), scene.reach[axis]) << scene.name << ' ' << axis;
    EXPECT_LT(eye.y, -0.3) << scene.name;
    EXPECT_GT(view_axes(camera).down.y, 0.8) << scene.name;
    for (const glm::vec3& p : scene.cloud.positions)
      ASSERT_GT(glm::distance(glm::dvec3(p), eye), 0.05) << scene.name;
    EXPECT_GT(drawn_share(picture(scene.cloud, camera)), 1 - scene.sky) << scene.name;
  }
}

TEST(FirstView, is_along_a_street) {
  for (const Surrounding& scene : surroundings()) {
    if (scene.name != "street") continue;
    EXPECT_GT(std::abs(view_axes(first_camera(scene.cloud)).forward.z), 0.8);
  }
}

TEST(FirstView, of_a_tilted_room_is_upright) {
  test::SceneBuilder builder(8);
  builder.room({3, 1.4f, 4}, true);
  builder.box(9000, {-2.3f, -0.4f, 0}, {0.5f, 0.4f, 1.2f});
  const glm::quat lean = glm::angleAxis(0.35f, glm::normalize(glm::vec3(1, 0.2f, 0.3f)));
  builder.turn(lean);
  const glm::dvec3 up(lean * glm::vec3(0, -1, 0));
  const Camera camera = first_camera(builder.cloud);
  EXPECT_NEAR(glm::dot(view_axes(camera).right, up), 0, 0.02);
  EXPECT_LT(glm::dot(view_axes(camera).down, up), -0.8);
}

TEST(FirstView, of_things_is_from_outside) {
  const auto eye_of = [](const auto& build) {
    test::SceneBuilder builder(8);
    build(builder);
    const Camera camera = first_camera(builder.cloud);
    return glm::abs(camera.position() - glm::dvec3(0, -1, 0));
  };
  const glm::dvec3 ball = eye_of([](auto& b) { b.ball(9000, {0, -1, 0}, 1); });
  EXPECT_GT(glm::length(ball), 1.5);
  const glm::dvec3 on_a_table = eye_of([](auto& b) {
    b.disc(5000, {0, 0, 0}, {0, -1, 0}, 2);
    b.box(9000, {0, -1, 0}, {0.7f, 1, 0.7f});
  });
  EXPECT_GT(std::max(on_a_table.x, on_a_table.z), 1);
  const glm::dvec3 house = eye_of([](auto& b) {
    b.disc(6000, {0, 0, 0}, {0, -1, 0}, 14);
    b.box(9000, {0, -2.5f, 0}, {4, 2.5f, 3});
    b.trees(9, 10, 1.6f);
  });
  EXPECT_GT(std::max(house.x, house.z), 5);
}

TEST(FirstView, is_the_same_for_any_number_of_threads) {
  test::SceneBuilder builder(8);
  builder.disc(30'000, {0, 0, 0}, {0, -1, 0.3f}, 1);
  builder.ball(40'000, {0, -0.4f, 0}, 0.4f);
  builder.floaters(500, {0, 0, 0}, 20, 0.1f);
  const auto text = [&](int threads) {
    return format_camera(
        framed_camera(choose_framing(builder.cloud, {}, test::pool(threads)), 640, 480));
  };
  const std::string expected = text(1);
  for (const int threads : {1, 2, 3}) EXPECT_EQ(text(threads), expected) << threads;
}

TEST(FirstView, shows_one_or_three_gaussians_and_equal_positions) {
  const GaussianCloud one = test::single_gaussian({5, 6, 7}, 0.01f, glm::vec3(1), 3);
  GaussianCloud three = one;
  test::append(three, test::single_gaussian({5.1f, 6, 7}, 0.01f, glm::vec3(1), 3));
  test::append(three, test::single_gaussian({4.9f, 6.05f, 7.1f}, 0.01f, glm::vec3(1), 3));
  GaussianCloud equal = one;
  for (int i = 0; i < 50; ++i) test::append(equal, one);
  GaussianCloud line = one;
  test::append(line, test::single_gaussian({9, 6, 7}, 0.1f, glm::vec3(1), 3));
  test::append(line, test::single_gaussian({1, 6, 7}, 0.1f, glm::vec3(1), 3));
  for (const GaussianCloud& cloud : {one, three, equal, line}) {
    const Camera camera = first_camera(cloud, 160, 90);
    for (const glm::vec3& p : cloud.positions) {
      const glm::dvec3 view = camera.view_from_world * glm::dvec4(glm::dvec3(p), 1);
      EXPECT_GT(view.z, camera.near_depth);
      const glm::dvec2 pixel = camera.focal_px * glm::dvec2(view) / view.z + camera.center_px;
      EXPECT_TRUE(pixel.x > 0 && pixel.x < 159 && pixel.y > 0 && pixel.y < 89) << cloud.size();
    }
    EXPECT_GT(drawn_share(picture(cloud, camera)), 0.001) << cloud.size();
  }
}

TEST(FirstView, is_finite_for_values_that_are_not) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float infinity = std::numeric_limits<float>::infinity();
  GaussianCloud cloud = test::random_cloud(300, 1, 4);
  cloud.positions[3] = {nan, 0, 0};
  cloud.positions[4] = {0, infinity, 0};
  cloud.positions[5] = glm::vec3(3e38f);
  cloud.log_scales[6] = glm::vec3(nan);
  cloud.log_scales[7] = glm::vec3(infinity);
  cloud.log_scales[8] = glm::vec3(-infinity);
  cloud.rotations[9] = glm::quat(nan, 0, 0, 0);
  cloud.rotations[10] = glm::quat(0, 0, 0, 0);
  cloud.opacity_logits[11] = nan;
  cloud.opacity_logits[12] = infinity;
  cloud.sh[13 * 4] = glm::vec3(nan);
  GaussianCloud flat = test::random_cloud(300, 0, 4), invisible = flat, only_nan = flat;
  for (glm::vec3& s : flat.log_scales) s = glm::vec3(-infinity);
  for (float& o : invisible.opacity_logits) o = -infinity;
  for (glm::vec3& p : only_nan.positions) p = glm::vec3(nan);
  for (const GaussianCloud& each : {cloud, flat, invisible, only_nan, GaussianCloud()}) {
    const Camera camera = first_camera(each);
    for (int column = 0; column < 4; ++column) {
      for (int row = 0; row < 3; ++row)
        EXPECT_TRUE(std::isfinite(camera.view_from_world[column][row]));
    }
    EXPECT_GT(camera.near_depth, 0);
  }
}

// The drawn part of a trained scene is at least 45 % as high as the picture, and its middle is near
// the picture's middle.
TEST(FirstView, of_trained_scenes_fills_the_picture) {
  for (const char* name :
       {"scenes/plush.spz", "scenes/plush_big.spz", "scenes/plush_small.spz",
        "scenes/wild/playcanvas_guitar.compressed.ply", "scenes/wild/playbot_streamed",
        "corpus/valid/biker.compressed.ply", "corpus/valid/ply_inria_sh3.ply"}) {
    QS_NEEDS_SHARED(name);
    const Scene scene = read_scene(test::shared_path(name), test::pool(2));
    const Image image = picture(
        scene.cloud, first_camera(scene.cloud, 160, 90, declared_up({}, scene.vertical_axis)));
    int rows = 0, pixels = 0;
    glm::dvec2 sum(0);
    for (int y = 0; y < image.height; ++y) {
      const int before = pixels;
      for (int x = 0; x < image.width; ++x) {
        if (!is_drawn(image, x, y)) continue;
        ++pixels;
        sum += glm::dvec2(x, y);
      }
      rows += pixels > before;
    }
    EXPECT_GT(rows, 0.45 * image.height) << name;
    EXPECT_NEAR(sum.x / pixels, 0.5 * image.width, 0.1 * image.width) << name;
    EXPECT_NEAR(sum.y / pixels, 0.5 * image.height, 0.15 * image.height) << name;
  }
}

// The photographs show the subject, so their cameras look at it; the view is chosen without them.
TEST(FirstView, of_the_bundled_scene_is_of_what_its_photographs_show) {
  const Scene scene = read_scene(test::source_path("assets/plush.ply"), test::pool(), {});
  const std::vector<Camera> cameras = read_cameras(test::source_path("assets/cameras.json"));
  const glm::dvec3 subject = cameras_target(cameras).value();
  const Framing framing = choose_framing(scene.cloud, {}, test::pool());
  const Camera camera = framed_camera(framing, 1280, 720);
  const glm::dvec3 seen = camera.view_from_world * glm::dvec4(subject, 1);
  const glm::dvec2 pixel = glm::dvec2(seen) / seen.z * camera.focal_px + camera.center_px;
  EXPECT_NEAR(pixel.x, 640, 0.15 * 1280);
  EXPECT_NEAR(pixel.y, 360, 0.15 * 720);
  std::vector<double> distances;
  for (const Camera& photograph : cameras)
    distances.push_back(glm::distance(photograph.position(), subject));
  std::sort(distances.begin(), distances.end());
  EXPECT_LT(seen.z, 1.5 * distances[distances.size() / 2]) << "not much farther than they are";
}

// The cosine between the eye's horizontal direction from a cloud that was turned by `degrees` and
// the direction to which its front was turned.
double cos_to_front(const GaussianCloud& cloud, glm::vec3 front, float degrees) {
  test::SceneBuilder builder(8);
  builder.cloud = cloud;
  const glm::quat turn = glm::angleAxis(glm::radians(degrees), glm::vec3(0, 1, 0));
  builder.turn(turn);
  glm::dvec3 eye = -direction_of(choose_framing(builder.cloud, {}, test::pool(2)));
  eye.y = 0;
  return glm::dot(glm::normalize(eye), glm::dvec3(turn * front));
}

// Both sides have fields of two brightnesses; on the front they have two hues too.
TEST(FirstView, of_an_object_is_from_the_side_with_more_hues_whatever_its_axes) {
  test::SceneBuilder builder(8);
  builder.ball(6000, {0, 0, 0}, 1);
  GaussianCloud& ball = builder.cloud;
  for (std::size_t i = 0; i < ball.size(); ++i) {
    const glm::vec3 at = ball.positions[i];
    const bool odd = (std::lround(std::floor(4 * at.x)) + std::lround(std::floor(4 * at.y))) % 2;
    const glm::vec3 color = at.z < 0 ? glm::vec3(odd ? 0.18f : 0.26f)
                            : odd    ? glm::vec3(0.4f, 0.09f, 0.05f)
                                     : glm::vec3(0.12f, 0.25f, 0.7f);
    ball.sh[i] = (color - 0.5f) / 0.28209479f;
  }
  for (int degrees = 0; degrees < 360; degrees += 45)
    EXPECT_GT(cos_to_front(ball, {0, 0, 1}, static_cast<float>(degrees)), 0.5) << degrees;
}

TEST(FirstView, of_trained_objects_is_from_their_front_whatever_their_axes) {
  const std::pair<const char*, glm::vec3> objects[] = {
      {"corpus/valid/biker.compressed.ply", {-1, 0, 0}},
      {"scenes/wild/playcanvas_guitar.compressed.ply", {1, 0, 0}},
      {"corpus/valid/sog_v2_folder_playbot4", {0, 0, -1}}};
  for (const auto& [name, front] : objects) {
    QS_NEEDS_SHARED(name);
    const GaussianCloud cloud = read_scene(test::shared_path(name), test::pool(2)).cloud;
    for (const float degrees : {0.0f, 75.0f, 135.0f, 210.0f, 300.0f})
      EXPECT_GT(cos_to_front(cloud, front, degrees), 0.5) << name << ' ' << degrees;
  }
}

TEST(FirstView, a_choice_of_four_differs_by_30_degrees_and_has_the_other_side) {
  const GaussianCloud cloud = test::random_cloud(400, 0, 3);
  const std::vector<Framing> framings = choose_framings(cloud, {}, test::pool(2));
  ASSERT_EQ(framings.size(), kMostCandidates);
  const Framing best = choose_framing(cloud, {}, test::pool(2));
  EXPECT_EQ(framings[0].eye, best.eye);
  EXPECT_EQ(framings[0].target, best.target);
  double farthest = 1;
  for (std::size_t i = 0; i < framings.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      EXPECT_LT(glm::dot(direction_of(framings[i]), direction_of(framings[k])),
                std::cos(glm::radians(29.9)));
    }
    const auto level = [&](const Framing& framing) {
      const glm::dvec3 direction = direction_of(framing);
      return glm::normalize(direction - glm::dot(direction, best.up) * best.up);
    };
    farthest = std::min(farthest, glm::dot(level(framings[i]), level(framings[0])));
  }
  EXPECT_LT(farthest, std::cos(glm::radians(119.9)));
  EXPECT_EQ(choose_framings(cloud, {}, test::pool(2), 1).size(), 1u);
}

TEST(FirstView, one_gaussian_has_a_choice_too) {
  const GaussianCloud cloud = test::single_gaussian({0, 0, 4}, 0.5f, {0.9f, 0.4f, 0.1f}, 5);
  EXPECT_GE(choose_framings(cloud, {}, test::pool(1)).size(), 1u);
}

}  // namespace
}  // namespace qs
