// SPDX-License-Identifier: MIT
//
// Background jobs of the viewer in a window that is wider than high: their results, the part of the
// view that they cover, and the files that the loader reads.
#include <fstream>

#include <glm/geometric.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/framing/camera_control.h"
#include "app/inspect/inspection_text.h"
#include "app/inspect/reference_check.h"
#include "app/measure/camera_path.h"
#include "app/support/rendering_viewer.h"
#include "app/viewer/commands/jobs.h"
#include "app/viewer/render/host_frames.h"
#include "app/viewer/render/scene_loader.h"
#include "app/viewer/state/panel_text.h"
#include "app/viewer/window/presenter.h"
#include "io/camera/cameras.h"
#include "io/picture/image_file.h"
#include "support/pool.h"

namespace qs {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::SizeIs;

class ViewerJobs : public test::RenderingViewer {
 protected:
  // Frames of the same scene without the viewer.
  const Frame& headless(const RenderSettings& settings, const Outputs& outputs) {
    if (!renderer_) {
      renderer_ = make_renderer(Backend::cpu, test::pool(1));
      renderer_->upload(test::random_cloud(300, 1, 5), {});
    }
    return renderer_->render(viewer().camera, settings, outputs);
  }

 private:
  std::unique_ptr<Renderer> renderer_;
};

void expect_picture(const std::vector<std::uint8_t>& rgba, const Image& image) {
  ASSERT_EQ(rgba.size(), image.values.size() / 3 * 4);
  for (std::size_t i = 0; i < rgba.size(); ++i)
    ASSERT_EQ(rgba[i], i % 4 == 3 ? 255 : to_8bit(image.values[i / 4 * 3 + i % 4])) << i;
}

TEST_F(ViewerJobs, frames_are_the_renderer_s_pictures) {
  const auto frame = draw(request_);
  ASSERT_TRUE(frame);
  const Frame& expected = headless(request_.settings, {});
  EXPECT_EQ(frame->width, 96);
  EXPECT_EQ(frame->height, 64);
  expect_picture(frame->rgba, expected.color);
  EXPECT_TRUE(frame->other.empty());
  EXPECT_EQ(frame->shown.version, request_.version);
  EXPECT_EQ(frame->shown.mode, request_.settings.mode);
  EXPECT_EQ(frame->shown.stats.tile_pairs, expected.stats.tile_pairs);
  EXPECT_FALSE(frame->shown.interop);
}

TEST_F(ViewerJobs, smaller_frames_round_both_sides_down_to_at_least_one) {
  request_.divisor = 7;
  const auto frame = draw(request_);
  EXPECT_EQ(frame->width, 13);
  EXPECT_EQ(frame->height, 9);
  EXPECT_EQ(frame->rgba.size(), 4u * 13 * 9);
  request_.divisor = 80;
  EXPECT_EQ(draw(request_)->height, 1);
  EXPECT_EQ(draw(request_)->width, 1);
}

// Without ffmpeg, so that films are folders of pictures.
class FilmJob : public ViewerJobs {
 protected:
  FilmJob() : path_variable_(std::getenv("PATH")) { setenv("PATH", "", 1); }
  ~FilmJob() override { setenv("PATH", path_variable_.c_str(), 1); }
  std::vector<std::filesystem::path> films() const {
    std::vector<std::filesystem::path> found;
    for (const auto& entry : std::filesystem::directory_iterator(scenes_ / "film"))
      found.push_back(entry.path());
    return found;
  }

