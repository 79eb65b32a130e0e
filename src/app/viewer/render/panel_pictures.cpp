// SPDX-License-Identifier: MIT
#include "app/viewer/render/panel_pictures.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <utility>

#include "app/viewer/render/render_context.h"
#include "app/viewer/state/actions.h"
#include "app/viewer/state/camera_actions.h"
#include "app/viewer/state/layout.h"
#include "base/seconds.h"
#include "io/camera/photographs.h"
#include "raster/scene/image_metrics.h"

namespace qs {
namespace {

// True if the panel may ask for pictures.
bool panel_asks(const Viewer& viewer) {
  return viewer.training && viewer.training->views && viewer.panels.all && viewer.panels.training &&
         viewer.training->test_view.problem.empty();
}

// True if the panel has no picture of this view and model, and the window has the model.
bool lacks_comparison(const Viewer& viewer) {
  const Training& training = *viewer.training;
  const TestComparison& comparison = training.test_view.comparison;
  if (!window_shows_model(viewer) || shows_part_of_model(viewer)) return false;
  return !comparison.picture || comparison.iteration != training.shown;
}

bool comparison_is_due(const Viewer& viewer) {
  const TestView& shown = viewer.training->test_view;
  if (!shown.photograph || shown.compares || !viewer.still() || !lacks_comparison(viewer))
    return false;
  if (!shown.comparison.picture) return true;
  return may_draw(viewer) &&
         (!is_training(viewer) || viewer.now - shown.compared_at >= kTestViewSeconds);
}

// Pictures of these views side by side, each `width` > 0 pixels wide and 9/16 as high.
Image draw_candidates(RenderContext& context, const std::vector<Framing>& views,
                      const RenderSettings& settings, int width) {
  const int height = std::max(1, width * 9 / 16);
  Image strip(width * static_cast<int>(views.size()), height, 3);
  for (std::size_t i = 0; i < views.size(); ++i) {
    const Camera camera = framed_camera(views[i], width, height);
    const Frame& frame =
        context.session.renderer->render(camera, settings, {}, HostImage{}, context.stop);
    for (int y = 0; y < height; ++y) {
      const float* from = frame.color.row(y);
      std::copy(from, from + 3 * width, strip.row(y) + i * static_cast<std::size_t>(3 * width));
    }
  }
  return strip;
}

}  // namespace

PhotographReader::PhotographReader(std::function<void()> wake) : reports_(std::move(wake)) {
  thread_ = std::jthread([this](const std::stop_token& stop) { serve(stop); });
}

void PhotographReader::read(Work work) {
  const std::lock_guard lock(mutex_);
  wanted_ = std::move(work);
  reading_ = true;
  changed_.notify_all();
}

void PhotographReader::serve(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  while (changed_.wait(lock, stop, [this] { return wanted_ != nullptr; })) {
    const Work work = std::exchange(wanted_, nullptr);
    lock.unlock();
    work(reports_);
    lock.lock();
    reading_ = wanted_ != nullptr;
  }
}

PhotographReader::Work read_camera_photograph(const std::filesystem::path& path) {
  return [path](ActionQueue& reports) {
    try {
      ThreadPool pool(1);
      ShownPhotograph photograph{
          path, std::make_shared<Image>(read_photograph(path, glm::vec3(0), 1, pool))};
      reports.report(action::photograph_opened, std::move(photograph));
    } catch (const std::exception& error) {
      reports.report(action::notify_error, std::string(error.what()));
    }
  };
}

std::shared_ptr<const Image> shown_in_panel(const Image& picture, ThreadPool& pool) {
  const int longest = std::max(picture.width, picture.height);
  if (longest <= kTestPictureSide) return std::make_shared<Image>(picture);
  const auto side = [&](int pixels) {
    return std::max(
        1, static_cast<int>(std::lround(static_cast<double>(pixels) * kTestPictureSide / longest)));
  };
  return std::make_shared<Image>(
      area_average(picture, side(picture.width), side(picture.height), pool));
}

PhotographReader::Work read_test_photograph(const std::shared_ptr<const TestViews>& views,
                                            std::size_t view) {
  return [=](ActionQueue& reports) {
    try {
      const auto photograph = std::make_shared<const TestPhotograph>(views->read(view));
      ThreadPool pool(1);
      reports.report(action::test_photograph_read, views, view, photograph,
                     shown_in_panel(photograph->image, pool));
    } catch (const std::exception& error) {
      reports.report(action::test_view_failed, views, view, std::string(sentence_of(error)));
    }
  };
}

Job compare_test_view(const Training& training) {
  const std::size_t view = training.test_view.view;
  return [folder = training.folder, views = training.views, view,
          photograph = training.test_view.photograph](RenderContext& context) {
    bool compared = false;
    const AtEnd end{[&] {
      if (!compared) context.report(action::test_view_given_up);
    }};
    const Session& session = context.session;
    if (!session.scene || session.scene->path != folder || session.gone) return;
    const auto begin = std::chrono::steady_clock::now();
    try {
      const Frame& frame = session.renderer->render(views->cameras[view], views->settings, {},
                                                    HostImage{}, context.stop);
      Image picture = frame.color;
      clamp_to_unit(picture);
      TestComparison comparison{view, context.trained_iteration, {}, 0, 0};
      comparison.psnr = psnr(picture, photograph->image, *session.pool, photograph->mask);
      comparison.ssim =
          ssim(picture, photograph->image, *session.pool, SsimBorder::zeros, photograph->mask);
      comparison.picture = shown_in_panel(picture, *session.pool);
      context.report(action::test_view_compared, views, comparison, seconds_since(begin));
      compared = true;
    } catch (const Cancelled&) {
      throw;
    } catch (const std::exception& error) {
      context.report(action::test_view_failed, views, view, std::string(error.what()));
    }
  };
}

Job compare_photograph(const Viewer& viewer) {
  RenderSettings settings = viewer.settings;
  settings.mode = viewer.mode();
  const auto index = static_cast<std::size_t>(viewer.dataset_camera);
  return [settings, camera = viewer.scene->cameras[index], photograph = viewer.photograph,
          version = viewer.version](RenderContext& context) {
    PhotographQuality quality;
    const AtEnd end{[&] { context.report(action::photograph_compared, photograph.path, quality); }};
    const Session& session = context.session;
    const Image& image = *photograph.image;
    try {
      require_same_shape(image, photograph.path, {camera.width, camera.height});
      Image picture =
          session.renderer->render(camera, settings, {}, HostImage{}, context.stop).color;
      clamp_to_unit(picture);
      picture = area_average(picture, image.width, image.height, *session.pool);
      quality.psnr = psnr(picture, image, *session.pool);
      quality.ssim = ssim(picture, image, *session.pool);
    } catch (const Error& error) {
      quality.problem = error.what();
    }
    quality.version = version;
  };
}

bool photograph_is_pending(const Viewer& v) {
  if (!v.scene || v.remote || !v.panels.photograph || v.dataset_camera < 0 || !v.photograph.image ||
      is_training(v) || v.zoom.running)
    return false;
  const auto found = v.scene->photographs.find(v.dataset_camera);
  return found != v.scene->photographs.end() && found->second == v.photograph.path &&
         !(v.photograph.quality && v.photograph.quality->version == v.version);
}

void action::follow_photograph(Viewer& v, Host& host) {
  const bool shows_view = v.shown.version == v.version && v.shown.divisor == 1 && v.still();
  if (!photograph_is_pending(v) || !shows_view || v.photograph.compared == v.version) return;
  v.photograph.compared = v.version;
  host.run_behind(compare_photograph(v));
}

bool test_view_is_pending(const Viewer& viewer) {
  if (!panel_asks(viewer)) return false;
  const TestView& shown = viewer.training->test_view;
  return !shown.photograph || shown.compares || lacks_comparison(viewer);
}

void action::follow_test_view(Viewer& v, Host& host) {
  if (!panel_asks(v)) return;
  TestView& shown = v.training->test_view;
  if (!shown.asked) {
    shown.asked = true;
    return host.read_test_photograph(v.training->views, shown.view);
  }
  if (!comparison_is_due(v)) return;
  shown.compares = true;
  host.run_behind(compare_test_view(*v.training));
}

void action::follow_view_choice(Viewer& viewer, Host& host) {
  const bool shows_scene = viewer.scene && viewer.shown.version == viewer.version &&
                           viewer.shown.divisor == 1 && viewer.still();
  if (!viewer.view_choice.wanted || viewer.view_choice.asked || !shows_scene) return;
  viewer.view_choice.asked = true;
  RenderSettings settings = viewer.settings;
  settings.mode = viewer.mode();
  constexpr float kPictureWidth = 240;  // screen units at 100 %
  const int width = static_cast<int>(std::lround(kPictureWidth * interface_scale(viewer)));
  host.run([scene = viewer.scene->path, views = viewer.scene->candidates, settings,
            width](RenderContext& context) {
    context.report(action::candidates_drawn, scene,
                   std::make_shared<const Image>(draw_candidates(context, views, settings, width)));
  });
}

}  // namespace qs
