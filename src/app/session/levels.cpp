// SPDX-License-Identifier: MIT
#include "app/session/levels.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <deque>
#include <iterator>
#include <mutex>
#include <numbers>
#include <thread>
#include <tuple>
#include <utility>

#include <fmt/format.h>

#include "app/picture/level_mapper.h"
#include "app/session/surfaces.h"
#include "base/seconds.h"
#include "base/text.h"
#include "base/warn.h"
#include "io/bytes/byte_text.h"
#include "io/cloud/cloud_memory.h"
#include "learn/lod/cut.h"
#include "learn/lod/cut_slots.h"
#include "learn/lod/error_cloud.h"
#include "learn/lod/instance_tree.h"
#include "raster/lens/lens_renderer_of.h"

namespace qs {
namespace {

// The share of the gain of nodes outside of the picture. A window shows them soon (docs/lod.md).
constexpr float kOutside = 1e-4f, kOutsideWindow = 1.0f / 16;
constexpr int kUsualBudget = 1'000'000;

LodLimit limit_of(const LevelOptions& options) {
  LodLimit limit;
  if (options.budget || !options.error)
    limit.budget = static_cast<std::size_t>(options.budget.value_or(kUsualBudget));
  limit.gain = static_cast<float>(options.error.value_or(0));
  return limit;
}

// The choices that decide a cut and its Gaussians.
struct LevelView {
  LodView view;
  double dilation = 0;  // px^2 of the renderer's filter; 0: antialiased
  LodLimit limit;
  bool hides = true;          // nodes that are drawn hide those behind them
  std::uint64_t edition = 0;  // of the pages

  // `smaller_ones`: a reduced frame is served by the cut of the whole one, so that the two do not
  // alternate.
  bool serves(const LevelView& other, bool smaller_ones) const {
    const Camera &a = view.camera, &b = other.view.camera;
    const bool smaller = b.focal_px.y <= a.focal_px.y && b.width <= a.width &&
                         b.width * a.focal_px.x < 1.02 * a.width * b.focal_px.x;
    constexpr double kSameAngle = 0.05;  // of one lens before pictures of different sizes
    return a.view_from_world == b.view_from_world && a.near_depth == b.near_depth &&
           a.projection == b.projection && limit.budget == other.limit.budget &&
           hides == other.hides && edition == other.edition &&
           (smaller_ones
                ? smaller && std::abs(view.reach.angle - other.view.reach.angle) < kSameAngle
                : std::tie(a.width, a.height, a.focal_px, a.center_px, dilation, view.reach) ==
                      std::tie(b.width, b.height, b.focal_px, b.center_px, other.dilation,
                               other.view.reach));
  }
};

// The view through a lens, all of whose faces draw one cut.
LodView view_through(const LensView& lens, const Camera& camera, float outside) {
  Camera eye = lens.up ? lens::leveled(camera, *lens.up) : camera;
  if (lens.is_parallel()) return {lens::parallel(eye, lens.height), outside};
  const glm::ivec2 size(camera.width, camera.height / (lens.eye_distance > 0 ? 2 : 1));
  const SizedLens sized = lens.sized(size);
  eye.focal_px = glm::dvec2(sized.pixels_per_radian);
  constexpr int kPoints = 32;  // per side
  double widest = 0;
  for (int i = 0; i < (kPoints + 1) * (kPoints + 1); ++i) {
    const glm::dvec2 share = glm::dvec2(i % (kPoints + 1), i / (kPoints + 1)) / double{kPoints};
    if (const auto to = sized.direction(share * glm::dvec2(size) - 0.5))
      widest = std::max(widest, std::atan2(std::hypot(to->x, to->y), to->z));
  }
  widest *= 1 + 2.0 / kPoints;  // between the points
  return {eye, outside, {std::min(widest, std::numbers::pi), 0.5 * lens.eye_distance}};
}

// The number of nodes of `b` that are not in `a`.
std::size_t moved(const LodCut& a, const LodCut& b) {
  std::size_t count = 0;
  auto old = a.parts.begin();
  for (const LodPart& part : b.parts) {
    while (old != a.parts.end() && old->page < part.page) ++old;
    const bool has_old = old != a.parts.end() && old->page == part.page;
    count += has_old ? (GaussianSet(part.mask) -= old->mask).count() : part.count;
  }
  return count;
}

// A whole cut to upload, or a part of a step to the next cut.
struct ReadyStep {
  std::shared_ptr<GaussianCloud> whole = {};  // or null
  GaussianSet drawn = GaussianSet();          // of `whole`; of size 0: all
  std::function<void()> upload = {};          // of Renderer::prepare_upload(); may be empty
  CutPart part = {};
  bool is_last = false;                              // of the step
  std::shared_ptr<const GaussianSet> selected = {};  // of the last part; null: none
};

class LevelRenderer final : public Renderer, public LevelMapper {
 public:
  LevelRenderer(std::unique_ptr<Renderer> inner, const LevelOptions& options, ThreadPool& pool,
                LevelReport report, const std::atomic<bool>* awaits)
      : inner_(std::move(inner)),
        limit_(limit_of(options)),
        budget_ms_(options.budget_ms),
        pool_(pool),
        finder_(pool),
        report_(std::move(report)),
        awaits_(awaits) {}

