// SPDX-License-Identifier: MIT
//
// Makes the visitors' pictures: one thread renders, the other processors encode. Each visitor has
// at most one order; a newer order replaces one that waits. The visitor who has used the renderer
// least is next, and a visitor without orders costs nothing.
#pragma once

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

namespace qs {

struct PictureOrder {
  std::size_t scene = 0;  ///< number
  FrameRequest request;
  std::uint32_t input = 0;  ///< the last input that the request answers
  bool lossless = false;
  Encoding encoding;  ///< of a picture that is not lossless
};

/// The answer to an order.
struct Picture {
  PictureOrder order;
  ShownFrame shown;
  int width = 0, height = 0;
  EncodedPicture encoded;  ///< without bytes if the order was cancelled or failed
  std::string error;       ///< a sentence if it failed
};

class Pictures {
 public:
  /// Called on threads of this object: for each order that was taken, `drawn` when it need no
  /// longer be rendered and then `ready`; `report` with the actions of a job.
  struct Receiver {
    std::function<void(int visitor)> drawn;
    std::function<void(int visitor, Picture picture)> ready;
    std::function<void(int visitor, Actions actions)> report;
  };

  /// `scenes` must outlive this object.
  Pictures(ServedScenes& scenes, Receiver receiver);
  /// Cancels all work.
  ~Pictures();
  Pictures(const Pictures&) = delete;
  Pictures& operator=(const Pictures&) = delete;

  void order(int visitor, PictureOrder order);
  /// Runs a job on the thread of the renderer; jobs and pictures take turns.
  void run(int visitor, std::size_t scene, Job job);
  /// Cancels a picture at rest, because the visitor has moved on; its answer is empty.
  void cancel_lossless(int visitor);
  /// Drops what the visitor has ordered.
  void forget(int visitor);

 private:
  struct Work {
    std::optional<PictureOrder> order;
    std::deque<std::pair<std::size_t, Job>> jobs;
    double used_ms = 0;                   // of the renderer
    std::optional<HeldScale> heat_scale;  // RenderContext::heat_scale of this visitor
    std::stop_source stop;                // of the order in progress
    bool lossless = false;                // the order in progress
    bool drew_last = false;               // a job is next
    std::shared_ptr<PictureEncoder> encoder = std::make_shared<PictureEncoder>();
    bool encodes = false;  // a thread uses it
  };
  struct Drawn {
    int visitor = 0;
    Picture picture;
    std::vector<std::uint8_t> rgba;
    std::stop_token stop;
    double now = 0;  // seconds
  };

  void render(const std::stop_token& stop);
  void encode(const std::stop_token& stop);
  std::deque<Drawn>::iterator next_drawn();  // of a visitor whose encoder is free
  static void encode(PictureEncoder& encoder, Drawn& drawn);
  int next_visitor() const;  // -1: none
  void draw(int visitor, PictureOrder order, std::stop_token stop,
            std::optional<HeldScale> heat_scale);
  void run_job(int visitor, std::size_t scene, const Job& job);

  ServedScenes& scenes_;
  Receiver receiver_;
  std::mutex mutex_;
  std::condition_variable_any changed_;
  std::map<int, Work> work_;
  double served_ms_ = 0;  // Work::used_ms of the visitor who is served, before the work
  std::deque<Drawn> drawn_;
  std::stop_source all_;
  std::vector<std::jthread> encoders_;
  std::jthread renderer_;
};

/// The frame's pixels as visitors see them: with the heat map or the legend of the quantity.
/// 8-bit RGBA, rows from the top.
std::vector<std::uint8_t> painted(const FrameRequest& request, RenderedFrame frame);

}  // namespace qs