 private:
  std::string path_variable_;
};

TEST_F(FilmJob, films_the_path_of_the_window) {
  const Camera first = viewer().camera;
  press("K");
  apply(call(action::orbit, glm::dvec2(40, 0)));
  press("K");
  apply(call(action::resize, 97, 65));
  press("Ctrl+K");
  settle();
  EXPECT_THAT(viewer().toasts.back().text,
              HasSubstr(": PNG files, because ffmpeg is not installed"));
  EXPECT_FALSE(viewer().loading);
  ASSERT_THAT(films(), SizeIs(1));
  const auto picture = [&](int number) {
    return read_image(films()[0] / fmt::format("frame_{:05}.png", number));
  };
  EXPECT_FALSE(std::filesystem::exists(films()[0] / "frame_00030.png"));
  const std::pair<int, Camera> ends[] = {{0, first}, {29, viewer().keyframes[1].camera}};
  for (const auto& [number, camera] : ends) {
    request_.camera = camera.resized(96, 64);
    const auto frame = draw(request_);
    const Image seen = picture(number);
    ASSERT_EQ(seen.width, 96);
    for (std::size_t i = 0; i < seen.values.size(); ++i)
      ASSERT_EQ(to_8bit(seen.values[i]), frame->rgba[i / 3 * 4 + i % 3]) << number;
  }
}

TEST_F(FilmJob, films_both_sides_of_a_split_window) {
  press("K");
  apply(call(action::orbit, glm::dvec2(40, 0)));
  press("K");
  apply(call(action::delay_keyframe, std::size_t{1}, 0.1));
  apply(call(action::resize, 600, 300));
  press("C");
  settle();
  press("Ctrl+K");
  settle();
  ASSERT_THAT(films(), SizeIs(1));
  const Image seen = read_image(films()[0] / "frame_00000.png");
  EXPECT_EQ(seen.width, 600);
  EXPECT_GT(seen.at(300, 20, 0), 0.8f);  // the line between the strips
}

TEST_F(FilmJob, films_two_scenes_beside_each_other) {
  auto scene = std::make_shared<Scene>();
  scene->cloud = test::random_cloud(120, 1, 9);
  scene->path = scenes_ / "other.ply";
  apply(call(action::beside_read, std::shared_ptr<const Scene>(scene)));
  settle();
  ASSERT_TRUE(viewer().beside);
  press("K");
  press("K");
  apply(call(action::delay_keyframe, std::size_t{1}, 0.1));
  press("Ctrl+K");
  settle();
  ASSERT_THAT(films(), SizeIs(1)) << viewer().toasts.back().text;
  const Image seen = read_image(films()[0] / "frame_00000.png");
  const auto renderer = make_renderer(Backend::cpu, test::pool(1));
  renderer->upload(scene->cloud, {});
  const Image other = renderer->render(viewer().camera, request_.settings).color;
  const auto frame = draw(request_);
  // Above the labels; the line between the strips is at x = 48.
  for (int y = 0; y < 20; ++y) {
    for (int x = 0; x < 96; ++x) {
      if (std::abs(x - 48) <= 1) continue;
      const auto expected = x < 48 ? frame->rgba[static_cast<std::size_t>(4 * (y * 96 + x))]
                                   : to_8bit(other.at(x, y, 0));
      ASSERT_EQ(to_8bit(seen.at(x, y, 0)), expected) << x << " " << y;
    }
  }
}

TEST_F(FilmJob, a_film_can_be_stopped_and_leaves_nothing) {
  press("K");
  press("K");
  apply(call(action::delay_keyframe, std::size_t{1}, 3600.0));
  press("Ctrl+K");
  while (!viewer().loading && thread_.busy()) {
    take_reports();
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  ASSERT_TRUE(viewer().loading);
  EXPECT_EQ(viewer().loading->what, "filming");
  stop_job();
  settle();
  EXPECT_THAT(viewer().toasts.back().text, HasSubstr("the film was stopped, nothing was saved"));
  EXPECT_FALSE(viewer().loading);
  EXPECT_THAT(films(), testing::IsEmpty());
}

TEST_F(ViewerJobs, a_heat_map_is_scaled_to_its_values) {
  request_.heatmap = HeatQuantity::pairs;
  const auto frame = draw(request_);
  ASSERT_TRUE(frame && frame->shown.heatmap);
  const Heatmap& map = *frame->shown.heatmap;
  EXPECT_EQ(map.columns, 6);
  EXPECT_EQ(map.rows, 4);
  EXPECT_EQ(frame->shown.map_scale.maximum, scale_for(map.values).maximum);
  const auto layer = layer_of(frame->shown);
  ASSERT_TRUE(layer);
  EXPECT_EQ(layer->columns, 6);
  EXPECT_EQ(layer->rows, 4);
  EXPECT_EQ(layer->cell_px, 16);
  EXPECT_EQ(layer->low, 0);
  EXPECT_EQ(layer->high, static_cast<float>(frame->shown.map_scale.maximum));
  for (std::size_t i = 0; i < map.values.size(); ++i)
    EXPECT_EQ(layer->values[i], static_cast<float>(map.values[i]));
  EXPECT_FALSE(layer_of(ShownFrame()));
}

TEST_F(ViewerJobs, a_split_frame_s_layer_goes_from_fewer_to_more_pairs) {
  request_.other = Variant{find_culler("3dgs"), Pipeline::classic, Backend::cpu};
  const auto frame = draw(request_);
  ASSERT_TRUE(frame && frame->shown.other && frame->shown.other->pairs);
  const auto layer = layer_of(frame->shown);
  ASSERT_TRUE(layer);
  EXPECT_EQ(layer->columns, 6);
  EXPECT_EQ(layer->rows, 4);
  EXPECT_EQ(layer->low, -layer->high);
  EXPECT_EQ(layer->high, static_cast<float>(frame->shown.map_scale.maximum));
  float largest = 0, sum = 0;
  for (const float value : layer->values) {
    largest = std::max(largest, std::abs(value));
    sum += value;
  }
  EXPECT_GE(layer->high, largest);
  EXPECT_EQ(static_cast<std::int64_t>(sum), frame->shown.other->pairs->total);
  EXPECT_EQ(frame->shown.other->region.x1, 96);
  EXPECT_EQ(frame->shown.other->region.y1, 64);
  RenderSettings settings = request_.settings;
  settings.mode = find_culler("3dgs");
  settings.pipeline = Pipeline::classic;
  expect_picture(frame->other, headless(settings, {}).color);
}

TEST_F(ViewerJobs, the_inspector_works_up_to_the_right_and_the_lower_border) {
  press("B");
  for (const glm::ivec2 pixel : {glm::ivec2(95, 10), {40, 63}, {0, 0}}) {
    SCOPED_TRACE(testing::Message() << pixel.x << " " << pixel.y);
    apply(call(action::inspect_pixel, glm::dvec2(pixel) + 0.7));
    settle();
    ASSERT_TRUE(viewer().inspected);
    EXPECT_EQ(viewer().inspected->version, viewer().version);
    const Frame& frame = headless(viewer().settings, inspection_outputs());
    const Inspection expected = inspect(frame, {96, 64}, pixel, viewer().settings.background, {});
    const Inspection& actual = viewer().inspected->inspection;
    EXPECT_EQ(actual.pixel.pixel, pixel);
    EXPECT_EQ(inspection_json(actual), inspection_json(expected));
    EXPECT_EQ(viewer().inspected->grid.columns, frame.grid.columns);
    EXPECT_EQ(viewer().inspected->grid.tile_px, frame.grid.tile_px);
  }
}

TEST_F(ViewerJobs, the_comparison_around_the_cursor_covers_256_pixels) {
  apply(call(action::resize, 600, 400));
  const auto region = [&](double x, double y) {
    change([=](Viewer& viewer) {
      viewer.cursor = {x, y};
      viewer.panels.split = true;
      viewer.split.other = {kReferenceMode, Pipeline::fast, Backend::cpu};
    });
    press("Shift+0");
    const auto frame = settle();
    EXPECT_TRUE(viewer().comparison && frame && frame->shown.other);
    const PixelBox box = viewer().comparison->verdict.region;
    if (frame && frame->shown.other) {
      EXPECT_EQ(frame->shown.other->region.x0, box.x0);
      EXPECT_EQ(frame->shown.other->region.y1, box.y1);
      EXPECT_LE(frame->shown.other->pixels.largest, 2);
    }
    return std::array{box.x0, box.y0, box.x1, box.y1};
  };
  EXPECT_THAT(region(300.5, 200.5), ElementsAre(172, 72, 428, 328));
  EXPECT_THAT(region(900, 900), ElementsAre(471, 271, 600, 400));
  EXPECT_EQ(viewer().comparison->view_version, viewer().view_version);
  EXPECT_TRUE(verdict_is_current(viewer()));
  EXPECT_THAT(viewer().comparison->sentence,
              testing::StartsWith("quadbox: equal to the reference within 2/255"));
}

TEST_F(ViewerJobs, progress_is_reported_in_steps_of_one_per_cent) {
  ActionQueue queue([] {});
  ViewerStore store{Viewer()};
  std::vector<float> shown;
  const Progress progress = shown_progress("/a.ply", "reading", {}, queue);
  for (const float fraction : {0.0f, 0.005f, 0.0125f, 0.015f, 0.02f, 0.5f, 0.505f, 1.0f}) {
    progress.update(fraction);
    Actions actions;
    queue.take(actions);
    for (const Action& action : actions) {
      store.apply(action, *this);
      shown.push_back(store.viewer().loading->fraction);
    }
  }
  EXPECT_THAT(shown, ElementsAre(0.0125f, 0.5f, 1.0f));
  EXPECT_EQ(store.viewer().loading->path, "/a.ply");
  EXPECT_EQ(store.viewer().loading->what, "reading");
}

TEST_F(ViewerJobs, requests_follow_the_state_of_the_view) {
  FrameRequests requests;
  EXPECT_FALSE(requests.are_up_to_date(viewer()));
  requests.update(viewer(), thread_, false);
  EXPECT_TRUE(requests.are_up_to_date(viewer()));
  auto frame = settle();
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->shown.version, viewer().version);
  requests.update(viewer(), thread_, false);
  EXPECT_FALSE(settle());  // nothing changed
  // While the camera moves a slow backend draws fewer pixels, and the whole picture afterwards.
  frame->shown.stats.frame_ms = frame->shown.stats.stage_ms[static_cast<int>(Stage::blend)] = 250;
  requests.learn(*frame);
  apply(call(action::orbit, glm::dvec2(1, 1)));
  requests.update(viewer(), thread_, false);
  frame = settle();
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->shown.divisor, 3);
  apply(call(action::tick, Turn{viewer().now + 0.3}, 0.0));
  requests.update(viewer(), thread_, false);
  EXPECT_FALSE(settle());  // the window does not show that frame yet
  for (const int divisor : {2, 1}) {
    apply(call(action::frame_shown, frame->shown));
    requests.update(viewer(), thread_, false);
    frame = settle();
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->shown.divisor, divisor);
    requests.update(viewer(), thread_, false);
    EXPECT_FALSE(settle());
  }
  apply(call(action::frame_shown, frame->shown));
  // Once the view is still and the window rests, the numbers of all modes, if the table is open.
  requests.update(viewer(), thread_, true);
  EXPECT_FALSE(settle());
  EXPECT_EQ(viewer().numbers.version, -1);
  press("F10");
  requests.update(viewer(), thread_, false);
  EXPECT_FALSE(settle());
  EXPECT_EQ(viewer().numbers.version, -1);
  requests.update(viewer(), thread_, true);
  settle();
  EXPECT_EQ(viewer().numbers.version, viewer().view_version);
  change([](Viewer& viewer) { viewer.reduce_when_moving = false; });
  apply(call(action::orbit, glm::dvec2(1, 1)));
  requests.update(viewer(), thread_, false);
  EXPECT_EQ(settle()->shown.divisor, 1);
  change([](Viewer& viewer) {
    viewer.zoom.running = true;
    ++viewer.version;
  });
  requests.update(viewer(), thread_, false);
  EXPECT_FALSE(settle());
}

