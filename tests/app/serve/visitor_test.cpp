// SPDX-License-Identifier: MIT
//
// A visitor's viewer, the pictures that it orders, and the state that is sent; without sockets.
#include "app/serve/visitor.h"

#define GLFW_INCLUDE_NONE
#include <condition_variable>
#include <cstring>
#include <mutex>
#include <set>

#include <GLFW/glfw3.h>
#include <glm/gtc/quaternion.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/framing/camera_control.h"
#include "app/serve/picture_message.h"
#include "app/serve/serve_scenes.h"
#include "app/serve/served_commands.h"
#include "app/serve/state_json.h"
#include "app/viewer/render/host_frames.h"
#include "io/picture/webp_image.h"

namespace qs {
namespace {

using testing::HasSubstr;
using testing::Not;

class ServeVisitor : public testing::Test {
 protected:
  test::SmallScenes small_;
  double now_ = 100;
  Visitor visitor_{small_.opened, {64, 48}, now_};

  const Viewer& viewer() const { return visitor_.viewer(); }
  template <class Body>
  void take(Body body, std::uint32_t input = 1) {
    visitor_.take({input, std::move(body)}, now_);
  }
  void key(int key, bool down, int mods = 0) { take(message::Key{key, down, false, mods}); }
  void wait(double seconds) {
    for (const double end = now_ + seconds; now_ < end; now_ += 0.02) visitor_.tick(now_);
  }
  // The answer to an order, without rendering.
  void answer(const PictureOrder& order) {
    Picture picture;
    picture.order = order;
    picture.encoded.bytes = "x";
    picture.shown.version = order.request.version;
    visitor_.picture_ready(picture, now_);
  }
};

TEST_F(ServeVisitor, starts_at_the_first_camera) {
  EXPECT_EQ(viewer().dataset_camera, 0);
  EXPECT_EQ(viewer().camera.width, 64);
  EXPECT_EQ(viewer().camera.view_from_world, small_.opened[0]->facts.cameras[0].view_from_world);
}

TEST_F(ServeVisitor, orders_one_quick_and_then_one_exact_picture) {
  wait(0.5);
  const auto first = visitor_.next_order();
  ASSERT_TRUE(first);
  EXPECT_FALSE(first->lossless);
  answer(*first);
  const auto second = visitor_.next_order();
  ASSERT_TRUE(second);
  EXPECT_TRUE(second->lossless);
  EXPECT_EQ(second->request.divisor, 1);
  answer(*second);
  EXPECT_FALSE(visitor_.next_order()) << "an idle visitor costs nothing";
  EXPECT_FALSE(visitor_.is_busy()) << "nor does it need turns";
}

TEST_F(ServeVisitor, exact_pictures_come_soon_and_whole_though_moving_ones_are_small) {
  std::optional<PictureOrder> order;
  for (int i = 0; i < 30; ++i) {
    take(message::Wheel{i % 2 == 0 ? 1.0 : -1.0, 0});
    order = visitor_.next_order();
    ASSERT_TRUE(order);
    Picture slow;
    slow.order = *order;
    slow.encoded.bytes = "x";
    slow.shown.version = order->request.version;
    slow.shown.divisor = order->request.divisor;
    slow.shown.stats.frame_ms = 900.0f / static_cast<float>(slow.shown.divisor);
    slow.shown.stats.stage_ms[static_cast<int>(Stage::blend)] = slow.shown.stats.frame_ms;
    visitor_.picture_ready(slow, now_);
    now_ += 0.02;
  }
  EXPECT_GT(order->request.divisor, 1);
  EXPECT_FALSE(visitor_.next_order()) << "the camera may move on";
  wait(0.15);
  const auto exact = visitor_.next_order();
  ASSERT_TRUE(exact);
  EXPECT_TRUE(exact->lossless);
  EXPECT_EQ(exact->request.divisor, 1);
  EXPECT_FALSE(exact->request.moving);
}

TEST_F(ServeVisitor, slow_lines_make_pictures_smaller_and_never_exact_ones) {
  take(message::Video{true});
  std::optional<PictureOrder> order;
  for (int i = 0; i < 40; ++i) {
    take(message::Wheel{i % 2 == 0 ? 1.0 : -1.0, 0});
    order = visitor_.next_order({1e6, 1e6, 1e6});
    ASSERT_TRUE(order);
    Picture coarse;
    coarse.order = *order;
    coarse.encoded.codec = order->encoding.codec;
    coarse.encoded.bytes = std::string(100'000, 'x');
    coarse.encoded.quantizer = kMostQuantizer;
    coarse.shown.version = order->request.version;
    coarse.shown.divisor = order->request.divisor;
    visitor_.picture_ready(coarse, now_);
  }
  EXPECT_EQ(order->encoding.codec, has_vp9() ? PictureCodec::vp9 : PictureCodec::jpeg);
  EXPECT_GT(order->request.divisor, 1);
  wait(0.15);
  EXPECT_EQ(visitor_.next_order({1e6, 1e6, 1e6})->request.divisor, 1);
}

TEST_F(ServeVisitor, video_of_large_windows_is_reduced) {
  take(message::Resize{{4096, 4096}});
  EXPECT_EQ(visitor_.next_order({5e6, 5e6, 5e6})->request.divisor, 1) << "JPEG";
  take(message::Video{true});
  const auto divisor = [&](int width, int height) {
    take(message::Resize{{width, height}});
    const auto order = visitor_.next_order({5e6, 5e6, 5e6});
    return order && order->encoding.codec == PictureCodec::vp9 ? order->request.divisor : 0;
  };
  if (!has_vp9()) GTEST_SKIP() << "needs libvpx";
  EXPECT_EQ(divisor(1920, 1200), 1);
  EXPECT_EQ(divisor(4096, 4096), 3);
  EXPECT_EQ(divisor(1921, 1200), 2);
  EXPECT_EQ(divisor(1, 1), 1);
}

TEST_F(ServeVisitor, a_cancelled_exact_picture_is_ordered_again) {
  wait(0.5);
  answer(*visitor_.next_order());
  const auto exact = visitor_.next_order();
  Picture cancelled;
  cancelled.order = *exact;
  visitor_.picture_ready(cancelled, now_);
  const auto again = visitor_.next_order();
  ASSERT_TRUE(again);
  EXPECT_TRUE(again->lossless);
}

TEST_F(ServeVisitor, only_the_newest_view_is_ordered) {
  take(message::Button{GLFW_MOUSE_BUTTON_LEFT, true, {10, 10}});
  for (int x = 11; x < 40; ++x) take(message::Cursor{{x, 10}}, static_cast<std::uint32_t>(x));
  const auto order = visitor_.next_order();
  ASSERT_TRUE(order);
  EXPECT_EQ(order->input, 39u);
  EXPECT_EQ(order->request.camera.view_from_world, viewer().camera.view_from_world);
  EXPECT_FALSE(order->lossless);
  EXPECT_FALSE(visitor_.next_order());
}

TEST_F(ServeVisitor, mouse_and_keys_move_the_camera_as_in_the_window) {
  Viewer expected = viewer();
  const Camera start = viewer().camera;
  take(message::Button{GLFW_MOUSE_BUTTON_LEFT, true, {10, 10}});
  take(message::Cursor{{20, 13}});
  take(message::Button{GLFW_MOUSE_BUTTON_LEFT, false, {20, 13}});
  const Camera turned = orbited(start, expected.pivot, expected.scene->up, 0.05, 0.015);
  EXPECT_EQ(viewer().camera.view_from_world, turned.view_from_world);
  const glm::dvec3 before = viewer().camera.position();
  key(GLFW_KEY_W, true);
  wait(0.5);
  EXPECT_TRUE(visitor_.is_busy());
  key(GLFW_KEY_W, false);
  wait(2);
  EXPECT_GT(glm::distance(viewer().camera.position(), before), 1e-3);
  const glm::dvec3 after = viewer().camera.position();
  wait(1);
  EXPECT_EQ(viewer().camera.position(), after);
}

TEST_F(ServeVisitor, losing_the_keyboard_releases_the_keys) {
  key(GLFW_KEY_W, true);
  take(message::Blur{});
  wait(2);
  const glm::dvec3 after = viewer().camera.position();
  wait(1);
  EXPECT_EQ(viewer().camera.position(), after);
}

TEST_F(ServeVisitor, the_open_panels_are_stated_and_not_toggled) {
  for (int reload = 0; reload < 2; ++reload) {
    take(message::ShowPanels{{"Crop and clean", "quit"}});
    EXPECT_TRUE(viewer().panels.crop);
    EXPECT_FALSE(viewer().panels.inspector);
  }
  take(message::ShowPanels{});
  EXPECT_FALSE(viewer().panels.crop);
}

TEST_F(ServeVisitor, commands_that_are_not_served_have_no_effect) {
  const int version = viewer().version;
  for (const KeyCommand& command : key_commands()) {
    if (find_served_command(command.help) != nullptr) continue;
    key(command.key, true, command.mods);
    key(command.key, false, command.mods);
    take(message::Command{command.help});
  }
  EXPECT_EQ(viewer().version, version);
  EXPECT_FALSE(viewer().panels.open);
  EXPECT_TRUE(viewer().toasts.empty());
  EXPECT_TRUE(visitor_.host().take_jobs().empty());
}

TEST_F(ServeVisitor, no_served_command_is_refused) {
  for (const KeyCommand* command : served_commands()) {
    key(command->key, true, command->mods);
    key(command->key, false, command->mods);
    take(message::Command{command->help});
    wait(0.5);
  }
  for (const LogEntry& entry : viewer().log) EXPECT_FALSE(entry.error) << entry.text;
}

TEST_F(ServeVisitor, modes_and_maps_follow_the_window_s_keys) {
  key(GLFW_KEY_1, true);
  EXPECT_EQ(viewer().settings.mode, 1);
  take(message::Command{mode_name(3)});
  EXPECT_EQ(viewer().settings.mode, 3);
  key(GLFW_KEY_H, true);
  EXPECT_EQ(viewer().heatmap, HeatQuantity::pairs);
  EXPECT_EQ(visitor_.next_order()->request.heatmap, HeatQuantity::pairs);
}

TEST_F(ServeVisitor, each_visitor_has_a_camera_of_their_own) {
  const Visitor other(small_.opened, {64, 48}, now_);
  take(message::Wheel{3, 0});
  EXPECT_NE(viewer().camera.view_from_world, other.viewer().camera.view_from_world);
}

TEST_F(ServeVisitor, scenes_are_chosen_by_number) {
  take(message::ShowScene{1});
  EXPECT_EQ(visitor_.next_order()->scene, 1u);
  take(message::ShowScene{2});
  EXPECT_EQ(visitor_.scene(), 1u) << "there is no third scene";
}

TEST_F(ServeVisitor, the_state_has_no_path) {
  take(message::ShowScene{1});
  wait(0.3);
  for (const KeyCommand* command : served_commands()) take(message::Command{command->help});
  const std::string all = state_message({}, state_sections(visitor_, small_.opened), 1);
  EXPECT_THAT(all, HasSubstr("scene1"));
  EXPECT_THAT(all, Not(HasSubstr("secret")));
  EXPECT_THAT(all, Not(HasSubstr(small_.folder.path().string())));
}

TEST_F(ServeVisitor, only_changed_sections_are_sent) {
  const StateSections before = state_sections(visitor_, small_.opened);
  EXPECT_EQ(state_message(before, before, 2), "");
  take(message::Command{mode_name(2)});
  const auto sent =
      nlohmann::json::parse(state_message(before, state_sections(visitor_, small_.opened), 2));
  EXPECT_EQ(sent.at("version"), 2);
  EXPECT_EQ(sent.at("sections").size(), 2u);
  EXPECT_TRUE(sent.at("sections").contains("status"));
  EXPECT_EQ(sent.at("sections").at("view").at("mode"), mode_name(2));
}

// ---- pictures -----------------------------------------------------------------------------------
class ServePictures : public ServeVisitor {
 protected:
  // Orders pictures and returns the answers, in the order in which they come.
  std::vector<std::pair<int, Picture>> draw(
      const std::vector<std::pair<int, PictureOrder>>& orders) {
    std::mutex mutex;
    std::condition_variable changed;
    std::vector<std::pair<int, Picture>> ready;
    Pictures pictures(small_.scenes, {[](int) {},
                                      [&](int visitor, Picture picture) {
                                        const std::lock_guard lock(mutex);
                                        ready.emplace_back(visitor, std::move(picture));
                                        changed.notify_all();
                                      },
                                      [](int, const Actions&) {}});
    for (const auto& [visitor, order] : orders) pictures.order(visitor, order);
    std::unique_lock lock(mutex);
    changed.wait_for(lock, std::chrono::seconds(20), [&] { return ready.size() >= orders.size(); });
    return ready;
  }
};

TEST_F(ServePictures, exact_pictures_have_the_pixels_of_render) {
  wait(0.5);
  answer(*visitor_.next_order());
  const PictureOrder exact = *visitor_.next_order();
  const auto ready = draw({{1, exact}});
  ASSERT_EQ(ready.size(), 1u);
  const Picture& picture = ready[0].second;
  EXPECT_EQ(picture.error, "");
  EXPECT_EQ(picture.encoded.codec, PictureCodec::webp);
  const auto pixels = decode_webp(std::as_bytes(std::span(picture.encoded.bytes)), "test");
  const Session& session = small_.scenes[0]->context.session;
  const Frame& frame = session.renderer->render(small_.opened[0]->facts.cameras[0].resized(64, 48),
                                                session.settings);
  const std::vector<std::uint8_t> expected = to_rgba(frame.color);
  EXPECT_TRUE(std::equal(pixels.begin(), pixels.end(), expected.begin(), expected.end()));
}

TEST_F(ServePictures, every_visitor_gets_an_answer) {
  const PictureOrder order = *visitor_.next_order();
  std::vector<std::pair<int, PictureOrder>> orders;
  for (int visitor = 1; visitor <= 20; ++visitor) orders.emplace_back(visitor, order);
  std::set<int> answered;
  for (const auto& [visitor, picture] : draw(orders)) {
    EXPECT_EQ(picture.error, "");
    EXPECT_EQ(picture.encoded.codec, PictureCodec::jpeg);
    answered.insert(visitor);
  }
  EXPECT_EQ(answered.size(), 20u);
}

TEST_F(ServePictures, visitors_share_the_renderer_equally) {
  const PictureOrder order = *visitor_.next_order();
  std::mutex mutex;
  std::condition_variable changed;
  int alone = 0;              // pictures of visitor 1 before visitor 2 came
  int counts[3] = {0, 0, 0};  // since then
  bool both = false;
  Pictures* all = nullptr;
  Pictures pictures(small_.scenes, {[](int) {},
                                    [&](int visitor, const Picture&) {
                                      const std::lock_guard lock(mutex);
                                      ++(both ? counts[visitor] : alone);
                                      if (counts[1] + counts[2] < 200) all->order(visitor, order);
                                      changed.notify_all();
                                    },
                                    [](int, const Actions&) {}});
  all = &pictures;
  pictures.order(1, order);
  std::unique_lock lock(mutex);
  ASSERT_TRUE(changed.wait_for(lock, std::chrono::seconds(20), [&] { return alone >= 50; }));
  both = true;
  pictures.order(2, order);
  ASSERT_TRUE(changed.wait_for(lock, std::chrono::seconds(20),
                               [&] { return counts[1] + counts[2] >= 200; }));
  EXPECT_GT(counts[1], 60) << "a newcomer has no claim on the time before";
  EXPECT_GT(counts[2], 60);
}

TEST_F(ServePictures, a_lone_visitor_has_all_threads_of_video_beside_the_jobs_of_others) {
  std::mutex mutex;
  std::condition_variable changed;
  int ended = 0;  // jobs
  std::optional<Picture> ready;
  Pictures pictures(small_.scenes, {[](int) {},
                                    [&](int, Picture picture) {
                                      const std::lock_guard lock(mutex);
                                      ready = std::move(picture);
                                      changed.notify_all();
                                    },
                                    [&](int, const Actions&) {
                                      const std::lock_guard lock(mutex);
                                      ++ended;
                                      changed.notify_all();
                                    }});
  for (int other = 100; other < 120; ++other) pictures.run(other, 0, [](RenderContext&) {});
  std::unique_lock lock(mutex);
  ASSERT_TRUE(changed.wait_for(lock, std::chrono::seconds(20), [&] { return ended == 20; }));
  pictures.order(1, *visitor_.next_order());
  ASSERT_TRUE(changed.wait_for(lock, std::chrono::seconds(20), [&] { return ready.has_value(); }));
  EXPECT_EQ(ready->order.encoding.threads,
            video_threads(std::max(2u, std::thread::hardware_concurrency()), 1));
}

TEST_F(ServePictures, maps_are_painted_over_the_picture) {
  key(GLFW_KEY_H, true);
  const PictureOrder map = *visitor_.next_order();
  PictureOrder plain = map;
  plain.request.heatmap.reset();
  const auto ready = draw({{1, map}, {2, plain}});
  ASSERT_EQ(ready.size(), 2u);
  EXPECT_NE(ready[0].second.encoded.bytes, ready[1].second.encoded.bytes);
}

template <class T>
T at(const std::string& message, std::size_t place) {
  T value;
  std::memcpy(&value, message.data() + place, sizeof(T));
  return value;
}

TEST_F(ServePictures, headers_have_the_camera_and_the_input) {
  take(message::Wheel{1, 0}, 77);
  Picture picture;
  picture.order = *visitor_.next_order();
  picture.order.request.divisor = 2;
  picture.order.lossless = true;
  picture.encoded.codec = PictureCodec::webp;
  picture.width = 32;
  picture.height = 24;
  picture.top = 200;
  picture.is_last = false;
  picture.encoded.bytes = std::string(kPicturePart, 'a') + "bc";
  const std::string first = picture_message(picture, {5, 6, 7}, 0);
  ASSERT_EQ(first.size(), kPictureHeader + kPicturePart);
  EXPECT_EQ(at<std::uint8_t>(first, 0), 1);
  EXPECT_EQ(at<std::uint8_t>(first, 1), 2);
  EXPECT_EQ(at<std::uint8_t>(first, 2), kLosslessFlag);
  EXPECT_EQ(at<std::uint16_t>(first, 20), 200);
  EXPECT_EQ(at<std::uint8_t>(first, 3), 2);
  EXPECT_EQ(at<std::uint32_t>(first, 4), 5u);
  EXPECT_EQ(at<std::uint32_t>(first, 8), 77u);
  EXPECT_EQ(at<std::uint32_t>(first, 12), 6u);
  EXPECT_EQ(at<std::uint16_t>(first, 16), 32);
  EXPECT_EQ(at<std::uint16_t>(first, 18), 24);
  EXPECT_EQ(at<std::uint64_t>(first, 24), 7u);
  const glm::dvec3 position(at<double>(first, 32), at<double>(first, 40), at<double>(first, 48));
  EXPECT_LT(glm::distance(position, viewer().camera.position()), 1e-12);
  const glm::dquat rotation(at<double>(first, 80), at<double>(first, 56), at<double>(first, 64),
                            at<double>(first, 72));
  const glm::dmat3 matrix = glm::mat3_cast(rotation), expected(viewer().camera.view_from_world);
  for (int c = 0; c < 3; ++c) EXPECT_LT(glm::distance(matrix[c], expected[c]), 1e-9);
  EXPECT_FLOAT_EQ(at<float>(first, 88), static_cast<float>(viewer().camera.focal_px.x / 2));
  const std::string last = picture_message(picture, {5, 6, 7}, kPicturePart);
  EXPECT_EQ(at<std::uint8_t>(last, 2), kLosslessFlag | kLastPartFlag);
  EXPECT_EQ(last.substr(kPictureHeader), "bc");
  picture.is_last = true;
  EXPECT_EQ(at<std::uint8_t>(picture_message(picture, {5, 6, 7}, kPicturePart), 2),
            kLosslessFlag | kLastPartFlag | kLastStripFlag);
}

}  // namespace
}  // namespace qs
