// SPDX-License-Identifier: MIT
//
// Crop and clean without a window: the user's choices, the scene that the render thread shows, the
// written files, and the mathematics of the box's handles.
#include <fstream>
#include <numeric>

#include <glm/geometric.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/framing/camera_control.h"
#include "app/picture/palette.h"
#include "app/session/removal_text.h"
#include "app/support/driven_viewer.h"
#include "app/support/rendering_viewer.h"
#include "app/viewer/commands/jobs.h"
#include "app/viewer/render/upload_scene.h"
#include "app/viewer/state/edit_actions.h"
#include "support/pool.h"

namespace qs {
namespace {

using test::DrivenScene;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;
using namespace action;

const CropBox kUnit{{-1, -2, -3}, {1, 2, 3}};

glm::dvec2 pixel_of(const Camera& camera, glm::dvec3 point) {
  const glm::dvec3 at = camera.view_from_world * glm::dvec4(point, 1);
  return glm::dvec2(at) / at.z * camera.focal_px + camera.center_px;
}

// ---- handles -----------------------------------------------------------------------------------
TEST(CropHandles, are_in_the_middle_of_the_faces) {
  const CropBox box{{-1, 0, 2}, {3, 4, 8}};
  EXPECT_EQ(handle_of(box, 0), glm::dvec3(-1, 2, 5));
  EXPECT_EQ(handle_of(box, 1), glm::dvec3(3, 2, 5));
  EXPECT_EQ(handle_of(box, 2), glm::dvec3(1, 0, 5));
  EXPECT_EQ(handle_of(box, 3), glm::dvec3(1, 4, 5));
  EXPECT_EQ(handle_of(box, 4), glm::dvec3(1, 2, 2));
  EXPECT_EQ(handle_of(box, 5), glm::dvec3(1, 2, 8));
}

TEST(CropHandles, a_face_follows_the_cursor_along_its_axis) {
  const Camera camera = look_at({5, -4, -9}, {0, 0, 0}, {0, -1, 0}, 1, 800, 600);
  for (int face = 0; face < kBoxFaces; ++face) {
    for (const double by : {-0.5, 0.0, 0.25, 0.9}) {
      glm::dvec3 target = handle_of(kUnit, face);
      target[face / 2] += by;
      const auto box = dragged(kUnit, face, camera, pixel_of(camera, target));
      ASSERT_TRUE(box) << face;
      EXPECT_LT(glm::distance(handle_of(*box, face), target), 1e-5) << face;
      CropBox restored = *box;
      (face % 2 == 0 ? restored.low : restored.high)[face / 2] =
          (face % 2 == 0 ? kUnit.low : kUnit.high)[face / 2];
      EXPECT_EQ(restored, kUnit) << "the other faces stay";
    }
  }
}

TEST(CropHandles, a_cursor_beside_the_axis_counts_by_its_nearest_place) {
  const Camera camera = look_at({0, 0, -10}, {0, 0, 0}, {0, -1, 0}, 1, 800, 600);
  const glm::dvec2 pixel = pixel_of(camera, {0.7, 0.3, 0});
  const auto by = slide_along(camera, {0, 0, 0}, {1, 0, 0}, pixel);
  ASSERT_TRUE(by);
  EXPECT_NEAR(*by, 0.7, 0.7 * 0.01);
}

TEST(CropHandles, a_face_stops_at_the_opposite_one) {
  const Camera camera = look_at({5, -4, -9}, {0, 0, 0}, {0, -1, 0}, 1, 800, 600);
  const auto low = dragged(kUnit, 0, camera, pixel_of(camera, {1.5, 0, 0}));
  ASSERT_TRUE(low);
  EXPECT_EQ(low->low.x, 1);
  const auto high = dragged(kUnit, 1, camera, pixel_of(camera, {-1.5, 0, 0}));
  ASSERT_TRUE(high);
  EXPECT_EQ(high->high.x, -1);
}

TEST(CropHandles, an_axis_along_the_view_and_one_behind_the_camera_are_not_followed) {
  const Camera camera = look_at({0, 0, -10}, {0, 0, 0}, {0, -1, 0}, 1, 800, 600);
  EXPECT_FALSE(dragged(kUnit, 4, camera, camera.center_px));
  EXPECT_FALSE(slide_along(camera, {0, 0, -20}, {1, 0, 0}, camera.center_px));
}

// ---- the user's choices ------------------------------------------------------------------------
CropWish boxed(const CropBox& box) {
  CropWish wish;
  wish.boxed = true;
  wish.box = box;
  return wish;
}

TEST(Crop, the_first_box_is_around_the_core_and_is_counted_while_the_panel_is_open) {
  DrivenScene driven(1);
  driven.press("R");
  EXPECT_EQ(wanted_crop(driven.viewer), CropRequest());
  EXPECT_EQ(crop_text(driven.viewer), "Choose a box or floaters, or select Gaussians.");
  CropWish wish;
  wish.boxed = true;
  driven.apply(change_crop, wish);
  EXPECT_EQ(driven.viewer.crop.wish.box, (CropBox{glm::vec3(-1.5f), glm::vec3(1.5f)}));
  EXPECT_TRUE(wanted_crop(driven.viewer).counts());
  driven.press("R");
  EXPECT_EQ(wanted_crop(driven.viewer), CropRequest());
}

TEST(Crop, one_request_is_under_way_and_the_newest_comes_next) {
  DrivenScene driven(1);
  driven.press("R");
  driven.apply(follow_edits);
  EXPECT_THAT(driven.jobs, IsEmpty());
  driven.apply(change_crop, boxed(kUnit));
  driven.apply(follow_edits);
  driven.apply(follow_edits);
  driven.apply(change_crop, boxed({{0, 0, 0}, {1, 1, 1}}));
  driven.apply(follow_edits);
  EXPECT_THAT(driven.jobs, SizeIs(1));
  EXPECT_EQ(crop_text(driven.viewer), "counting");
  const auto shown = [&](std::size_t left, std::size_t outside) {
    return ShownCrop{.counts = RemovalCounts{{left, outside}},
                     .edits = driven.viewer.scene->edits,
                     .gaussians = 500};
  };
  driven.apply(crop_shown, CropRequest{.wish = boxed(kUnit)}, shown(497, 3));
  EXPECT_EQ(crop_text(driven.viewer), "not counted");
  driven.apply(follow_edits);
  EXPECT_THAT(driven.jobs, SizeIs(2));
  driven.apply(crop_shown, wanted_crop(driven.viewer), shown(496, 4));
  driven.apply(follow_edits);
  EXPECT_THAT(driven.jobs, SizeIs(2));
  EXPECT_EQ(crop_text(driven.viewer), "4 of 500 Gaussians would go: 4 outside of the box");
}

TEST(Crop, a_side_that_passes_the_opposite_one_stays_at_it) {
  DrivenScene driven(1);
  driven.apply(change_crop, boxed(kUnit));
  driven.apply(change_crop, boxed({{5, -2, -3}, {1, 2, 3}}));
  EXPECT_EQ(driven.viewer.crop.wish.box.low.x, 1);
  EXPECT_EQ(driven.viewer.crop.wish.box.high.x, 1);
  driven.apply(change_crop, boxed({{1, -2, -3}, {1, 2, -9}}));
  EXPECT_EQ(driven.viewer.crop.wish.box.high.z, -3);
}

// Answers the step that runs, if one does: these Gaussians of 500 are gone.
void answer(DrivenScene& driven, const std::vector<std::size_t>& gone) {
  driven.apply([&](Viewer& viewer) {
    ASSERT_FALSE(viewer.editing.waiting.empty());
    const EditStep step = viewer.editing.waiting.front();
    viewer.editing.waiting.pop_front();
    viewer.editing.busy = true;
    EditState after(500);
    for (const std::size_t i : gone) after.removed.add(i);
    step_done(viewer, step, std::make_shared<const EditState>(after));
  });
}

TEST(Crop, applies_what_leaves_something_and_takes_something) {
  DrivenScene driven(1);
  driven.press("Shift+R");
  EXPECT_THAT(driven.viewer.editing.waiting, IsEmpty());
  EXPECT_TRUE(driven.viewer.panels.crop) << "where a box is chosen";
  const auto apply_unit = [&](const std::vector<std::size_t>& gone) {
    driven.apply(change_crop, boxed(kUnit));
    driven.press("Shift+R");
    answer(driven, gone);
    return driven.viewer.editing.gone != nullptr;
  };
  EXPECT_FALSE(apply_unit({}));
  EXPECT_EQ(driven.viewer.toasts.back().text, "nothing would go");
  std::vector<std::size_t> all(500);
  std::iota(all.begin(), all.end(), std::size_t{0});
  EXPECT_FALSE(apply_unit(all));
  EXPECT_TRUE(driven.viewer.toasts.back().error);
  EXPECT_TRUE(driven.viewer.crop.wish.boxed) << "another box may leave something";
  EXPECT_TRUE(apply_unit({1, 2, 3}));
  EXPECT_FALSE(driven.viewer.crop.wish.boxed);
  EXPECT_EQ(driven.viewer.toasts.back().text, "3 of 500 Gaussians removed");
  EXPECT_EQ(crop_text(driven.viewer), "497 of 500 Gaussians are left: 3 removed");
  const CropRequest rest{.gone = driven.viewer.editing.gone, .steps = 1};
  EXPECT_EQ(wanted_crop(driven.viewer), rest);
  driven.press("R");
  EXPECT_EQ(wanted_crop(driven.viewer), rest) << "also with a closed panel";
}

TEST(Crop, applying_twice_crops_twice_and_each_undo_takes_one_crop_back) {
  DrivenScene driven(1);
  driven.press("R");
  const CropWish second = boxed({{0, 0, 0}, {1, 1, 1}});
  driven.apply(change_crop, boxed(kUnit));
  driven.press("Shift+R");
  driven.press("Shift+R");  // a second press while the first waits
  EXPECT_THAT(driven.viewer.editing.waiting, SizeIs(1));
  answer(driven, {7});
  const auto first = driven.viewer.editing.gone;
  driven.apply(change_crop, second);
  const CropRequest request{.gone = first, .steps = 1, .wish = driven.viewer.crop.wish};
  EXPECT_EQ(wanted_crop(driven.viewer), request) << "of the rest of the first";
  driven.press("Shift+R");
  answer(driven, {7, 8});
  EXPECT_EQ(wanted_crop(driven.viewer).steps, 2);
  EXPECT_EQ(driven.viewer.editing.gone->count(), 2u);
  driven.press("Ctrl+Z");
  EXPECT_EQ(*driven.viewer.editing.gone, *first);
  EXPECT_EQ(wanted_crop(driven.viewer).steps, 1);
  driven.press("Shift+R");  // there are no criteria
  EXPECT_EQ(wanted_crop(driven.viewer), CropRequest());
  EXPECT_EQ(driven.viewer.toasts.back().text, "the whole scene again");
  driven.press("Ctrl+Shift+Z");
  EXPECT_EQ(*driven.viewer.editing.gone, *first);
}

TEST(Crop, the_first_box_is_around_the_subject_with_the_camera_outside) {
  ViewedScene scene = test::some_scene(1);
  scene.subject = {glm::vec3(-1, -2, -1), glm::vec3(1, 2, 1)};
  EXPECT_EQ(first_box(scene, {0, 0, -10}), (CropBox{{-1.5f, -3, -1.5f}, {1.5f, 3, 1.5f}}));
  const CropBox near = first_box(scene, {0, 0, -1.3});
  EXPECT_GT(near.low.z, -1.3f);
  EXPECT_LT(near.low.z, -1);
}

TEST(Crop, show_all_moves_the_camera_until_the_whole_box_is_visible) {
  DrivenScene driven(1);
  driven.apply(show_crop_box);
  driven.apply(change_crop, boxed(kUnit));
  const Camera before = driven.viewer.camera;
  driven.apply(show_crop_box);
  const Camera& after = driven.viewer.camera;
  EXPECT_NE(before.position(), after.position());
  for (int i = 0; i < 8; ++i) {
    const glm::dvec3 corner(i & 1 ? 1 : -1, i & 2 ? 2 : -2, i & 4 ? 3 : -3);
    const glm::dvec2 at = pixel_of(after, corner);
    EXPECT_TRUE(at.x > 0 && at.y > 0 && at.x < after.width && at.y < after.height) << i;
  }
}

TEST(Crop, another_scene_is_whole) {
  DrivenScene driven(1);
  driven.press("R");
  driven.apply(change_crop, boxed(kUnit));
  driven.apply(scene_opened, OpenedScene{test::some_scene(1), RenderSettings(), Backend::cpu});
  EXPECT_EQ(wanted_crop(driven.viewer), CropRequest());
  EXPECT_FALSE(driven.viewer.crop.busy);
}

TEST(Crop, is_chosen_in_words) {
  DrivenScene driven(1);
  driven.apply(choose_crop, std::string("-1,-2,-3,1,2,3"));
  driven.apply(choose_crop, std::string("floaters"));
  EXPECT_EQ(driven.viewer.crop.wish.box, kUnit);
  EXPECT_TRUE(driven.viewer.crop.wish.boxed && driven.viewer.crop.wish.cleans);
  EXPECT_EQ(format_crop_box(kUnit), "-1,-2,-3,1,2,3");
  driven.apply(choose_crop, std::string("nothing"));
  EXPECT_FALSE(driven.viewer.crop.wish.removes());
  driven.apply(choose_crop, std::string("1,2,3"));
  EXPECT_THAT(driven.viewer.toasts.back().text, HasSubstr("crop: '1,2,3' is not X0,Y0,Z0"));
}

TEST(Crop, is_not_for_a_model_that_is_being_trained) {
  DrivenScene driven(1);
  driven.press("R");
  driven.apply(change_crop, boxed(kUnit));
  driven.apply([](Viewer& viewer) { viewer.training = Training(); });
  EXPECT_EQ(wanted_crop(driven.viewer), CropRequest());
  driven.press("Shift+R");
  EXPECT_THAT(driven.viewer.editing.waiting, IsEmpty());
  EXPECT_THAT(driven.viewer.toasts.back().text, HasSubstr("is being trained"));
}

// ---- the scene that the render thread shows -----------------------------------------------------
class CropJobs : public test::RenderingViewer {
 protected:
  CropJobs() {
    box_ = {{-100, -100, -100}, {0, 100, 100}};
    for (const glm::vec3& position : cloud_.positions) inside_ += position.x <= 0 ? 1 : 0;
    change([](Viewer& v) { v.scene->gaussians = 300; });
    EXPECT_GT(inside_, 20u);
    EXPECT_LT(inside_, 280u);
  }
  void follow() {
    do {
      apply(call(action::follow_edits));
      settle();
    } while (viewer().editing.busy || viewer().crop.asked != wanted_crop(viewer()));
  }
  std::vector<std::uint8_t> picture() {
    request_ = full_frame(viewer());
    return draw(request_)->rgba;
  }
  std::vector<std::uint8_t> picture_of(GaussianCloud cloud) {
    ThreadPool pool(1);
    const auto renderer = make_renderer(Backend::cpu, pool);
    renderer->upload(std::move(cloud), {});
    std::vector<std::uint8_t> rgba;
    const Frame& frame = renderer->render(viewer().camera, viewer().settings, {});
    for (std::size_t i = 0; i < frame.color.values.size(); ++i) {
      rgba.push_back(to_8bit(frame.color.values[i]));
      if (i % 3 == 2) rgba.push_back(255);
    }
    return rgba;
  }

