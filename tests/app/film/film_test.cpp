// SPDX-License-Identifier: MIT
//
// The tracks of a film's camera, the files of films, and the strips of their pictures.
#include "app/film/film.h"

#include <cmath>
#include <fstream>
#include <set>

#include <glm/geometric.hpp>
#include <glm/gtc/constants.hpp>
#include <glm/trigonometric.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/framing/camera_control.h"
#include "io/picture/image_file.h"
#include "support/error_of.h"
#include "support/pool.h"
#include "support/scenes.h"
#include "support/temporary_folder.h"

namespace qs {
namespace {

using test::error_of;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr glm::ivec2 kSize{64, 48};

// ---- the turntable ------------------------------------------------------------------------------

// The eye is 5 in front of the target and 2 above it; up is -y.
Framing subject() {
  Framing framing;
  framing.target = {1, 2, 3};
  framing.eye = framing.target + glm::dvec3(0, -2, -5);
  framing.up = {0, -1, 0};
  return framing;
}

// The direction in which a camera stands, seen from the target, in degrees to the eye's left.
double angle_of(const Camera& camera) {
  const glm::dvec3 at = camera.position() - subject().target;
  return glm::degrees(std::atan2(-at.x, -at.z));
}

Camera camera_standing_at(double degrees, double distance) {
  const double a = glm::radians(degrees);
  const glm::dvec3 target = subject().target;
  return look_at(target + distance * glm::dvec3(-std::sin(a), 0, -std::cos(a)), target, {0, -1, 0},
                 1, 64, 48);
}

TEST(Turntable, goes_once_round_the_subject_at_the_height_of_the_first_view) {
  const CameraTrack track = turntable(subject(), arc_of(360), Ease::none);
  EXPECT_TRUE(track.closed);
  const double expected[] = {0, 90, 180, -90};
  for (int i = 0; i < 4; ++i) {
    const Camera camera = camera_of(track, i, 4, kSize);
    EXPECT_NEAR(std::abs(angle_of(camera)), std::abs(expected[i]), 1e-9) << i;
    if (i % 2 == 1) {
      EXPECT_NEAR(angle_of(camera), expected[i], 1e-9);
    }
    EXPECT_NEAR(camera.position().y, 0, 1e-9);
    const glm::dvec3 to_target = glm::normalize(subject().target - camera.position());
    EXPECT_NEAR(glm::dot(view_axes(camera).forward, to_target), 1, 1e-9);
    EXPECT_NEAR(view_axes(camera).right.y, 0, 1e-9);
    EXPECT_EQ(camera.width, 64);
  }
  const Camera first = framed_camera(subject(), 64, 48);
  EXPECT_LT(glm::distance(camera_of(track, 0, 4, kSize).position(), first.position()), 1e-9);
  EXPECT_LT(glm::distance(camera_of(track, 4, 4, kSize).position(), first.position()), 1e-9);
}

TEST(Turntable, swings_from_one_end_of_an_arc_to_the_other_and_back) {
  const CameraTrack track =
      turntable(subject(), {glm::radians(-60.0), glm::radians(20.0)}, Ease::none);
  double lowest = 0, highest = 0, largest_step = 0, before = 0;
  for (int i = 0; i <= 400; ++i) {
    const double angle = angle_of(camera_of(track, i, 400, kSize));
    lowest = std::min(lowest, angle);
    highest = std::max(highest, angle);
    largest_step = std::max(largest_step, std::abs(angle - before));
    before = angle;
  }
  EXPECT_NEAR(lowest, -60, 0.05);
  EXPECT_NEAR(highest, 20, 0.05);
  EXPECT_NEAR(before, 0, 1e-9);
  EXPECT_NEAR(angle_of(camera_of(track, 0, 400, kSize)), 0, 1e-9);
  EXPECT_LT(largest_step, 1.01 * 40 * 2 * glm::pi<double>() / 400);
}

TEST(Turntable, begins_and_ends_at_rest_if_it_eases) {
  const CameraTrack track = turntable(subject(), arc_of(360), Ease::ends);
  EXPECT_LT(std::abs(angle_of(camera_of(track, 1, 1000, kSize))), 0.01);
  EXPECT_LT(std::abs(angle_of(camera_of(track, 999, 1000, kSize))), 0.01);
  EXPECT_NEAR(std::abs(angle_of(camera_of(track, 500, 1000, kSize))), 180, 1e-6);
}

TEST(Turntable, an_arc_of_0_degrees_stands_still) {
  const CameraTrack track = turntable(subject(), arc_of(0), Ease::none);
  for (int i = 0; i < 4; ++i) EXPECT_NEAR(angle_of(camera_of(track, i, 4, kSize)), 0, 1e-9);
}

TEST(SeenArc, is_whole_if_cameras_stand_all_around) {
  std::vector<Camera> ring;
  for (int i = 0; i < 5; ++i) ring.push_back(camera_standing_at(72 * i + 10, 5.4));
  EXPECT_TRUE(seen_arc(ring, subject()).whole());
  ring.pop_back();
  EXPECT_FALSE(seen_arc(ring, subject()).whole());
}

TEST(SeenArc, is_between_the_outermost_cameras_without_a_tenth_at_each_end) {
  std::vector<Camera> cameras;
  for (const double degrees : {-100.0, -50.0, 0.0, 40.0, 80.0})
    cameras.push_back(camera_standing_at(degrees, 5.4));
  const Arc arc = seen_arc(cameras, subject());
  EXPECT_NEAR(glm::degrees(arc.low), -82, 1e-6);
  EXPECT_NEAR(glm::degrees(arc.high), 62, 1e-6);
  cameras.push_back(camera_standing_at(140, 2));  // too near to count
  EXPECT_NEAR(glm::degrees(seen_arc(cameras, subject()).high), 62, 1e-6);
  // Around the back, where angles jump from 180 to -180 degrees.
  cameras.clear();
  for (const double degrees : {0.0, 80.0, 160.0, 200.0})
    cameras.push_back(camera_standing_at(degrees, 5.4));
  const Arc back = seen_arc(cameras, subject());
  EXPECT_NEAR(glm::degrees(back.low), 0, 1e-6);  // the eye stays inside
  EXPECT_NEAR(glm::degrees(back.high), 180, 1e-6);
}

// A subject of small Gaussians, and a wall of large Gaussians to its left in the way of the camera.
GaussianCloud subject_beside_a_wall(bool wall) {
  GaussianCloud cloud;
  constexpr int kSubject = 400, kWall = 225;
  cloud.resize(kSubject + (wall ? kWall : 0), 0);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const auto n = static_cast<int>(i) - kSubject;
    const glm::vec3 turn(std::sin(7.0f * static_cast<float>(i)),
                         std::sin(3.0f * static_cast<float>(i)),
                         std::sin(5.0f * static_cast<float>(i)));
    const bool of_wall = n >= 0;
    cloud.positions[i] = of_wall ? glm::vec3(-2.9f, 2 + 0.4f * static_cast<float>(n / 15 - 7),
                                             3 + 0.4f * static_cast<float>(n % 15 - 7))
                                 : glm::vec3(1, 2, 3) + 0.7f * turn;
    cloud.log_scales[i] = glm::vec3(of_wall ? -1.2f : -2.5f);
    cloud.rotations[i] = glm::quat(1, 0, 0, 0);
    cloud.opacity_logits[i] = 4;
    cloud.sh[i] = glm::vec3(of_wall ? 1.5f : -1.5f);
  }
  return cloud;
}

TEST(OpenArc, ends_where_something_hides_the_subject) {
  EXPECT_TRUE(open_arc(subject_beside_a_wall(false), subject(), test::pool()).whole());
  const Arc arc = open_arc(subject_beside_a_wall(true), subject(), test::pool());
  EXPECT_FALSE(arc.whole());
  // The wall is 3.9 to the left of the target, and the eye 5 away from it: it would pass the wall
  // twice, at these angles. It stops where the wall enters the picture.
  const double passes = glm::degrees(std::asin(3.9 / 5));
  EXPECT_GT(glm::degrees(arc.high), 10);
  EXPECT_LT(glm::degrees(arc.high), passes);
  EXPECT_LT(glm::degrees(arc.low), -180);
  EXPECT_GT(glm::degrees(arc.low), -(180 + passes));
}

TEST(FreeArc, is_told_by_the_cameras_if_there_are_any) {
  const GaussianCloud cloud = subject_beside_a_wall(true);
  std::vector<Camera> ring;
  for (int i = 0; i < 5; ++i) ring.push_back(camera_standing_at(72 * i, 5.4));
  EXPECT_TRUE(free_arc(ring, cloud, subject(), test::pool()).whole());
  EXPECT_FALSE(free_arc({}, cloud, subject(), test::pool()).whole());
}

// ---- the path -----------------------------------------------------------------------------------

std::vector<Keyframe> corners() {
  std::vector<Keyframe> keyframes;
  const double times[] = {1, 2, 4, 5};
  const glm::dvec3 places[] = {{0, 0, 0}, {3, 0, 0}, {3, 0, 4}, {0, 1, 4}};
  for (int i = 0; i < 4; ++i) {
    const glm::dvec3 ahead(std::sin(i * 0.8), 0, std::cos(i * 0.8));
    keyframes.push_back(
        {times[i], look_at(places[i], places[i] + ahead, {0, -1, 0}, 1 + 0.1 * i, 64, 48)});
  }
  return keyframes;
}

glm::dvec3 place_at(const CameraTrack& track, double seconds) {
  return track.at(seconds / track.seconds, kSize).position();
}
double speed_at(const CameraTrack& track, double seconds) {
  constexpr double kStep = 1e-5;
  return glm::distance(place_at(track, seconds + kStep), place_at(track, seconds)) / kStep;
}

TEST(FilmPath, takes_its_own_time_from_the_first_keyframe_to_the_last) {
  const CameraTrack track = along(corners(), Ease::none);
  EXPECT_EQ(track.seconds, 4);
  EXPECT_FALSE(track.closed);
  for (const Keyframe& key : corners())
    EXPECT_LT(glm::distance(place_at(track, key.time - 1), key.camera.position()), 1e-9);
  EXPECT_LT(glm::distance(camera_of(track, 8, 9, kSize).position(), {0, 1, 4}), 1e-9);
  EXPECT_LT(glm::distance(camera_of(track, 0, 1, kSize).position(), {0, 0, 0}), 1e-9);
  EXPECT_EQ(camera_of(track, 0, 1, {30, 20}).height, 20);
}

TEST(FilmPath, returns_to_the_first_keyframe_in_the_mean_time_without_a_corner) {
  const CameraTrack track = along(corners(), Ease::none, true);
  EXPECT_NEAR(track.seconds, 4 + 4 / 3.0, 1e-12);
  EXPECT_TRUE(track.closed);
  for (const Keyframe& key : corners())
    EXPECT_LT(glm::distance(place_at(track, key.time - 1), key.camera.position()), 1e-9);
  EXPECT_LT(glm::distance(place_at(track, track.seconds), {0, 0, 0}), 1e-9);
  constexpr double kStep = 1e-6;
  const glm::dvec3 leaving = (place_at(track, kStep) - place_at(track, 0)) / kStep;
  const glm::dvec3 arriving =
      (place_at(track, track.seconds) - place_at(track, track.seconds - kStep)) / kStep;
  EXPECT_LT(glm::distance(leaving, arriving), 1e-3 * glm::length(leaving));
  EXPECT_GT(glm::length(leaving), 0.1);
  // The slope of Catmull and Rom at the first keyframe, whose neighbours are the second and last.
  const glm::dvec3 slope = (glm::dvec3(3, 0, 0) - glm::dvec3(0, 1, 4)) / (1 + 4 / 3.0);
  EXPECT_LT(glm::distance(leaving, slope), 1e-4);
}

TEST(FilmPath, rests_where_it_eases) {
  const auto speeds = [](const CameraTrack& track) {
    std::vector<bool> rests;
    for (const double seconds : {0.0, 1.0, 3.0, 3.99999})
      rests.push_back(speed_at(track, seconds) < 1e-2);
    return rests;
  };
  EXPECT_THAT(speeds(along(corners(), Ease::none)), ElementsAre(false, false, false, false));
  EXPECT_THAT(speeds(along(corners(), Ease::ends)), ElementsAre(true, false, false, true));
  EXPECT_THAT(speeds(along(corners(), Ease::all)), ElementsAre(true, true, true, true));
  std::vector<Keyframe> one = corners();
  one[2].eases = true;
  EXPECT_THAT(speeds(along(one, Ease::none)), ElementsAre(false, false, true, false));
  const CameraTrack loop = along(corners(), Ease::ends, true);
  EXPECT_THAT(speeds(loop), ElementsAre(true, false, false, false));
  EXPECT_LT(speed_at(loop, loop.seconds - 2e-5), 1e-2);
}

TEST(FilmPath, a_file_says_where_the_camera_eases) {
  const TemporaryFolder folder;
  std::vector<Keyframe> keyframes = corners();
  keyframes[1].eases = true;
  const std::string text = format_camera_path(keyframes);
  std::ofstream(folder / "path.json") << text;
  const std::vector<Keyframe> again = read_camera_path(folder / "path.json");
  for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(again[i].eases, i == 1) << i;
  std::string wrong = text;
  wrong.replace(wrong.find("true"), 4, "1");
  std::ofstream(folder / "path.json") << wrong;
  EXPECT_THAT(error_of([&] { read_camera_path(folder / "path.json"); }),
              HasSubstr("keyframe 1: ease is neither true nor false"));
}

// ---- files --------------------------------------------------------------------------------------

Image plain(float value) {
  Image image(4, 2, 3);
  for (float& each : image.values) each = value;
  return image;
}

std::set<std::string> names_in(const std::filesystem::path& folder) {
  std::set<std::string> names;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
    names.insert(entry.path().lexically_relative(folder).string());
  return names;
}

TEST(FilmFolder, holds_the_pictures_of_the_last_film_only) {
  const TemporaryFolder folder;
  const auto write = [&](int count) {
    write_film_file(folder / "film", {4, 2}, 30, [&](const AddPicture& add) {
      for (int i = 0; i < count; ++i) add(plain(0.2f * static_cast<float>(i)));
    });
  };
  write(3);
  std::ofstream(folder / "film/notes.txt") << "mine";
  EXPECT_EQ(read_image(folder / "film/frame_00002.png").at(0, 0, 0), 102 / 255.0f);
  write(1);
  EXPECT_THAT(names_in(folder.path()),
              ElementsAre("film", "film/frame_00000.png", "film/notes.txt"));
}

TEST(FilmFolder, is_as_before_if_the_film_was_not_finished) {
  const TemporaryFolder folder;
  const auto stop = [&](const AddPicture& add) {
    add(plain(0));
    throw Cancelled();
  };
  EXPECT_THROW(write_film_file(folder / "film", {4, 2}, 30, stop), Cancelled);
  EXPECT_THAT(names_in(folder.path()), IsEmpty());
}

TEST(FilmFile, names_that_no_format_fits_are_refused) {
  const auto said = [](const char* path, glm::ivec2 size, double fps) {
    return error_of([&] { write_film_file(path, size, fps, [](const AddPicture&) {}); },
                    ErrorKind::usage);
  };
  EXPECT_THAT(said("film.mkv", {4, 2}, 30),
              HasSubstr("film.mkv: a film ends in .mp4, .webm or .gif"));
  EXPECT_THAT(said("film.mp4", {5, 2}, 30), HasSubstr(".mp4 needs an even width and height"));
  EXPECT_THAT(said("film.mp4", {4, 3}, 30), HasSubstr("but the size is 4 x 3"));
  EXPECT_THAT(said("film.gif", {4, 2}, 51), HasSubstr(".gif holds at most 50 pictures per second"));
}

// ---- pictures -----------------------------------------------------------------------------------

TEST(SplitScreen, a_strip_is_that_part_of_its_view) {
  SplitScreen screen({{"a"}, {"b"}, {"c"}}, 100, 50);
  Image view(100, 50, 3);
  for (int i = 0; i < 3; ++i) {
    for (int y = 0; y < 50; ++y)
      for (int x = 0; x < 100; ++x) view.at(x, y, 0) = static_cast<float>(1000 * i + 100 * y + x);
    screen.show(static_cast<std::size_t>(i), view);
  }
  const Image& picture = screen.picture();
  for (const auto& [x, strip] : {std::pair{0, 0}, {32, 0}, {34, 1}, {65, 1}, {67, 2}, {99, 2}})
    EXPECT_EQ(picture.at(x, 20, 0), static_cast<float>(1000 * strip + 2000 + x)) << x;
}

TEST(SplitScreen, a_label_stays_at_the_bottom_of_its_strip) {
  for (const int width : {640, 480, 300, 200, 30}) {
    constexpr int kHeight = 760;
    SplitScreen screen({{"3dgs"}, {"quadbox"}}, width, kHeight);
    for (const std::size_t i : {0u, 1u}) screen.show(i, Image(width, kHeight, 3));
    screen.label(0, {"25.0 FPS", "1,234,567 pairs"});
    const Image& picture = screen.picture();
    int covered = 0;
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < width; ++x) {
        if (std::abs(x - width / 2) <= 1) continue;  // the line between the strips
        if (x > width / 2 || y < kHeight / 2) {
          ASSERT_EQ(picture.at(x, y, 0), 0) << x << " " << y;
        } else if (picture.at(x, y, 0) > 0) {
          ++covered;
        }
      }
    }
    EXPECT_GT(covered, width > 30 ? 50 : -1) << width;  // narrow strips have no label
  }
}