  ~LevelRenderer() override { leave_stream(); }

  void expect(std::shared_ptr<PageStream> stream) { expected_ = std::move(stream); }

  void upload(std::shared_ptr<const GaussianCloud> cloud, const Progress& progress) override {
    leave_stream();
    stream_ = std::exchange(expected_, nullptr);
    wanted_.reset();
    awaited_.reset();
    ready_.clear();
    slots_ = {};
    uploaded_.reset();
    selected_.reset();
    antialiased_ = cloud->antialiased;
    inner_->upload(std::move(cloud), progress);
    if (!stream_ || !report_) return;
    seat_ = stream_->add_view([this] { note_news(); });
    thread_ = std::jthread([this](const std::stop_token& stop) {
      try {
        make_cuts(stop);
      } catch (const std::exception& error) {  // a damaged tree, or no memory
        report_({.stream = stream_->facts(), .sentences = {error.what()}});
      }
    });
  }

  void set_drawn(GaussianSet drawn) override {
    if (stream_) return Renderer::set_drawn(std::move(drawn));
    inner_->set_drawn(std::move(drawn));
  }

  void update(std::span<const std::uint32_t> changed) override {
    if (stream_) return Renderer::update(changed);
    inner_->update(changed);
  }

  const Frame& render(const Camera& camera, const RenderSettings& settings, const Outputs& outputs,
                      const Target& target, std::stop_token stop) override {
    if (!stream_) return inner_->render(camera, settings, outputs, target, std::move(stop));
    const bool awaits = this->awaits();
    const LevelView view = view_of(camera, settings);
    std::unique_lock lock(mutex_);
    if (awaits) {
      ready_.clear();
      lock.unlock();
      if (!awaited_ || !awaited_->serves(view, false)) show_alone(cloud_of(await_cut(view), view));
      awaited_ = view;
    } else {
      const bool is_new = awaited_ || !wanted_ || !wanted_->serves(view, true);
      if (is_new) wanted_ = view;
      views_ += is_new ? 1 : 0;
      restarts_ = restarts_ || awaited_;
      if (awaited_) ready_.clear();
      std::vector<ReadyStep> ready;
      for (std::size_t n = ready_now(is_new); n-- > 0; ready_.pop_front())
        ready.push_back(std::move(ready_.front()));
      lock.unlock();
      if (is_new) note_news();
      if (awaited_) {
        show_alone(cloud_of(cut_of(view, false, finder_, false, pool_), view));
        awaited_.reset();
      }
      apply(ready);
      std::erase_if(ready, [](const ReadyStep& step) { return !step.upload; });
      if (!ready.empty()) free_later(std::move(ready));
    }
    Outputs all = outputs;
    if (outputs.share) all.share = selected_;
    const Frame& frame = inner_->render(camera, settings, all, target, std::move(stop));
    shares_processors_ = frame.stats.threads > 0;
    if (budget_ms_ && !awaits) follow_time(static_cast<double>(frame.stats.frame_ms));
    return frame;
  }

  DrawnView draw_view(const Camera& camera, const Outputs& outputs, std::stop_token stop) {
    awaited_ = view_of(camera, {});
    const StreamedCut made = await_cut(*awaited_);
    const auto cloud = cloud_of(made, *awaited_);
    show_alone(cloud);
    DrawnView drawn{inner_->render(camera, {}, outputs, HostImage{}, std::move(stop)), cloud,
                    std::vector(made.cut.count, kNoNumber)};
    const CutPlaces places(made.tree, made.cut);
    std::size_t k = 0;
    for (const LodPart& part : made.cut.parts)
      part.for_each([&, &numbers = made.tree.pages[part.page]->numbers](std::size_t row) {
        const std::size_t place = places[k++];
        if (!numbers.empty()) drawn.numbers[place] = numbers[row];
      });
    return drawn;
  }

