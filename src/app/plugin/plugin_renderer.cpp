// SPDX-License-Identifier: MIT
#include "app/plugin/plugin_renderer.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "app/plugin/scene_arrays.h"
#include "base/fail.h"

namespace qs {

PluginRenderer::PluginRenderer(PluginOptions options, ThreadPool& pool)
    : options_(std::move(options)), pool_(pool), name_(options_.library.filename().string()) {}

template <class... Args>
void PluginRenderer::refuse(fmt::format_string<Args...> format, Args&&... args) const {
  fail(ErrorKind::device, "plugin {}: {}", name_, fmt::format(format, std::forward<Args>(args)...));
}

void PluginRenderer::upload(std::shared_ptr<const GaussianCloud> cloud, const Progress& progress) {
  progress.update(0);
  process_.reset();
  usable_ = true;
  header_ = fill_scene(*cloud, pool_, scene_);
  header_.device = options_.device;
  header_.threads = pool_.size();
  antialiased_ = cloud->antialiased;
  open(progress.stop);
  progress.update(1);
}

PluginReply PluginRenderer::ask(const PluginRequest& request, const std::stop_token& stop) {
  PluginReply reply;
  try {
    if (process_ == nullptr) {
      process_ = std::make_unique<PluginProcess>(options_.library, scene_.descriptor(),
                                                 image_.descriptor());
    }
    reply = process_->request(request, options_.timeout_s, stop);
  } catch (const Error& error) {
    usable_ = usable_ && process_ != nullptr && !process_->timed_out();
    process_.reset();
    refuse("{}", error.what());
  } catch (const Cancelled&) {
    process_.reset();
    throw;
  }
  if (reply.failed != 0) refuse("{}", reply.message.data());
  return reply;
}

void PluginRenderer::open(const std::stop_token& stop) {
  usable_ = false;
  const PluginReply reply = ask({.call = PluginCall::open, .scene = header_}, stop);
  name_ = reply.name.data();
  description_ = reply.description.data();
  memory_ = reply.memory;
  image_layout_ = reply.image_layout;
  usable_ = true;
}

const Frame& PluginRenderer::render(const Camera& camera, const RenderSettings& settings,
                                    const Outputs& outputs, const Target& target,
                                    std::stop_token stop) {
  if (process_ == nullptr) open(stop);
  const bool wants_image = outputs.color && std::holds_alternative<HostImage>(target);
  image_.resize(3 * sizeof(float) * static_cast<std::size_t>(camera.width) *
                static_cast<std::size_t>(camera.height));
  const PluginReply reply = ask({.call = PluginCall::render,
                                 .wants_image = wants_image,
                                 .view = view_of(camera, settings, header_.sh_degree, antialiased_),
                                 .mark_stages = outputs.stage_times},
                                stop);
  result_.color = Image();
  result_.grid = TileGrid::of_image(camera.width, camera.height);
  take_stats(reply);
  if (wants_image) take_image(camera);
  return result_;
}

void PluginRenderer::take_stats(const PluginReply& reply) {
  // A frame takes no longer than the call that draws it. The clock of a GPU runs a little faster or
  // slower than the host's.
  constexpr double kClockTolerance = 1.02, kClockTolerance_ms = 0.05;
  const QsFrame& frame = reply.frame;
  measures_itself_ = frame.frame_ms != 0;
  if (!(frame.frame_ms >= 0 && frame.frame_ms < 1e9))
    refuse("returned a frame time of {} ms", frame.frame_ms);
  if (frame.frame_ms > kClockTolerance * reply.call_ms + kClockTolerance_ms) {
    refuse("returned a frame time of {:.3f} ms for a call that took {:.3f} ms", frame.frame_ms,
           reply.call_ms);
  }
  const double frame_ms = measures_itself_ ? frame.frame_ms : reply.call_ms;
  ++frames_;
  frames_ms_ += frame_ms;
  calls_ms_ += reply.call_ms;
  RenderStats& stats = result_.stats = {};
  stats.frame_ms = static_cast<float>(frame_ms);
  for (int stage = 0; stage < kStageCount; ++stage)
    stats.stage_ms[stage] = static_cast<float>(frame.stage_ms[stage]);
  stats.gaussians = static_cast<std::uint32_t>(header_.count);
  stats.visible = frame.visible;
  stats.tile_pairs = frame.pairs;
}

void PluginRenderer::take_image(const Camera& camera) {
  Image& image = result_.color;
  image = Image(camera.width, camera.height, 3);
  const float* const values = image_.mapping().floats();
  const std::size_t pixels = image.values.size() / 3;
  const bool planes = image_layout_ == QS_IMAGE_CHW;
  std::size_t bad = 0, first = 0;
  for (std::size_t pixel = 0; pixel < pixels; ++pixel) {
    for (std::size_t channel = 0; channel < 3; ++channel) {
      const float value = values[planes ? channel * pixels + pixel : 3 * pixel + channel];
      image.values[3 * pixel + channel] = value;
      if (std::isfinite(value)) continue;
      if (bad++ == 0) first = pixel;
    }
  }
  if (bad > 0) {
    const auto width = static_cast<std::size_t>(camera.width);
    refuse("{} of {} values of its image are not finite or were not written, first at pixel {},{}",
           bad, image.values.size(), first % width, first / width);
  }
}

void PluginRenderer::close() {
  if (process_ == nullptr) return;
  ask({.call = PluginCall::close}, {});
  process_.reset();
}

}  // namespace qs