TEST(SplitScreen, a_long_line_of_a_label_is_broken_between_words) {
  const auto top_of_label = [](const std::vector<std::string>& lines) {
    SplitScreen screen({{"quadbox"}}, 640, 480);
    Image white(640, 480, 3);
    std::ranges::fill(white.values, 1.0f);
    screen.show(0, white);
    screen.label(0, lines);
    int top = 0;
    while (screen.picture().at(320, top, 0) == 1) ++top;
    return top;
  };
  EXPECT_EQ(top_of_label({"splat scale 0.56, edited: 23,615 of 34,321 Gaussians"}),
            top_of_label({"splat scale 0.56,", "edited: 23,615", "of 34,321 Gaussians"}));
}

FilmPlan plan_of_three_pictures() {
  FilmPlan plan;
  plan.track = along({{0, test::front_camera(64, 48)}, {1, camera_standing_at(20, 6)}}, Ease::none);
  plan.size = kSize;
  plan.seconds = 0.5;
  plan.fps = 6;
  return plan;
}

// In modes 3dgs and quadbox side by side.
FilmPlan plan_of_two_modes(Renderer& renderer) {
  FilmPlan plan = plan_of_three_pictures();
  for (const char* mode : {"3dgs", "quadbox"}) {
    plan.ways.push_back({&renderer, {}, mode});
    plan.ways.back().settings.mode = find_culler(mode);
  }
  return plan;
}