  GaussianCloud cloud_ = test::random_cloud(300, 1, 5);
  CropBox box_;
  std::size_t inside_ = 0;
};

TEST_F(CropJobs, what_goes_is_tinted_then_gone_then_back) {
  const std::vector<std::uint8_t> before = picture();
  const int view = viewer().view_version;
  press("R");
  apply(call(action::change_crop, boxed(box_)));
  follow();
  ASSERT_TRUE(viewer().crop.counts);
  EXPECT_EQ(viewer().crop.counts->counts[0], inside_);
  EXPECT_EQ(viewer().scene->gaussians, 300u);
  const Removal removal = find_removal(cloud_, box_, {});
  // The tint is over the finished picture: more where more of a pixel goes, with stripes.
  const std::vector<std::uint8_t> shown = picture();
  Outputs outputs;
  outputs.share = viewer().crop.tint;
  ASSERT_TRUE(outputs.share);
  EXPECT_EQ(*outputs.share, removal.gone(test::pool()));
  const auto renderer = make_renderer(Backend::cpu, test::pool());
  renderer->upload(GaussianCloud(cloud_), {});
  const std::vector<float> share =
      renderer->render(viewer().camera, viewer().settings, outputs).share;
  const glm::vec3 tint = kVermillion;
  std::size_t strong = 0, weak = 0;
  for (std::size_t i = 0; i < share.size(); ++i) {
    for (std::size_t c = 0; c < 3; ++c) {
      const float old = static_cast<float>(before[4 * i + c]) / 255;
      const float way = tint[static_cast<int>(c)] - old;
      const float moved = static_cast<float>(shown[4 * i + c]) / 255 - old;
      EXPECT_GE(moved * way, 0) << i;
      EXPECT_LE(std::abs(moved), 0.8f * share[i] * std::abs(way) + 0.003f) << i;
      if (share[i] > 0.3f && std::abs(way) > 0.3f)
        (moved / way / share[i] > 0.65f ? strong : weak) += 1;
    }
  }
  EXPECT_GT(strong, 50u);
  EXPECT_GT(weak, 50u);
  EXPECT_EQ(viewer().view_version, view) << "numbers of the view stay";
  EXPECT_TRUE(viewer().scene->edits == EditFacts());

  press("Shift+R");
  follow();
  EXPECT_EQ(viewer().scene->gaussians, inside_);
  EXPECT_THAT(viewer().toasts.back().text, HasSubstr("of 300 Gaussians removed"));
  EXPECT_EQ(picture(), picture_of(keep_rest(cloud_, removal)));

  press("Shift+R");
  follow();
  EXPECT_EQ(viewer().scene->gaussians, 300u);
  EXPECT_EQ(picture(), before);
  EXPECT_FALSE(viewer().crop.counts);
}

TEST_F(CropJobs, without_the_tint_the_picture_stays_and_what_goes_is_counted) {
  const std::vector<std::uint8_t> before = picture();
  press("R");
  apply(call(action::mark_removed, false));
  apply(call(action::change_crop, boxed(box_)));
  follow();
  EXPECT_EQ(viewer().crop.counts->counts[0], inside_);
  EXPECT_EQ(picture(), before);
  const int version = viewer().version;
  apply(call(action::mark_removed, true));
  EXPECT_GT(viewer().version, version) << "the picture is drawn again";
  EXPECT_NE(picture(), before);
}

TEST_F(CropJobs, every_renderer_of_the_session_leaves_out_what_is_gone) {
  press("R");
  apply(call(action::change_crop, boxed(box_)));
  press("Shift+R");
  follow();
  const std::vector<std::uint8_t> rest =
      picture_of(keep_rest(cloud_, find_removal(cloud_, box_, {})));
  // A backend that is chosen again uploads the scene and leaves out the same.
  thread_.run([&](RenderContext& context) {
    change_renderer(context.session, Backend::cpu, [&](Backend wanted) {
      return upload_to(context, context.session.scene, wanted, {});
    });
    EXPECT_EQ(drawn_count(context.session), inside_);
    EXPECT_EQ(drawn_cloud(context.session)->size(), inside_);
    EXPECT_EQ(context.session.renderer->render(viewer().camera).stats.gaussians, inside_);
  });
  settle();
  EXPECT_EQ(picture(), rest);
}

TEST_F(CropJobs, nothing_is_lost_if_nothing_would_stay) {
  const std::vector<std::uint8_t> before = picture();
  apply(call(action::change_crop, boxed({glm::vec3(900), glm::vec3(901)})));
  press("Shift+R");  // before anything was counted
  follow();
  EXPECT_FALSE(viewer().editing.gone);
  EXPECT_TRUE(viewer().toasts.back().error);
  EXPECT_THAT(viewer().toasts.back().text, HasSubstr("300 of 300 Gaussians removed"));
  follow();
  EXPECT_EQ(viewer().scene->gaussians, 300u);
  EXPECT_EQ(picture(), before);
}

TEST_F(CropJobs, the_rest_is_saved_to_new_files_only) {
  apply(call(action::save_crop, std::filesystem::path("early.ply"), Action()));
  settle();
  EXPECT_THAT(viewer().toasts.back().text, HasSubstr("nothing is cropped"));
  EXPECT_FALSE(std::filesystem::exists(scenes_ / "early.ply"));

  press("R");
  apply(call(action::change_crop, boxed(box_)));
  follow();
  press("Shift+R");
  press("Ctrl+R");  // while the step waits
  settle();
  EXPECT_THAT(viewer().toasts.back().text, HasSubstr("nothing is cropped"));
  follow();
  // The saved file has no tints.
  apply(call(action::edit, EditStep{}));
  follow();
  EXPECT_TRUE(viewer().crop.tint);
  press("Ctrl+R");
  settle();
  const GaussianCloud rest = keep_rest(cloud_, find_removal(cloud_, box_, {}));
  const Scene saved = test::read_scene(scenes_ / "random_cropped_0001.ply");
  EXPECT_EQ(saved.cloud.positions, rest.positions);
  EXPECT_EQ(saved.cloud.sh, rest.sh);
  press("Ctrl+R");
  settle();
  EXPECT_TRUE(std::filesystem::exists(scenes_ / "random_cropped_0002.ply"));

  const auto original = std::filesystem::file_size(viewer().scene->path);
  apply(call(action::save_crop, viewer().scene->path, Action()));
  settle();
  EXPECT_THAT(viewer().toasts.back().text, HasSubstr("this file exists already"));
  EXPECT_EQ(std::filesystem::file_size(viewer().scene->path), original);
  apply(call(action::save_crop, std::filesystem::path("rest.spz"), Action()));
  settle();
  EXPECT_EQ(test::read_scene(scenes_ / "rest.spz").cloud.size(), inside_);
  apply(call(action::save_crop, std::filesystem::path("rest.unknown"), Action()));
  settle();
  EXPECT_TRUE(viewer().toasts.back().error);
  EXPECT_FALSE(viewer().loading);
}

}  // namespace
}  // namespace qs
