// SPDX-License-Identifier: MIT
//
// Opening: every step, every result, and the files that it reads.
#include "app/viewer/render/scene_opening.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <fstream>
#include <future>
#include <thread>

#include <glm/geometric.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/measure/camera_path.h"
#include "app/viewer/render/panel_pictures.h"
#include "app/viewer/render/scene_reading.h"
#include "app/viewer/render/upload_scene.h"
#include "app/viewer/state/camera_actions.h"
#include "io/camera/cameras.h"
#include "io/picture/image_file.h"
#include "support/corpus.h"
#include "support/pool.h"
#include "support/recording_host.h"
#include "support/scene_files.h"
#include "support/scenes.h"
#include "support/temporary_folder.h"

namespace qs {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;
using Step = SceneOpening::Step;

// ---- steps --------------------------------------------------------------------------------------
// The main thread and the render thread, one after the other. Jobs run when a test says so.
class SceneOpeningTest : public testing::Test, protected test::RecordingHost {
 protected:
  SceneOpeningTest() {
    context_.session.pool = std::make_unique<ThreadPool>(1);
    context_.present = [this](const RenderedFrame&) { ++presented_; };
    apply(call(action::resize, 64, 48));
  }

  std::filesystem::path scene(const std::string& name, std::size_t gaussians) {
    test::write_scene(test::random_cloud(gaussians, 0, 1), folder_ / name);
    return folder_ / name;
  }
  const Viewer& viewer() const { return store_.viewer(); }
  void apply(const Action& action) { store_.apply(action, *this); }