TEST_F(ViewerJobs, a_zoom_has_twelve_steps_towards_the_middle) {
  press("Z");
  settle();
  EXPECT_FALSE(viewer().zoom.running);
  EXPECT_EQ(viewer().zoom.steps, 12);
  EXPECT_THAT(viewer().zoom.rows, SizeIs(12 * kCullerCount));
  EXPECT_EQ(viewer().zoom.folder, scenes_ / "zoom/random scene_0001");
}

// ---- reading files ------------------------------------------------------------------------------
class Loader : public testing::Test, protected test::RecordingHost {
 protected:
  // Reports of reading until the loader is done.
  Viewer load(const std::filesystem::path& path, const std::string& axes = "",
              const Sampling& sampling = {}) {
    SceneLoader loader([] {}, 1, sampling);
    OpenRequest request;
    request.path = path;
    request.axes = axes;
    loader.open(request);
    return finish(loader);
  }

  Viewer finish(SceneLoader& loader) {
    ViewerStore store{start_};
    while (loader.busy()) {
      Actions actions;
      loader.take_reports(actions);
      for (const Action& action : actions) {
        store.apply(action, *this);
        if (store.viewer().loading) seen_.push_back(*store.viewer().loading);
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    Actions reports;
    reports_.take(reports);
    for (const Action& action : reports) store.apply(action, *this);
    return store.viewer();
  }

  void write(const std::string& name, const std::string& content) {
    std::filesystem::create_directories((folder_ / name).parent_path());
    std::ofstream(folder_ / name) << content;
  }
  static std::string cameras(const std::vector<const char*>& names) {
    std::string list;
    for (const char* name : names) {
      Camera camera = test::front_camera(64, 48);
      camera.name = name;
      list += (list.empty() ? "[" : ",") + format_camera(camera);
    }
    return list + "]";
  }
  void picture(const std::string& name) {
    std::filesystem::create_directories((folder_ / name).parent_path());
    write_image(Image(5, 3, 3), folder_ / name);
  }

  void run(Job job) override {
    if (!run_at_once_) return RecordingHost::run(std::move(job));
    RenderContext context{reports_, {}};
    context.session.pool = std::make_unique<ThreadPool>(1);
    job(context);
  }

  TemporaryFolder folder_;
  Viewer start_;
  std::vector<Loading> seen_;
  bool run_at_once_ = false;
  ActionQueue reports_{[] {}};  // of jobs
};

TEST_F(Loader, cameras_get_the_photographs_of_the_folder_images_here_or_one_up) {
  start_.scene.emplace();
  start_.camera = test::front_camera(64, 48);
  write("a/cameras.json", cameras({"0001", "left/0002", "x/0003"}));
  picture("a/images/0001.png");
  picture("a/images/left/0002.ppm");
  picture("a/images/0003.png");
  Viewer viewer = load(folder_ / "a/cameras.json");
  EXPECT_THAT(viewer.scene->photographs,
              ElementsAre(testing::Pair(0, folder_ / "a/images/0001.png"),
                          testing::Pair(1, folder_ / "a/images/left/0002.ppm"),
                          testing::Pair(2, folder_ / "a/images/0003.png")));
  EXPECT_EQ(viewer.scene->cameras_file, folder_ / "a/cameras.json");
  EXPECT_THAT(viewer.scene->cameras, SizeIs(3));
  EXPECT_FALSE(viewer.loading);
  ASSERT_FALSE(seen_.empty());
  EXPECT_EQ(seen_[0].what, "reading");
  EXPECT_EQ(seen_[0].fraction, 0);
  EXPECT_EQ(seen_[0].path, folder_ / "a/cameras.json");
  write("a/sparse/cameras.json", cameras({"0001"}));
  viewer = load(folder_ / "a/sparse/cameras.json");
  ASSERT_THAT(viewer.scene->photographs, SizeIs(1));
  EXPECT_EQ(std::filesystem::canonical(viewer.scene->photographs.at(0)),
            std::filesystem::canonical(folder_ / "a/images/0001.png"));
  viewer = load(folder_ / "a/sparse");  // a folder without a scene
  EXPECT_THAT(viewer.scene->cameras, SizeIs(1));
}

TEST_F(Loader, a_list_of_cameras_with_times_is_a_path) {
  write("path.json",
        format_camera_path({{1, test::front_camera(8, 6)}, {3, test::front_camera(8, 6)}}));
  const Viewer viewer = load(folder_ / "path.json");
  ASSERT_THAT(viewer.keyframes, SizeIs(2));
  EXPECT_EQ(viewer.keyframes[1].time, 3);
  EXPECT_FALSE(viewer.loading);
}

TEST_F(Loader, a_scene_comes_with_its_facts) {
  test::write_scene(test::random_cloud(30, 2, 2), folder_ / "scene.ply");
  write("cameras.json", cameras({"0001"}));
  const Viewer viewer = load(folder_ / "scene.ply", "RUB");
  EXPECT_THAT(jobs, SizeIs(1));
  EXPECT_TRUE(viewer.loading);
  EXPECT_EQ(viewer.loading->what, "uploading");
  EXPECT_EQ(viewer.loading->fraction, 0);
  ThreadPool pool(1);
  Scene scene = read_scene(folder_ / "scene.ply", pool, {});
  const ViewedScene facts = view_facts(scene, std::nullopt, pool);
  EXPECT_EQ(facts.name, "scene");
  EXPECT_EQ(facts.gaussians, 30u);
  EXPECT_EQ(facts.sh_degree, 2);
  EXPECT_EQ(facts.file_bytes, std::filesystem::file_size(folder_ / "scene.ply"));
  EXPECT_THAT(facts.cameras, SizeIs(1));
  EXPECT_FALSE(facts.white_background);
  // The cameras' mean up, unless their up directions differ too much or the file names an axis.
  const auto up = [&](const std::vector<glm::dvec3>& ups) {
    std::string list;
    for (const glm::dvec3& each : ups) {
      const Camera camera = look_at({0, 0, 0}, glm::dvec3(1, 0, 0), each, 1, 64, 48);
      list += (list.empty() ? "[" : ",") + format_camera(camera);
    }
    write("other.json", list + "]");
    return view_facts(scene, folder_ / "other.json", pool).up;
  };
  EXPECT_LT(glm::distance(up({{0, 0, 1}, {0, 1, 0}}), glm::normalize(glm::dvec3(0, 1, 1))), 1e-9);
  EXPECT_LT(glm::distance(up({{0, 0, 1}, {0, 0, -1}, {0, 0, 1}, {0, 0, -1}}), glm::dvec3(0, -1, 0)),
            1e-9);
  const double tilt = std::acos(0.11), more = std::acos(0.09);
  EXPECT_LT(
      glm::distance(up({{0, std::sin(tilt), std::cos(tilt)}, {0, -std::sin(tilt), std::cos(tilt)}}),
                    glm::dvec3(0, 0, 1)),
      1e-9);
  EXPECT_LT(
      glm::distance(up({{0, std::sin(more), std::cos(more)}, {0, -std::sin(more), std::cos(more)}}),
                    glm::dvec3(0, -1, 0)),
      1e-9);
  scene.vertical_axis = "x";
  EXPECT_EQ(up({{0, 0, 1}}), glm::dvec3(1, 0, 0));
}

TEST_F(Loader, a_large_scene_is_seen_before_it_is_there_and_is_the_same_afterwards) {
  Sampling sampling;
  sampling.fewest = 60'000;
  start_.camera = test::front_camera(320, 180);
  for (const char* name : {"large.spz", "large.ply"}) {
    const std::filesystem::path path = folder_ / name;
    test::write_scene(test::random_cloud(60'001, 1, 3), path);
    const Scene scene = test::read_scene(path);
    const ViewedScene facts = view_facts(scene, std::nullopt, test::pool(1));
    jobs.clear();
    EXPECT_FALSE(load(path, "", sampling).scene);
    ASSERT_THAT(jobs, SizeIs(2)) << "the picture of a sample, then the scene";

    ActionQueue reports([] {});
    std::vector<RenderedFrame> shown;
    RenderContext context{reports, {}, [&](RenderedFrame frame) { shown.push_back(frame); }};
    context.session.pool = std::make_unique<ThreadPool>(1);
    jobs[0](context);
    EXPECT_EQ(context.session.scene, nullptr);
    ASSERT_THAT(shown, SizeIs(1));
    const auto lit = [](std::uint8_t value) { return value > 40 && value < 255; };
    EXPECT_GT(std::count_if(shown[0].rgba.begin(), shown[0].rgba.end(), lit),
              static_cast<int>(shown[0].rgba.size() / 8));
    EXPECT_GT(shown[0].shown.divisor, 1) << "it is not a measurement";

    jobs[1](context);
    EXPECT_EQ(context.session.scene->cloud.positions, scene.cloud.positions);
    EXPECT_EQ(context.session.scene->cloud.sh, scene.cloud.sh);
    ViewerStore store{Viewer()};
    Actions actions;
    reports.take(actions);
    for (const Action& action : actions) store.apply(action, *this);
    const ViewedScene& shown_facts = *store.viewer().scene;
    EXPECT_EQ(shown_facts.up, facts.up);
    EXPECT_EQ(shown_facts.framing.eye, facts.framing.eye);
    EXPECT_EQ(shown_facts.framing.target, facts.framing.target);
    EXPECT_EQ(shown_facts.framing.near_depth, facts.framing.near_depth);
    EXPECT_EQ(shown_facts.gaussians, 60'001u);
  }
}

TEST_F(Loader, a_small_scene_and_one_beside_another_are_shown_once_they_are_there) {
  const std::filesystem::path path = folder_ / "scene.ply";
  test::write_scene(test::random_cloud(1000, 0, 3), path);
  load(path);
  EXPECT_THAT(jobs, SizeIs(1));
  jobs.clear();
  Sampling all;
  all.fewest = 0;
  start_.scene.emplace();
  load(path, "", all);
  EXPECT_THAT(jobs, SizeIs(1));
}

TEST_F(Loader, a_model_is_read_at_its_last_iteration) {
  for (const char* name : {"iteration_0", "iteration_30000"}) {
    const auto folder = folder_ / "model/point_cloud" / name;
    std::filesystem::create_directories(folder);
    test::write_scene(test::random_cloud(5, 0, 2), folder / "point_cloud.ply");
  }
  run_at_once_ = true;
  const Viewer viewer = load(folder_ / "model");
  EXPECT_EQ(viewer.scene->path, folder_ / "model/point_cloud/iteration_30000/point_cloud.ply");
  EXPECT_EQ(viewer.scene->name, "model");
}

TEST_F(Loader, what_cannot_be_read_becomes_a_sentence) {
  write("broken.json", "{");
  std::filesystem::resize_file(folder_ / "broken.json", (256u << 20) + 1);
  Viewer viewer = load(folder_ / "broken.json");
  ASSERT_THAT(viewer.toasts, SizeIs(1));
  EXPECT_TRUE(viewer.toasts[0].error);
  EXPECT_EQ(viewer.toasts[0].text,
            (folder_ / "broken.json").string() +
                ": 268435457 bytes are more than the 268435456 that are read");
  EXPECT_FALSE(viewer.loading);
  viewer = load(folder_ / "missing.ply");
  EXPECT_THAT(viewer.toasts.at(0).text, HasSubstr("does not exist"));
  write("meta.json", "[]");  // the name of a scene
  EXPECT_THAT(load(folder_ / "meta.json").toasts.at(0).text, testing::Not(HasSubstr("camera")));
}

TEST_F(Loader, photographs_are_read_beside_scenes) {
  picture("a.png");
  start_.photograph.path = folder_ / "a.png";
  SceneLoader loader([] {}, 1);
  loader.read_photograph(folder_ / "a.png");
  const Viewer viewer = finish(loader);
  ASSERT_NE(viewer.photograph.image, nullptr);
  EXPECT_EQ(viewer.photograph.image->width, 5);
  EXPECT_EQ(viewer.photograph.image->height, 3);
  SceneLoader other([] {}, 1);
  other.read_photograph(folder_ / "b.png");
  EXPECT_TRUE(finish(other).toasts.at(0).error);
  EXPECT_FALSE(other.busy());
}

}  // namespace
}  // namespace qs
