// SPDX-License-Identifier: MIT
#include "app/plugin/plugin_renderer.h"

#include <chrono>
#include <cmath>
#include <span>
#include <utility>

#include <sys/socket.h>
#include <unistd.h>

#include "app/plugin/scene_arrays.h"
#include "base/assets.h"
#include "base/child_process.h"
#include "base/fail.h"

namespace qs {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kPollPeriod{100};  // a cancellation is noticed within this time
constexpr std::chrono::seconds kTimeToEnd{
    5};  // a process that closed its socket ends within this time

const char* activity(PluginCall call) {
  constexpr const char* kActivities[] = {"while opening the scene", "while rendering",
                                         "while closing the scene"};
  return kActivities[static_cast<int>(call)];
}

ChildCommand host_command(const std::filesystem::path& library, int scene, int image) {
  return {.words = {(program_folder() / "quadsplat").string(), kPluginHostCommand,
                    std::filesystem::absolute(library).string()},
          .socket = {{SOCK_SEQPACKET, kPluginSocket}},
          // stdout is for reports, so the output of a plugin goes to stderr.
          .inherits = {{STDERR_FILENO, STDOUT_FILENO},
                       {STDERR_FILENO, STDERR_FILENO},
                       {scene, kPluginScene},
                       {image, kPluginImage}}};
}

}  // namespace

/// The process that runs a plugin: this program with the command `plugin-host`. If a request is not
/// answered in time, or the process ends, an Error is thrown and the process is killed.
class PluginProcess {
 public:
  /// Starts the process, which ends with the calling thread; the library is loaded by the first
  /// request. `scene` and `image` are descriptors that it inherits. Throws Error(device) if no
  /// process can be started.
  PluginProcess(const std::filesystem::path& library, int scene, int image) try
      : process_(host_command(library, scene, image)) {
  } catch (const Error& error) {
    fail(error.kind(), "cannot be run, because {}", error.what());
  }

  /// True if the last request was not answered in time.
  bool timed_out() const { return timed_out_; }

  /// Waits for the reply. Throws Error(device) with a clause that begins with a verb and describes
  /// the failure of the process, and Cancelled.
  PluginReply request(const PluginRequest& request, int timeout_s, const std::stop_token& stop) {
    const auto deadline = Clock::now() + std::chrono::seconds(timeout_s);
    if (!process_.send(std::as_bytes(std::span(&request, 1)))) report_end(request.call);
    for (;;) {
      const bool ready = process_.can_receive(kPollPeriod);
      if (stop.stop_requested()) {
        process_.kill();
        throw Cancelled();
      }
      if (ready) break;
      if (Clock::now() < deadline) continue;
      process_.kill();
      timed_out_ = true;
      fail(ErrorKind::device, "did not answer within {} s {}, so its process was ended", timeout_s,
           activity(request.call));
    }
    PluginReply reply;
    if (!process_.receive(std::as_writable_bytes(std::span(&reply, 1)))) report_end(request.call);
    reply.message.back() = reply.name.back() = reply.description.back() = '\0';
    return reply;
  }

 private:
  // The process closed its socket, usually because it ended.
  [[noreturn]] void report_end(PluginCall call) {
    const std::optional<ChildEnd> end = process_.wait_for(kTimeToEnd);
    if (!end) {
      process_.kill();
      fail(ErrorKind::device, "closed quadsplat's socket {}", activity(call));
    }
    fail(ErrorKind::device, "{} {} {}",
         end->signal != 0 ? "crashed with" : "ended its process with", end->text(), activity(call));
  }

  ChildProcess process_;
  bool timed_out_ = false;
};

PluginRenderer::PluginRenderer(PluginOptions options, ThreadPool& pool)
    : options_(std::move(options)), pool_(pool), name_(options_.library.filename().string()) {}

PluginRenderer::~PluginRenderer() = default;

void PluginRenderer::refuse(const std::string& what) const {
  fail(ErrorKind::device, "plugin {}: {}", name_, what);
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
    if (process_ == nullptr)
      process_ = std::make_unique<PluginProcess>(options_.library, scene_.descriptor(),
                                                 image_.descriptor());
    reply = process_->request(request, options_.timeout_s, stop);
  } catch (const Error& error) {
    usable_ = usable_ && process_ != nullptr && !process_->timed_out();
    process_.reset();
    refuse(error.what());
  } catch (const Cancelled&) {
    process_.reset();
    throw;
  }
  if (reply.failed != 0) refuse(reply.message.data());
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
  if (settings.style != DrawStyle::splats) refuse("plugins draw splats only");
  if (settings.lens || camera.projection != Projection::pinhole)
    refuse("plugins draw pinhole views only");
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
    refuse(fmt::format("returned a frame time of {} ms", frame.frame_ms));
  if (frame.frame_ms > kClockTolerance * reply.call_ms + kClockTolerance_ms)
    refuse(fmt::format("returned a frame time of {:.3f} ms for a call that took {:.3f} ms",
                       frame.frame_ms, reply.call_ms));
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
    refuse(fmt::format(
        "{} of {} values of its image are not finite or were not written, first at pixel {},{}",
        bad, image.values.size(), first % width, first / width));
  }
}

void PluginRenderer::close() {
  if (process_ == nullptr) return;
  ask({.call = PluginCall::close}, {});
  process_.reset();
}

}  // namespace qs