  void open_scene(const std::filesystem::path& path, bool beside = false) {
    OpenRequest request;
    request.path = path;
    request.beside = beside;
    opening_.open(request);
  }
  // The main thread's part, until nothing is being read.
  void read() {
    while (opening_.busy()) {
      Actions actions;
      opening_.take_reports(actions);
      for (const Action& action : actions) apply(action);
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  }
  // The reports of half a second: usually all.
  Actions read_without_applying() {
    Actions actions;
    const auto end = std::chrono::steady_clock::now() + std::chrono::milliseconds(500);
    while (std::chrono::steady_clock::now() < end) {
      opening_.take_reports(actions);
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return actions;
  }
  // The render thread's part.
  void run_jobs() {
    for (const Job& job : std::exchange(jobs, {})) job(context_);
  }
  void take_uploads() {
    Actions actions;
    uploads_.take(actions);
    for (const Action& action : actions) apply(action);
  }
  void open_wholly(const std::filesystem::path& path) {
    open_scene(path);
    read();
    run_jobs();
    take_uploads();
  }
  std::string said() const { return viewer().log.empty() ? "" : viewer().log.back().text; }

  TemporaryFolder folder_;
  ViewerStore store_{Viewer()};
  ActionQueue uploads_{[] {}};
  RenderContext context_{uploads_, {}};
  int presented_ = 0;
  SceneOpening opening_{[] {}, 1};
};

TEST_F(SceneOpeningTest, reads_then_uploads_then_tells_the_scene) {
  const auto path = scene("a.ply", 30);
  EXPECT_EQ(opening_.step(), Step::idle);
  open_scene(path);
  EXPECT_EQ(opening_.step(), Step::reading);
  EXPECT_TRUE(opening_.busy());
  read();
  EXPECT_EQ(opening_.step(), Step::uploading);
  EXPECT_EQ(viewer().loading->what, "uploading");
  EXPECT_FALSE(viewer().scene);
  ASSERT_THAT(jobs, SizeIs(1));
  run_jobs();
  EXPECT_FALSE(viewer().scene) << "until the main thread takes the result";
  take_uploads();
  EXPECT_EQ(opening_.step(), Step::idle);
  EXPECT_FALSE(viewer().loading);
  EXPECT_EQ(viewer().scene->path, path);
  EXPECT_EQ(viewer().scene->gaussians, 30u);
  EXPECT_EQ(context_.session.scene->cloud.size(), 30u);
}

TEST_F(SceneOpeningTest, a_fit_of_colours_is_a_message) {
  open_wholly(test::committed_corpus() / "valid/compact_small.npz");
  EXPECT_EQ(viewer().scene->gaussians, 150u);
  const auto& log = viewer().log;
  EXPECT_TRUE(std::any_of(log.begin(), log.end(), [](const LogEntry& entry) {
    return entry.text.starts_with("The network's colours became spherical harmonics of degree 3");
  }));
}

TEST_F(SceneOpeningTest, a_file_that_cannot_be_read_ends_with_a_sentence_and_the_old_scene) {
  open_wholly(scene("a.ply", 30));
  std::ofstream(folder_ / "broken.ply") << "no";
  open_scene(folder_ / "broken.ply");
  read();
  EXPECT_EQ(opening_.step(), Step::idle);
  EXPECT_FALSE(viewer().loading);
  EXPECT_THAT(jobs, IsEmpty());
  EXPECT_THAT(said(), HasSubstr("broken.ply"));
  EXPECT_TRUE(viewer().log.back().error);
  EXPECT_EQ(viewer().scene->name, "a");
}

TEST_F(SceneOpeningTest, an_upload_that_fails_ends_with_a_sentence_and_the_old_scene) {
  if (std::ranges::count(available_backends(), Backend::cuda) > 0) GTEST_SKIP() << "a GPU is here";
  open_wholly(scene("a.ply", 30));
  apply([](Viewer& viewer, Host&) { viewer.backend = Backend::cuda; });
  open_wholly(scene("b.ply", 20));
  EXPECT_EQ(opening_.step(), Step::idle);
  EXPECT_FALSE(viewer().loading);
  EXPECT_TRUE(viewer().log.back().error);
  EXPECT_EQ(viewer().scene->name, "a");
  EXPECT_EQ(context_.session.scene->cloud.size(), 30u);
}

TEST_F(SceneOpeningTest, cancelled_while_it_is_read_nothing_is_opened) {
  open_scene(scene("a.ply", 30));
  opening_.cancel();
  EXPECT_EQ(opening_.step(), Step::idle);
  read();
  EXPECT_THAT(jobs, IsEmpty());
  EXPECT_FALSE(viewer().loading);
  EXPECT_EQ(said(), "a.ply: cancelled");
  EXPECT_FALSE(viewer().log.back().error);
}

TEST_F(SceneOpeningTest, cancelled_between_reading_and_its_report_nothing_is_opened) {
  open_scene(scene("a.ply", 30));
  const Actions late = read_without_applying();
  opening_.cancel();
  for (const Action& action : late) apply(action);
  read();
  EXPECT_THAT(jobs, IsEmpty());
  EXPECT_FALSE(viewer().loading);
  EXPECT_EQ(said(), "a.ply: cancelled");
}

TEST_F(SceneOpeningTest, cancelled_before_the_upload_begins_the_old_scene_stays) {
  open_wholly(scene("a.ply", 30));
  open_scene(scene("b.ply", 20));
  read();
  const std::string before = said();
  apply([this](Viewer& viewer, Host& host) {
    opening_.cancel();
    action::cancel_loading(viewer, host);
  });
  run_jobs();
  take_uploads();
  EXPECT_EQ(opening_.step(), Step::idle);
  EXPECT_FALSE(viewer().loading);
  EXPECT_EQ(viewer().scene->name, "a");
  EXPECT_EQ(context_.session.scene->cloud.size(), 30u);
  EXPECT_EQ(said(), before);
  open_wholly(folder_ / "b.ply");
  EXPECT_EQ(viewer().scene->name, "b") << "only what was under way is cancelled";
}

TEST_F(SceneOpeningTest, cancelled_during_the_upload_the_old_scene_stays) {
  open_wholly(scene("a.ply", 30));
  open_scene(scene("b.ply", 20));
  read();
  std::stop_source stop;
  stop.request_stop();
  context_.stop = stop.get_token();
  run_jobs();
  take_uploads();
  EXPECT_EQ(opening_.step(), Step::idle);
  EXPECT_FALSE(viewer().loading);
  EXPECT_EQ(viewer().scene->name, "a");
  EXPECT_EQ(context_.session.scene->cloud.size(), 30u);
}

TEST_F(SceneOpeningTest, cancelled_after_the_upload_the_shown_scene_is_told) {
  open_scene(scene("a.ply", 30));
  read();
  run_jobs();
  opening_.cancel();
  take_uploads();
  EXPECT_EQ(opening_.step(), Step::idle);
  EXPECT_EQ(viewer().scene->name, "a") << "the render thread draws it";
}

TEST_F(SceneOpeningTest, opened_again_while_reading_only_the_newer_file_is_opened) {
  open_scene(scene("a.ply", 30));
  open_scene(scene("b.ply", 20));
  EXPECT_EQ(opening_.step(), Step::reading);
  read();
  EXPECT_EQ(said(), "a.ply: cancelled");
  ASSERT_THAT(jobs, SizeIs(1));
  EXPECT_EQ(viewer().loading->path, folder_ / "b.ply");
  run_jobs();
  take_uploads();
  EXPECT_EQ(viewer().scene->name, "b");
}

TEST_F(SceneOpeningTest, opened_again_while_uploading_both_are_shown_and_progress_is_the_newer_s) {
  open_scene(scene("a.ply", 30));
  read();
  ASSERT_EQ(opening_.step(), Step::uploading);
  open_scene(scene("b.ply", 20));
  const Actions newer = read_without_applying();
  for (const Action& action : newer) {
    apply(action);
    if (opening_.step() == Step::reading) run_jobs();  // of the older one
    take_uploads();
    ASSERT_TRUE(viewer().loading);
    EXPECT_EQ(viewer().loading->path, folder_ / "b.ply");
  }
  EXPECT_EQ(viewer().scene->name, "a");
  read();
  EXPECT_EQ(opening_.step(), Step::uploading);
  run_jobs();
  take_uploads();
  EXPECT_EQ(viewer().scene->name, "b");
  EXPECT_FALSE(viewer().loading);
}

TEST_F(SceneOpeningTest, a_scene_beside_another_leaves_it) {
  open_wholly(scene("a.ply", 30));
  open_scene(scene("b.ply", 20), true);
  read();
  EXPECT_EQ(opening_.step(), Step::uploading);
  EXPECT_EQ(viewer().loading->what, "uploading");
  run_jobs();
  take_uploads();
  EXPECT_EQ(opening_.step(), Step::idle);
  EXPECT_FALSE(viewer().loading);
  EXPECT_EQ(viewer().scene->name, "a");
  EXPECT_EQ(viewer().beside->gaussians, 20u);
  EXPECT_TRUE(viewer().panels.split);
  EXPECT_EQ(context_.beside->scene->cloud.size(), 20u);
}

TEST_F(SceneOpeningTest, all_leaves_of_a_tree_are_beside_its_levels) {
  OpenRequest levels;
  levels.path = test::committed_corpus() / "valid/lod_own.rad";
  levels.streams = StreamedTrees::all;
  opening_.open(levels);
  for (const bool beside : {false, true}) {
    if (beside) open_scene(levels.path, true);
    read();
    run_jobs();
    take_uploads();
  }
  EXPECT_TRUE(context_.session.scene->stream);
  EXPECT_FALSE(context_.beside->scene->stream);
  EXPECT_EQ(context_.beside->scene->cloud.size(), 24u);
}

TEST_F(SceneOpeningTest, cameras_and_paths_need_no_upload) {
  std::ofstream(folder_ / "path.json")
      << format_camera_path({{1, test::front_camera(8, 6)}, {3, test::front_camera(8, 6)}});
  open_scene(folder_ / "path.json");
  read();
  EXPECT_EQ(opening_.step(), Step::idle);
  EXPECT_FALSE(viewer().loading);
  EXPECT_THAT(jobs, IsEmpty());
  EXPECT_THAT(viewer().keyframes, SizeIs(2));
}

// A reader that decompresses one large block notices for seconds neither that another scene is
// wanted nor that none is. This one hangs in its first report.
TEST_F(SceneOpeningTest, a_reader_that_hangs_delays_neither_another_scene_nor_cancelling) {
  const auto main_thread = std::this_thread::get_id();
  std::atomic<int> readers = 0;
  std::promise<void> release;
  const std::shared_future<void> released = release.get_future().share();
  std::future<void> window;
  {
    std::atomic<std::thread::id> window_thread = main_thread;
    SceneOpening opening(
        [&] {
          const auto id = std::this_thread::get_id();
          if (id != main_thread && id != window_thread && readers++ == 0) released.wait();
        },
        1);
    OpenRequest first, second, third;
    first.path = scene("a.ply", 30);
    second.path = scene("b.ply", 20);
    third.path = scene("c.ply", 10);
    opening.open(first);
    while (readers == 0) std::this_thread::yield();
    window = std::async(std::launch::async, [&] {
      window_thread = std::this_thread::get_id();
      opening.open(second);
      opening.cancel();
      opening.open(third);
    });
    const bool was_free = window.wait_for(std::chrono::seconds(20)) == std::future_status::ready;
    EXPECT_TRUE(was_free) << "the window's thread waits for the reader";
    if (!was_free) release.set_value();
    window.wait();
    while (opening.busy()) {
      Actions actions;
      opening.take_reports(actions);
      for (const Action& action : actions) apply(action);
    }
    run_jobs();
    take_uploads();
    EXPECT_EQ(viewer().scene->name, "c");
    if (was_free) release.set_value();  // the end of the program waits for it
  }
  EXPECT_EQ(viewer().scene->gaussians, 10u);
}

TEST_F(SceneOpeningTest, a_sample_is_a_step_of_reading_and_changes_no_state) {
  Sampling all;
  all.fewest = 0;
  SceneOpening opening([] {}, 1, all);
  OpenRequest request;
  request.path = scene("a.ply", 1000);
  opening.open(request);
  bool sampled = false;
  while (opening.busy()) {
    Actions actions;
    opening.take_reports(actions);
    for (const Action& action : actions) {
      apply(action);
      if (jobs.empty() || opening.step() != Step::reading) continue;
      const int version = viewer().version;
      run_jobs();
      sampled = true;
      EXPECT_EQ(viewer().version, version);
      EXPECT_FALSE(viewer().scene);
      EXPECT_EQ(viewer().loading->what, "reading");
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  EXPECT_TRUE(sampled);
  EXPECT_EQ(presented_, 1);
  EXPECT_EQ(context_.session.scene, nullptr);
}

// ---- reading files ------------------------------------------------------------------------------
class Loader : public testing::Test, protected test::RecordingHost {
 protected:
  // Reports of reading until the loader is done.
  Viewer load(const std::filesystem::path& path, const std::string& axes = "",
              const Sampling& sampling = {}) {
    // Its uploads report to it, so it lives as long as the test.
    openings_.push_back(std::make_unique<SceneOpening>([] {}, 1, sampling));
    OpenRequest request;
    request.path = path;
    request.axes = axes;
    openings_.back()->open(request);
    return finish(*openings_.back());
  }

  template <class Reader>
  Viewer finish(Reader& loader) {
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
  std::vector<std::unique_ptr<SceneOpening>> openings_;
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

TEST_F(Loader, the_times_of_a_data_set_do_not_make_it_a_path) {
  start_.scene.emplace();
  start_.camera = test::front_camera(64, 48);
  write("transforms.json",
        R"({"camera_angle_x": 0.7, "w": 8, "h": 6, "frames": [{"file_path": "./train/r_000",
        "rotation": 0.1, "time": 0.0, "transform_matrix": [[1,0,0,0],[0,1,0,0],[0,0,1,2],[0,0,0,1]]},
        {"file_path": "./train/r_001", "rotation": 0.1, "time": 0.0, "transform_matrix":
        [[1,0,0,1],[0,1,0,0],[0,0,1,2],[0,0,0,1]]}]})");
  const Viewer viewer = load(folder_ / "transforms.json");
  EXPECT_THAT(viewer.keyframes, testing::IsEmpty());
  ASSERT_TRUE(viewer.scene);
  EXPECT_THAT(viewer.scene->cameras, SizeIs(2));
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
  write("meta.json", "{}");  // the name of a scene
  EXPECT_THAT(load(folder_ / "meta.json").toasts.at(0).text, testing::Not(HasSubstr("camera")));
  write("empty.json", "[]");
  EXPECT_THAT(load(folder_ / "empty.json").toasts.at(0).text, HasSubstr("holds no camera"));
}

TEST_F(Loader, photographs_are_read_beside_scenes) {
  picture("a.png");
  start_.photograph.path = folder_ / "a.png";
  PhotographReader loader([] {});
  loader.read(read_camera_photograph(folder_ / "a.png"));
  const Viewer viewer = finish(loader);
  ASSERT_NE(viewer.photograph.image, nullptr);
  EXPECT_EQ(viewer.photograph.image->width, 5);
  EXPECT_EQ(viewer.photograph.image->height, 3);
  PhotographReader other([] {});
  other.read(read_camera_photograph(folder_ / "b.png"));
  EXPECT_TRUE(finish(other).toasts.at(0).error);
  EXPECT_FALSE(other.busy());
}

}  // namespace
}  // namespace qs
