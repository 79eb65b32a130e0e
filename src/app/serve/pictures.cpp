// SPDX-License-Identifier: MIT
#include "app/serve/pictures.h"

#include <algorithm>
#include <chrono>
#include <limits>
#include <new>
#include <ranges>
#include <set>
#include <utility>

#include "app/session/levels.h"
#include "app/viewer/render/host_frames.h"
#include "app/viewer/render/resolution.h"
#include "app/viewer/render/upload_scene.h"
#include "base/error.h"
#include "io/picture/image_file.h"

namespace qs {
namespace {

constexpr int kStripPixels = 1 << 18;  ///< about 12 ms of encoding, and half a percent more bytes

int strip_rows(int width) { return std::max(16, kStripPixels / std::max(1, width)); }

// The sentence of an exception; nothing for Cancelled.
std::string sentence_of(const std::exception_ptr& exception) {
  try {
    std::rethrow_exception(exception);
  } catch (const Cancelled&) {
    return {};
  } catch (const std::exception& error) {
    return qs::sentence_of(error);
  }
}

}  // namespace

double seconds_now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

Pictures::Pictures(ServedScenes& scenes, Receiver receiver)
    : scenes_(scenes),
      receiver_(std::move(receiver)),
      processors_(std::max(2u, std::thread::hardware_concurrency())) {
  for (const auto& scene : scenes_) {
    scene->reported = [this, &reports = scene->reports] {
      Actions actions;
      reports.take(actions);
      if (!actions.empty()) receiver_.report(reporting_, std::move(actions));
    };
    RenderContext& context = scene->context;
    context.give_way = [this] { serve_each(); };
    context.make_renderer = [this, make = context.make_renderer](Backend backend,
                                                                 const Session& owner) {
      // The visitor may have gone on to another scene.
      const auto report = [this, visitor = reporting_,
                           path = owner.scene->path](const LevelFacts& facts) {
        receiver_.report(visitor, {[path, facts](Viewer& viewer, Host&) {
                           if (viewer.scene && viewer.scene->path == path)
                             action::levels_made(viewer, facts);
                         }});
      };
      return with_levels(make(backend, owner), owner.levels, *owner.pool, report, &awaits_cuts_);
    };
  }
  for (unsigned i = 1; i < processors_; ++i)
    encoders_.emplace_back([this](const std::stop_token& stop) { encode(stop); });
  renderer_ = std::jthread([this](const std::stop_token& stop) { render(stop); });
}

// ---- whose table is measured next ---------------------------------------------------------------
void MeasuringTurns::want(const Turn& turn) {
  if (!spent_ms_.contains(turn.visitor)) {
    // Time before the visitor came is no claim.
    const auto spent = std::views::values(spent_ms_);
    spent_ms_[turn.visitor] = spent.empty() ? 0 : std::ranges::min(spent);
  }
  wanted_[turn.visitor] = turn;
}

void MeasuringTurns::drop(int visitor) { wanted_.erase(visitor); }

void MeasuringTurns::forget(int visitor) {
  wanted_.erase(visitor);
  spent_ms_.erase(visitor);
}

std::optional<MeasuringTurns::Turn> MeasuringTurns::next() const {
  const auto found = std::ranges::min_element(
      wanted_, {}, [&](const auto& entry) { return spent_ms_.at(entry.first); });
  return found == wanted_.end() ? std::nullopt : std::optional(found->second);
}

void MeasuringTurns::measured(int visitor, int version, double ms, bool answered) {
  const auto spent = spent_ms_.find(visitor);
  if (spent != spent_ms_.end()) spent->second += ms;
  const auto found = wanted_.find(visitor);
  if (answered && found != wanted_.end() && found->second.request.version == version)
    wanted_.erase(found);
}

// ---- pictures and jobs --------------------------------------------------------------------------
template <class Change>
void Pictures::change(Change&& change) {
  const std::lock_guard lock(mutex_);
  change();
  changed_.notify_all();
}

Pictures::~Pictures() {
  all_.request_stop();
  renderer_.request_stop();
  for (std::jthread& encoder : encoders_) encoder.request_stop();
  change([&] {
    for (auto& [visitor, work] : work_) work.stop.request_stop();
    long_stop_.request_stop();
    measuring_stop_.request_stop();
  });
  renderer_.join();
  for (const auto& scene : scenes_) scene->own.clear();  // they report to this object
}

Pictures::Work* Pictures::find(int visitor) {
  const auto found = work_.find(visitor);
  return found == work_.end() ? nullptr : &found->second;
}

// The work of a visitor who wants a picture or a short job now.
Pictures::Work& Pictures::requested(int visitor) {
  Work& work = work_[visitor];
  work.used_ms = std::max(work.used_ms, served_ms_);  // time without orders is no claim
  note_request();
  return work;
}

void Pictures::order(int visitor, PictureOrder order) {
  change([&] {
    Work& work = requested(visitor);
    work.order = std::move(order);
    work.watches = true;
  });
}

void Pictures::run(int visitor, std::size_t scene, Job job) {
  change([&] { requested(visitor).jobs.emplace_back(scene, std::move(job)); });
}

void Pictures::run_long(int visitor, std::size_t scene, Job job) {
  change([&] {
    long_jobs_.push_back({visitor, scene, std::move(job)});
    measuring_stop_.request_stop();
  });
}

void Pictures::stop_long(int visitor) {
  std::size_t dropped = 0;
  change([&] {
    dropped = std::erase_if(long_jobs_, [&](const LongJob& job) { return job.visitor == visitor; });
    if (long_visitor_ == visitor) long_stop_.request_stop();
  });
  for (; dropped > 0; --dropped) receiver_.report(visitor, {});
}

void Pictures::measure(const MeasuringTurns::Turn& turn) {
  change([&] { turns_.want(turn); });
}

void Pictures::stop_measuring(int visitor) {
  const std::lock_guard lock(mutex_);
  turns_.drop(visitor);
  if (measured_visitor_ == visitor) measuring_stop_.request_stop();
}

// Somebody wants a picture or a short job: measurements are void.
void Pictures::note_request() {
  measuring_stop_.request_stop();
  for (const auto& scene : scenes_) {
    scene->context.window_rests = false;
    ++scene->context.drawings;
  }
}

void Pictures::cancel_lossless(int visitor) {
  const std::lock_guard lock(mutex_);
  if (Work* const work = find(visitor); work != nullptr && work->lossless)
    work->stop.request_stop();
}

void Pictures::forget(int visitor) {
  stop_long(visitor);
  stop_measuring(visitor);
  const std::lock_guard lock(mutex_);
  turns_.forget(visitor);
  if (Work* const work = find(visitor)) work->stop.request_stop();
  work_.erase(visitor);
}

int Pictures::next_visitor() const {
  int next = -1;
  double least = std::numeric_limits<double>::infinity();
  for (const auto& [visitor, work] : work_) {
    if (!work.order && work.jobs.empty()) continue;
    if (work.used_ms < least) least = work.used_ms, next = visitor;
  }
  return next;
}

// The visitors who share the threads of video.
std::size_t Pictures::watchers() const {
  return static_cast<std::size_t>(
      std::ranges::count_if(work_, [](const auto& entry) { return entry.second.watches; }));
}

bool Pictures::is_quiet() const { return next_visitor() < 0 && drawn_.empty() && encoding_ == 0; }

void Pictures::render(const std::stop_token& stop) {
  Lock lock(mutex_);
  const auto has_work = [&] {
    return next_visitor() >= 0 || !long_jobs_.empty() || (is_quiet() && turns_.next());
  };
  while (changed_.wait(lock, stop, has_work)) {
    if (const int visitor = next_visitor(); visitor >= 0) {
      serve(lock, visitor);
    } else if (!long_jobs_.empty()) {
      run_next_long(lock);
    } else {
      measure_next(lock);
    }
  }
}

// Draws the visitor's picture or runs a short job, also from within a long job.
void Pictures::serve(Lock& lock, int visitor) {
  Work& work = work_[visitor];
  served_ms_ = work.used_ms;
  const double began = seconds_now();
  if (!work.jobs.empty() && (work.drew_last || !work.order)) {
    const auto [scene, job] = std::move(work.jobs.front());
    work.jobs.pop_front();
    work.drew_last = false;
    lock.unlock();
    run_job(visitor, scene, job, all_.get_token());
    receiver_.report(visitor, {});
  } else {
    PictureOrder next = std::move(*work.order);
    work.order.reset();
    work.drew_last = true;
    work.stop = std::stop_source();
    work.lossless = next.lossless;
    const std::stop_token token = work.stop.get_token();
    const std::optional<HeldScale> scale = work.heat_scale;
    lock.unlock();
    draw(visitor, std::move(next), token, scale);
  }
  const double spent_ms = 1e3 * (seconds_now() - began);
  lock.lock();
  if (Work* const still = find(visitor)) still->used_ms += spent_ms;
}

// Between two parts of a long job: everybody who waits gets one picture or short job.
void Pictures::serve_each() {
  Lock lock(mutex_);
  if (long_visitor_ < 0) return;
  for (std::size_t most = work_.size(); most > 0 && next_visitor() >= 0; --most)
    serve(lock, next_visitor());
  for (const auto& scene : scenes_) scene->context.window_rests = is_quiet();
}

void Pictures::run_next_long(Lock& lock) {
  const LongJob next = std::move(long_jobs_.front());
  long_jobs_.pop_front();
  long_visitor_ = next.visitor;
  long_stop_ = std::stop_source();
  lock.unlock();
  run_job(next.visitor, next.scene, next.job, long_stop_.get_token());
  receiver_.report(next.visitor, {});
  lock.lock();
  long_visitor_ = -1;
}

void Pictures::measure_next(Lock& lock) {
  const MeasuringTurns::Turn turn = *turns_.next();
  measured_visitor_ = turn.visitor;
  measuring_stop_ = std::stop_source();
  const std::stop_token token = measuring_stop_.get_token();
  const double began = seconds_now();
  lock.unlock();
  const auto tell = [&](Measuring state) {
    if (receiver_.measuring) receiver_.measuring(turn.visitor, turn.request.version, state);
  };
  tell(Measuring::runs);
  run_job(
      turn.visitor, turn.scene,
      [&](RenderContext& context) { measure_modes(context, turn.request); }, token);
  const bool answered = !token.stop_requested();
  tell(answered ? Measuring::none : Measuring::waits);
  const double spent_ms = 1e3 * (seconds_now() - began);
  lock.lock();
  turns_.measured(turn.visitor, turn.request.version, spent_ms, answered);
  measured_visitor_ = -1;
}

// In its scope the renderer's thread works for a visitor, with the visitor's own renderers if the
// scene has levels of detail.
class Pictures::Turn {
 public:
  /// `awaits`: cuts wait for their pages.
  Turn(Pictures& pictures, int visitor, std::size_t scene, bool awaits)
      : Turn(pictures, *pictures.scenes_[scene]) {
    pictures.reporting_ = visitor;
    pictures.awaits_cuts_ = awaits;
    Session& session = scene_.context.session;
    if (!session.scene || !session.scene->stream || scene_.own[visitor].in_use) return;
    std::set<int> here;
    pictures.change([&] {
      for (const auto& [number, work] : pictures.work_) here.insert(number);
    });
    for (const auto& other : pictures.scenes_)  // a visitor looks at one scene at a time
      std::erase_if(other->own, [&](const auto& entry) {
        const auto& [number, own] = entry;
        return !own.in_use && (number == visitor ? other.get() != &scene_ : !here.contains(number));
      });
    OwnRenderers& own = scene_.own[visitor];
    if (!own.renderer || own.backend != session.backend)
      own = {session.backend, upload_to(scene_.context, session.scene, session.backend, {})};
    own_ = &own;
    swap();
  }
  ~Turn() {
    pictures_.reporting_ = outer_visitor_;
    pictures_.awaits_cuts_ = outer_awaits_;
    if (own_ == nullptr) return;
    swap();
    own_->backend = scene_.context.session.backend;  // a job may have changed it
  }