  bool has_stream() const { return stream_ != nullptr; }

  std::vector<std::uint32_t> level_map(const Camera& camera, const RenderSettings& settings,
                                       bool errors, std::stop_token stop) override {
    if (!stream_) return {};
    const LevelView view = view_of(camera, settings);
    const StreamedCut made = cut_of(view, awaits(), finder_, false, pool_);
    const auto cloud = cloud_of(made, view);
    paint_levels(made.tree, made.cut, view.view, view.dilation, errors, *cloud);
    show_alone(cloud);
    // The next frame has colours again, and a window its slots.
    awaited_ = awaits() ? std::nullopt : std::optional(view);
    RenderSettings on_black = settings;
    on_black.background = {};
    const Frame& frame = inner_->render(camera, on_black, {}, HostImage{}, std::move(stop));
    std::vector<std::uint32_t> map;
    for (std::size_t i = 0; i < frame.color.values.size(); i += 3) {
      const float value = frame.color.values[i];
      map.push_back(
          static_cast<std::uint32_t>(std::lround(255 * (errors ? std::sqrt(value / 3) : value))));
    }
    return map;
  }

  void prepare_target(const Target& target) override { inner_->prepare_target(target); }
  void report_frames_to(std::function<void(float fraction)> report) override {
    inner_->report_frames_to(std::move(report));
  }

 private:
  void leave_stream() {
    thread_ = {};  // waits for its end
    if (seat_ != 0) stream_->remove_view(std::exchange(seat_, 0));
  }

  void free_later(std::vector<ReadyStep> old) {
    const std::lock_guard lock(mutex_);
    std::ranges::move(old, std::back_inserter(old_));
    changed_.notify_all();
  }

  void note_news() {
    const std::lock_guard lock(mutex_);
    has_news_ = true;
    changed_.notify_all();
  }

  // The number of ready steps that the next frame shows: all of them at rest. While the view moves,
  // they are spread over the frames until the next cut, so that little of a picture changes at
  // once.
  std::size_t ready_now(bool moves) {
    if (std::exchange(has_cut_, false)) frames_per_cut_ = std::exchange(frames_, 0);
    const std::size_t left = frames_per_cut_ > frames_ ? frames_per_cut_ - frames_ : 1;
    ++frames_;
    return moves ? (ready_.size() + left - 1) / left : ready_.size();
  }

  // Leaves the old cloud in the step of a whole cut.
  void apply(std::vector<ReadyStep>& ready) {
    for (ReadyStep& step : ready) {
      if (step.whole || step.is_last) selected_ = std::move(step.selected);
      if (step.whole) {
        const auto old = std::exchange(uploaded_, nullptr);  // if the upload fails
        if (step.upload)
          step.upload();
        else
          inner_->upload(step.whole, {});
        uploaded_ = std::exchange(step.whole, old);
        drawn_ = std::move(step.drawn);
      } else if (uploaded_) {
        const CutPart& part = step.part;
        for (std::size_t k = 0; k < part.slots.size(); ++k)
          copy_gaussian(part.gaussians, k, *uploaded_, part.slots[k]);
        for (const std::uint32_t slot : part.toggled) drawn_.toggle(slot);
        inner_->update(part.slots);
      }
    }
    if (!ready.empty() && uploaded_ && drawn_.size() > 0) inner_->set_drawn(drawn_);
  }

  LevelFacts facts_of(const LevelView& view, const LodCut& cut, double ms, bool is_new) {
    return {view.view.camera,      cut.count, cut.missing.size(),       cut.limit, ms,
            stream_->facts(seat_), is_new,    stream_->take_sentences()};
  }

  // `waits`: with all its pages, else with the pages in memory. `moves`: see SurfaceFinder::cut().
  StreamedCut cut_of(const LevelView& view, bool waits, SurfaceFinder& finder, bool moves,
                     ThreadPool& pool) const {
    const auto make = [&](const LodGain& gain, const LodLimit& limit, float guess) {
      return waits ? stream_->await_cut(gain, limit, pool, guess)
                   : stream_->cut(gain, limit, pool, guess, seat_);
    };
    return view.hides
               ? finder.cut(view.view, stream_->footprint(), view.limit, view.dilation, moves, make)
               : make(gain_in(view.view, stream_->footprint()), view.limit, 0);
  }

