// SPDX-License-Identifier: MIT
//
// Makes the visitors' pictures: one thread renders, the other processors encode. Each visitor has
// at most one order; a newer order replaces one that waits. The visitor who has used the renderer
// least is next, and a visitor without orders costs nothing. Of a scene with levels of detail each
// visitor has a renderer and a cut, and they share the pages. A long job, such as a film, runs
// while no picture and no short job waits, and gives way to them between its parts. The modes are
// measured for one visitor after the other while there is no other work at all; a new order
// interrupts that.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "app/serve/picture_encoder.h"
#include "app/serve/served_scene.h"
#include "app/viewer/render/all_modes.h"

namespace qs {

/// The clock of the server.
double seconds_now();

struct PictureOrder {
  std::size_t scene = 0;  ///< number
  FrameRequest request;
  std::uint32_t input = 0;  ///< the last input that the request answers
  bool lossless = false;
  double ordered = 0;          ///< seconds of the caller's clock
  Encoding encoding;           ///< of a picture that is not lossless
  std::optional<Split> split;  ///< of a request with two variants: their places in the picture
};

/// The answer to an order, or a strip of it: a lossless picture is encoded in strips, so that the
/// first ones are on the line while the others are encoded.
struct Picture {
  PictureOrder order;
  ShownFrame shown;
  int width = 0, height = 0;  ///< of the whole picture
  int top = 0;                ///< first row of the strip
  bool is_last = true;        ///< strip
  EncodedPicture encoded;     ///< without bytes if the order was cancelled or failed
  std::string error;          ///< a sentence if it failed
};

/// The state of a visitor's request to measure all modes.
enum class Measuring { none, waits, runs };

/// Whose table of modes is measured next, without threads: each visitor has at most one request,
/// and the visitor who was measured least is next.
class MeasuringTurns {
 public:
  struct Turn {
    int visitor = 0;
    std::size_t scene = 0;
    NumbersRequest request;
  };

  /// Replaces the visitor's request.
  void want(const Turn& turn);
  /// The visitor wants nothing more.
  void drop(int visitor);
  /// Forgets the visitor and the time.
  void forget(int visitor);

  std::optional<Turn> next() const;
  /// The visitor was measured for so long. `version`: NumbersRequest::version; the request is
  /// dropped if `answered` and it was not replaced meanwhile.
  void measured(int visitor, int version, double ms, bool answered);

 private:
  std::map<int, Turn> wanted_;      // by visitor
  std::map<int, double> spent_ms_;  // by visitor
};

class Pictures {
 public:
  /// Called on threads of this object and of its callers: for each order that was taken, `drawn`
  /// when it need no longer be rendered and then `ready` with each strip; `report` with actions of
  /// a job and without actions at the end of each job; `measuring` when the state of the request
  /// with this view version changes.
  struct Receiver {
    std::function<void(int visitor)> drawn;
    std::function<void(int visitor, Picture picture)> ready;
    std::function<void(int visitor, Actions actions)> report;
    std::function<void(int visitor, int version, Measuring state)> measuring = {};
  };

  /// `scenes` must outlive this object.
  Pictures(ServedScenes& scenes, Receiver receiver);
  /// Cancels all work.
  ~Pictures();

  /// The number of another visitor, from 1 on.
  int new_visitor() { return ++visitors_; }

  void order(int visitor, PictureOrder order);
  /// Runs a job on the thread of the renderer; jobs and pictures take turns.
  void run(int visitor, std::size_t scene, Job job);
  /// Runs a job that gives way (Host::run_long) when nothing else is wanted, after the long jobs
  /// before it.
  void run_long(int visitor, std::size_t scene, Job job);
  /// Stops the visitor's long jobs.
  void stop_long(int visitor);
  /// Measures all modes when nothing else is wanted. Replaces the visitor's request.
  void measure(const MeasuringTurns::Turn& turn);
  void stop_measuring(int visitor);
  /// Cancels a picture at rest, because the visitor has moved on; its answer is empty.
  void cancel_lossless(int visitor);
  /// Drops what the visitor has ordered.
  void forget(int visitor);

 private:
  class Turn;
  struct Work {
    std::optional<PictureOrder> order;
    std::deque<std::pair<std::size_t, Job>> jobs;
    double used_ms = 0;                   // of the renderer
    std::optional<HeldScale> heat_scale;  // RenderContext::heat_scale of this visitor
    std::stop_source stop;                // of the order in progress
    bool lossless = false;                // the order in progress
    bool drew_last = false;               // a job is next
    PairedFrames paired;
    std::shared_ptr<PictureEncoder> encoder = std::make_shared<PictureEncoder>();
    bool encodes = false;  // a thread uses it
    bool watches = false;  // has ordered pictures: not SIBR's viewers, a training, or nobody
  };
  struct Drawn {
    int visitor = 0;
    Picture picture;
    std::vector<std::uint8_t> rgba;
    std::stop_token stop;
    double now = 0;  // seconds
  };

  struct LongJob {
    int visitor = 0;
    std::size_t scene = 0;
    Job job;
  };
  using Lock = std::unique_lock<std::mutex>;

  template <class Change>
  void change(Change&& change);  // with the lock, and wakes the threads
  Work* find(int visitor);
  Work& requested(int visitor);
  void render(const std::stop_token& stop);
  void encode(const std::stop_token& stop);
  std::deque<Drawn>::iterator next_drawn();  // of a visitor whose encoder is free
  void answer(PictureEncoder* encoder, Drawn& drawn);
  int next_visitor() const;  // -1: none
  bool is_quiet() const;     // nobody waits for a picture or a short job
  void note_request();
  std::size_t watchers() const;
  void serve(Lock& lock, int visitor);
  void serve_each();
  void run_next_long(Lock& lock);
  void measure_next(Lock& lock);
  void draw(int visitor, PictureOrder order, std::stop_token stop,
            std::optional<HeldScale> heat_scale);
  void pair(int visitor, const PictureOrder& order, const RenderStats& shown);
  void run_job(int visitor, std::size_t scene, const Job& job, std::stop_token stop,
               bool awaits = true);

  ServedScenes& scenes_;
  Receiver receiver_;
  const unsigned processors_;
  std::atomic<int> visitors_ = 0;  // so far
  std::mutex mutex_;
  std::condition_variable_any changed_;
  std::map<int, Work> work_;
  double served_ms_ = 0;  // Work::used_ms of the visitor who is served, before the work
  std::deque<Drawn> drawn_;
  int encoding_ = 0;  // pictures
  std::deque<LongJob> long_jobs_;
  int long_visitor_ = -1;       // whose long job runs; -1: none
  std::stop_source long_stop_;  // of it
  MeasuringTurns turns_;
  int measured_visitor_ = -1;              // who is being measured; -1: nobody
  std::stop_source measuring_stop_;        // of it
  int reporting_ = -1;                     // whose turn it is; only the renderer's thread uses it
  std::atomic<bool> awaits_cuts_ = false;  // of levels of detail: in jobs
  std::stop_source all_;
  std::vector<std::jthread> encoders_;
  std::jthread renderer_;
};

/// The pixels of a frame as visitors see them: with its heat map and legend, beside the other frame
/// of a split window, or as their difference. The window draws the same by shaders/present.frag.
/// 8-bit RGBA, rows from the top. `split`: of a frame with a second frame; an amplification of 0 is
/// chosen from the frames.
std::vector<std::uint8_t> painted(const FrameRequest& request, const std::optional<Split>& split,
                                  RenderedFrame frame);

}  // namespace qs