 private:
  Turn(Pictures& pictures, ServedScene& scene)
      : pictures_(pictures),
        scene_(scene),
        outer_visitor_(pictures.reporting_),
        outer_awaits_(pictures.awaits_cuts_) {}

  void swap() {
    own_->in_use = !own_->in_use;
    std::swap(own_->renderer, scene_.context.session.renderer);
    std::swap(own_->second, scene_.context.session.second);
  }

  Pictures& pictures_;
  ServedScene& scene_;
  const int outer_visitor_;
  const bool outer_awaits_;
  OwnRenderers* own_ = nullptr;
};

void Pictures::draw(int visitor, PictureOrder order, std::stop_token stop,
                    std::optional<HeldScale> heat_scale) {
  Drawn drawn;
  drawn.visitor = visitor;
  drawn.stop = stop;
  drawn.picture.order = std::move(order);
  const FrameRequest& request = drawn.picture.order.request;
  RenderContext& context = scenes_[drawn.picture.order.scene]->context;
  const std::stop_token outer_stop = std::exchange(context.stop, stop);
  try {
    const Turn turn(*this, visitor, drawn.picture.order.scene, false);
    context.heat_scale = std::move(heat_scale);
    FrameRequest scaled = request;
    Camera camera = request.camera;
    if (request.divisor > 1) {
      camera = camera.reduced(request.divisor);
      scaled.settings = reduced(scaled.settings, request.divisor);
    }
    RenderedFrame frame = draw_on_host(context, scaled, camera);
    drawn.picture.shown = frame.shown;
    drawn.picture.width = frame.width;
    drawn.picture.height = frame.height;
    drawn.rgba = painted(scaled, drawn.picture.order.split, std::move(frame));
    drawn.now = seconds_now();
  } catch (...) {
    drawn.picture.error = sentence_of(std::current_exception());
    drawn.rgba.clear();
  }
  context.stop = outer_stop;
  const RenderStats stats = drawn.picture.shown.stats;
  const bool pairs = request.moving && stats.frame_ms > 0;
  const PictureOrder drawn_order = pairs ? drawn.picture.order : PictureOrder();
  change([&] {
    if (Work* const work = find(visitor)) work->heat_scale = context.heat_scale;
    drawn_.push_back(std::move(drawn));
  });
  receiver_.drawn(visitor);
  if (pairs) pair(visitor, drawn_order, stats);
}

// Draws another mode at the view of a picture, for the visitor's table.
void Pictures::pair(int visitor, const PictureOrder& order, const RenderStats& shown) {
  PairedFrames paired;
  change([&] {
    if (Work* const work = find(visitor)) paired = work->paired;
  });
  const Camera camera = order.request.camera.reduced(order.request.divisor);
  run_job(
      visitor, order.scene,
      [&](RenderContext& context) { paired.follow(context, order.request, camera, shown); },
      all_.get_token(), false);
  change([&] {
    if (Work* const work = find(visitor)) work->paired = paired;
  });
}

void Pictures::run_job(int visitor, std::size_t scene, const Job& job, std::stop_token stop,
                       bool awaits) {
  ServedScene& served = *scenes_[scene];
  const int outer = std::exchange(reporting_, visitor);
  std::optional<Turn> turn;
  const std::stop_token outer_stop = std::exchange(served.context.stop, std::move(stop));
  try {
    turn.emplace(*this, visitor, scene, awaits);
    job(served.context);
  } catch (...) {
    const std::string sentence = sentence_of(std::current_exception());
    if (!sentence.empty()) served.context.report(action::notify_error, sentence);
  }
  turn.reset();
  served.context.stop = outer_stop;
  reporting_ = outer;
}

// Moving pictures first: a picture at rest takes several times as long.
std::deque<Pictures::Drawn>::iterator Pictures::next_drawn() {
  const auto is_free = [&](const Drawn& drawn) {
    const Work* const work = find(drawn.visitor);
    return work == nullptr || !work->encodes;
  };
  const auto moving = std::ranges::find_if(
      drawn_, [&](const Drawn& drawn) { return is_free(drawn) && !drawn.picture.order.lossless; });
  return moving != drawn_.end() ? moving : std::ranges::find_if(drawn_, is_free);
}

void Pictures::encode(const std::stop_token& stop) {
  Lock lock(mutex_);
  while (changed_.wait(lock, stop, [&] { return next_drawn() != drawn_.end(); })) {
    const auto next = next_drawn();
    Drawn drawn = std::move(*next);
    drawn_.erase(next);
    ++encoding_;
    std::shared_ptr<PictureEncoder> encoder;  // none if the visitor has left
    if (Work* const work = find(drawn.visitor)) {
      encoder = work->encoder;
      work->encodes = true;
    }
    drawn.picture.order.encoding.threads = video_threads(processors_, watchers());
    lock.unlock();
    answer(encoder.get(), drawn);
    lock.lock();
    if (Work* const work = find(drawn.visitor)) work->encodes = false;
    --encoding_;
    changed_.notify_all();
  }
}

// Calls `ready` with each strip. `encoder`: null if nobody waits for the picture.
void Pictures::answer(PictureEncoder* encoder, Drawn& drawn) {
  Picture& picture = drawn.picture;
  const int rows = picture.order.lossless ? strip_rows(picture.width) : picture.height;
  const auto width = static_cast<std::size_t>(picture.width);
  Encoding encoding = picture.order.encoding;
  if (picture.order.lossless) encoding.codec = PictureCodec::webp;
  do {
    picture.encoded = {};
    const int height = std::min(rows, picture.height - picture.top);
    if (encoder != nullptr && !drawn.rgba.empty() && !drawn.stop.stop_requested()) {
      try {
        const auto strip = std::span(drawn.rgba)
                               .subspan(4 * width * static_cast<std::size_t>(picture.top),
                                        4 * width * static_cast<std::size_t>(height));
        picture.encoded =
            encoder->encode({strip, picture.width, height}, encoding, drawn.now, drawn.stop);
      } catch (...) {
        picture.error = sentence_of(std::current_exception());
      }
    }
    picture.is_last = picture.encoded.bytes.empty() || picture.top + height == picture.height;
    receiver_.ready(drawn.visitor, picture);
    picture.top += height;
  } while (!picture.is_last);
}

}  // namespace qs