  bool awaits() const { return !report_ || (awaits_ != nullptr && *awaits_); }

  LevelView view_of(const Camera& camera, const RenderSettings& settings) const {
    const float outside = awaits() ? kOutside : kOutsideWindow;
    return {
        settings.lens ? view_through(*settings.lens, camera, outside) : LodView(camera, outside),
        filter_of(settings, antialiased_), limit_,
        settings.style == DrawStyle::splats && settings.splat_scale == 1, stream_->edition()};
  }

  std::shared_ptr<GaussianCloud> cloud_of(const StreamedCut& made, const LevelView& view) {
    return std::make_shared<GaussianCloud>(
        cut_cloud(made.tree, made.cut, view.view, view.dilation, pool_));
  }

  // Uploads a cut to which no change belongs.
  void show_alone(std::shared_ptr<GaussianCloud> cloud) {
    std::vector<ReadyStep> alone(1);
    alone[0].whole = std::move(cloud);
    apply(alone);
    uploaded_.reset();
  }

  StreamedCut await_cut(const LevelView& view) {
    const auto start = std::chrono::steady_clock::now();
    StreamedCut made = cut_of(view, true, finder_, false, pool_);
    const LevelFacts facts = facts_of(view, made.cut, milliseconds_since(start), !report_);
    if (report_) {
      report_(facts);
    } else {
      for (const std::string& sentence : facts.sentences) warn("warning: " + sentence);
      const std::string& name = view.view.camera.name;
      warn("cut" + (name.empty() ? "" : " of " + name) + ": " + facts.text());
    }
    return made;
  }

  void follow_time(double ms) {
    constexpr double kStep = 1.05, kLeast = 1000;
    const auto most = std::max(static_cast<double>(stream_->facts().nodes), kLeast);
    const double wish = std::clamp(*budget_ms_ / std::max(ms, 1e-3), 1 / kStep, kStep);
    if (wish != 1 / kStep && wish != kStep) return;
    limit_.budget = static_cast<std::size_t>(
        std::clamp(static_cast<double>(limit_.budget) * wish, kLeast, most));
  }

  void make_cuts(const std::stop_token& stop) {
    constexpr std::chrono::milliseconds kRest{300};
    constexpr double kMoved = 0.02;   // share of the nodes
    constexpr double kLeastRest = 7;  // times the work, if frames are drawn on the same processors
    ThreadPool own(std::max(1, pool_.size() / 2));  // frames are drawn at the same time
    SurfaceFinder finder(own);
    std::uint64_t edition = 0;  // of the last cut
    std::size_t selected = 0;   // nodes of the shown cut
    bool is_late = false;       // the shown cut differs a little from the exact one
    std::size_t exact = 0;      // the number of the view whose exact cut is shown; 0: none
    std::unique_lock lock(mutex_);
    for (;;) {
      const auto news = [&] { return has_news_ && wanted_; };
      const auto work = [&] { return news() || !old_.empty(); };
      const bool came =
          is_late ? changed_.wait_for(lock, stop, kRest, work) : changed_.wait(lock, stop, work);
      if (stop.stop_requested()) return;
      if (std::vector<ReadyStep> old = std::exchange(old_, {}); !old.empty()) {
        lock.unlock();
        old.clear();
        lock.lock();
        continue;
      }
      has_news_ = false;
      const LevelView view = *wanted_;
      const bool was_replaced = std::exchange(restarts_, false);
      const std::size_t number = views_;
      lock.unlock();
      // Without the lock, because the stream calls note_news() under its own lock.
      const std::uint64_t newest = stream_->edition();
      const bool is_edited = std::exchange(edition, newest) != newest;
      const bool restarts = was_replaced || is_edited;
      const auto start = std::chrono::steady_clock::now();
      const double worked = own.processor_seconds();
      const bool moves = came && !restarts;
      const StreamedCut made = cut_of(view, false, finder, moves, own);
      const LodCut& shown = slots_.shown();
      const double change = static_cast<double>(moved(shown, made.cut) + moved(made.cut, shown)) /
                            static_cast<double>(made.cut.count);
      const bool was_exact = change == 0 && exact == number;
      const bool is_new = restarts || (came ? change >= kMoved : !was_exact);
      LevelFacts facts = facts_of(view, made.cut, milliseconds_since(start),
                                  is_new && (is_edited || !restarts || change > 0));
      CutChange step;
      if (is_new) {
        step = slots_.follow(made, view.view, view.dilation, !came || restarts, own);
        exact = step.whole && !moves ? number : 0;
        selected = step.selected.count();
      }
      facts.selected = selected;
      const bool is_whole = step.whole != nullptr;
      const double rest =
          kLeastRest * (own.processor_seconds() - worked) / static_cast<double>(pool_.size());
      ReadyStep whole{step.whole, std::move(step.drawn)};
      if (is_whole) whole.upload = inner_->prepare_upload(step.whole, own);
      std::shared_ptr<const GaussianSet> tint;
      if (selected > 0) tint = std::make_shared<GaussianSet>(std::move(step.selected));
      is_late = came && !(is_new ? exact == number : was_exact);
      lock.lock();
      if (is_whole) {
        ready_.clear();
        ready_.push_back(std::move(whole));
      }
      for (CutPart& part : step.parts) ready_.push_back({.part = std::move(part)});
      if (is_new) ready_.push_back({.is_last = true, .selected = std::move(tint)});
      has_cut_ = has_cut_ || is_new;
      lock.unlock();
      report_(facts);
      lock.lock();
      if (shares_processors_ && came && !is_whole)
        changed_.wait_for(lock, stop, std::chrono::duration<double>(rest), [] { return false; });
    }
  }