Outputs outputs_of_pairs() {
  Outputs outputs = outputs_for(HeatQuantity::pairs);
  outputs.color = true;
  return outputs;
}

TEST(Film, of_depth_has_one_scale_for_all_its_pictures) {
  const TemporaryFolder folder;
  const auto renderer = make_renderer(Backend::cpu, test::pool());
  renderer->upload(test::random_cloud(200, 1, 3), {});
  FilmPlan plan = plan_of_three_pictures();
  plan.ways.push_back({renderer.get(), {}, "quadbox"});
  plan.quantity = Quantity::depth;
  plan.scale = film_scale(plan, {});
  EXPECT_GT(plan.scale.high, 1) << "not the scale of alpha";
  write_film(folder / "film", plan, {});
  for (int i = 0; i < 3; ++i) {
    const Frame& frame =
        renderer->render(camera_of(plan.track, i, 3, kSize), {}, outputs_for(Quantity::depth));
    ValueMap map = map_of(frame, Quantity::depth, kSize.x, kSize.y);
    map.scale = plan.scale;
    const Image expected = colored(map);
    const Image picture = read_image(folder / "film" / fmt::format("frame_{:05}.png", i));
    ASSERT_EQ(picture.values.size(), expected.values.size());
    for (std::size_t k = 0; k < expected.values.size(); ++k)
      ASSERT_EQ(to_8bit(picture.values[k]), to_8bit(expected.values[k])) << i << " " << k;
  }
}

TEST(Film, of_heat_maps_has_one_scale_for_all_modes_and_pictures) {
  const TemporaryFolder folder;
  const auto renderer = make_renderer(Backend::cpu, test::pool());
  renderer->upload(test::random_cloud(200, 1, 3), {});
  FilmPlan plan = plan_of_two_modes(*renderer);
  plan.heatmap = FilmHeatmap{HeatQuantity::pairs, {}, {}, &test::pool()};
  const Scale scale = film_heat_scale(plan, find_culler("3dgs"), {});
  EXPECT_GT(scale.maximum, 1u);
  std::swap(plan.ways[0], plan.ways[1]);
  EXPECT_EQ(film_heat_scale(plan, find_culler("3dgs"), {}), scale);
  std::swap(plan.ways[0], plan.ways[1]);
  plan.heatmap->scale = scale;
  const auto numbers = write_film(folder / "film", plan, {});
  EXPECT_GT(numbers[0].tile_pairs, numbers[1].tile_pairs);
  for (int i = 0; i < 3; ++i) {
    const Image picture = read_image(folder / "film" / fmt::format("frame_{:05}.png", i));
    for (const std::size_t way : {0u, 1u}) {
      const Frame& frame = renderer->render(camera_of(plan.track, i, 3, kSize),
                                            plan.ways[way].settings, outputs_of_pairs());
      const Image expected =
          draw_over(frame.color, make_heatmap(frame, HeatQuantity::pairs, kSize.x, kSize.y), scale);
      const int begin = way == 0 ? 0 : 34, end = way == 0 ? 30 : 64;
      for (int y = 0; y < 48; ++y)
        for (int x = begin; x < end; ++x)
          ASSERT_EQ(to_8bit(picture.at(x, y, 1)), to_8bit(expected.at(x, y, 1))) << i << " " << x;
    }
  }
}