  std::unique_ptr<Renderer> inner_;
  LodLimit limit_;
  std::optional<double> budget_ms_;
  ThreadPool& pool_;
  SurfaceFinder finder_;  // of the thread that renders
  LevelReport report_;
  const std::atomic<bool>* awaits_;
  std::shared_ptr<PageStream> stream_, expected_;
  int seat_ = 0;  // its number among the views of the stream
  bool antialiased_ = false;
  std::optional<LevelView> awaited_;             // its cut was uploaded last; of render()
  std::atomic<bool> shares_processors_ = false;  // frames are drawn by the CPU
  CutSlots slots_;                               // of the thread of cuts
  std::shared_ptr<GaussianCloud> uploaded_;      // to `inner_`, for changes
  GaussianSet drawn_;                            // slots of that cloud; of size 0: all
  std::shared_ptr<const GaussianSet> selected_;  // of that cloud; null: none
  std::mutex mutex_;                             // guards everything below but the thread
  std::condition_variable_any changed_;
  std::optional<LevelView> wanted_;
  std::size_t views_ = 0;        // wanted ones so far
  std::deque<ReadyStep> ready_;  // that `inner_` does not have yet
  std::vector<ReadyStep> old_;   // with the scenes before; freeing them takes long
  bool has_cut_ = false;         // a cut came after the last frame
  std::size_t frames_ = 0;       // since the last cut
  std::size_t frames_per_cut_ = 1;
  bool restarts_ = false;  // the uploaded cloud has another cut
  bool has_news_ = false;  // another view, or another page
  std::jthread thread_;    // the last member: it ends first
};

}  // namespace

std::string LevelFacts::text() const {
  return fmt::format("{} of {} nodes, limit {:.3g}, {} read ({}), {} missing, {:.0f} ms",
                     grouped(drawn), grouped(stream.nodes), limit, counted(stream.read, "page"),
                     bytes_text(stream.read_bytes), missing, ms);
}

std::unique_ptr<Renderer> with_levels(std::unique_ptr<Renderer> inner, const LevelOptions& options,
                                      ThreadPool& pool, LevelReport report,
                                      const std::atomic<bool>* awaits) {
  return std::make_unique<LevelRenderer>(std::move(inner), options, pool, std::move(report),
                                         awaits);
}

void expect_stream(Renderer& renderer, const std::shared_ptr<PageStream>& stream) {
  if (auto* const levels = dynamic_cast<LevelRenderer*>(&renderer)) levels->expect(stream);
}

DrawnView draw_view(const Session& session, const Camera& camera, const Outputs& outputs,
                    std::stop_token stop) {
  auto* const levels = dynamic_cast<LevelRenderer*>(session.renderer.get());
  if (levels && levels->has_stream()) return levels->draw_view(camera, outputs, std::move(stop));
  return {session.renderer->render(camera, {}, outputs, HostImage{}, std::move(stop)),
          cloud_of(session.scene)};
}

Scene open_scene(const std::filesystem::path& path, ThreadPool& pool, const ReadOptions& options) {
  Scene scene;
  scene.path = find_scene_file(path, options.iteration);
  return stream_instances(options, pool, scene) ? std::move(scene)
                                                : read_scene(path, pool, options);
}

}  // namespace qs