// A folder in the place of the last picture, or a camera that cannot be drawn.
TEST(Film, that_cannot_go_on_is_kept_as_far_as_it_got_if_the_plan_says_so) {
  const auto renderer = make_renderer(Backend::cpu, test::pool());
  renderer->upload(test::random_cloud(200, 1, 3), {});
  for (const bool written : {false, true}) {
    const TemporaryFolder folder;
    FilmPlan plan = plan_of_three_pictures();
    plan.ways.push_back({renderer.get(), {}, "quadbox"});
    plan.track.at = [&folder, written, at = plan.track.at](double share, glm::ivec2 size) {
      if (share == 1 && !written) throw Error(ErrorKind::device, "no memory");
      for (const auto& entry : std::filesystem::directory_iterator(folder.path()))
        std::filesystem::create_directory(entry.path() / "frame_00002.png");
      return at(share, size);
    };
    EXPECT_THROW(write_film(folder / "film", plan, {}), Error);
    EXPECT_FALSE(std::filesystem::exists(folder / "film"));
    std::string problem;
    plan.keeps_part = [&](const std::string& words) {
      problem = words;
      return true;
    };
    write_film(folder / "film", plan, {});
    EXPECT_THAT(names_in(folder / "film"), ElementsAre("frame_00000.png", "frame_00001.png"));
    const std::string place = (folder / "film/frame_00002.png").string();
    EXPECT_THAT(problem, written ? HasSubstr(place) : HasSubstr("no memory"));
  }
}

TEST(Film, its_pictures_are_the_frames_of_its_cameras) {
  const TemporaryFolder folder;
  const auto renderer = make_renderer(Backend::cpu, test::pool());
  renderer->upload(test::random_cloud(200, 1, 3), {});
  FilmPlan plan = plan_of_two_modes(*renderer);
  std::vector<float> reported;
  const Progress progress{[&](float fraction) { reported.push_back(fraction); }, {}};
  const auto numbers = write_film(folder / "film", plan, progress);
  EXPECT_THAT(reported, ElementsAre(1 / 3.0f, 2 / 3.0f, 1));
  std::vector<double> pairs[2];
  for (int i = 0; i < 3; ++i) {
    const Image picture = read_image(folder / "film" / fmt::format("frame_{:05}.png", i));
    const Camera camera = plan.track.at(0.5 * i, kSize);
    for (const std::size_t way : {0u, 1u}) {
      const Frame& frame = renderer->render(camera, plan.ways[way].settings);
      pairs[way].push_back(static_cast<double>(frame.stats.tile_pairs));
      const int begin = way == 0 ? 0 : 34, end = way == 0 ? 30 : 64;
      for (int y = 0; y < 48; ++y)
        for (int x = begin; x < end; ++x)
          ASSERT_EQ(to_8bit(picture.at(x, y, 1)), to_8bit(frame.color.at(x, y, 1))) << i;
    }
  }
  for (const std::size_t way : {0u, 1u}) {
    std::sort(pairs[way].begin(), pairs[way].end());
    EXPECT_EQ(numbers[way].tile_pairs, pairs[way][1]);
    EXPECT_GT(numbers[way].frame_ms, 0);
  }
}

}  // namespace
}  // namespace qs
