// SPDX-License-Identifier: MIT
//
// The pages of a tree in memory: threads read the pages that cuts lack, the pages with the largest
// gain first, and pages that the last cut did not use leave if memory is short.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <mutex>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "raster/pages/cut.h"

namespace qs {

/// The file of a tree. Several threads call its functions.
struct PageSource {
  std::string name;  ///< for sentences
  /// Reads a page, or throws an exception if it is damaged.
  std::function<LodPage(std::size_t page)> read;
  /// False if another program changed the file after it was opened.
  std::function<bool()> is_unchanged = [] { return true; };
  std::vector<std::uint64_t> stored_bytes = {};  ///< by page, in the file
};

/// A cut and the tree that it was made of.
struct StreamedCut {
  LodPages tree;
  LodCut cut;
};

struct StreamFacts {
  std::uint64_t nodes = 0;                  ///< of the file
  std::size_t pages = 0, resident = 0;      ///< of the file, and in memory
  std::size_t read = 0;                     ///< pages that were read since the file was opened
  std::size_t reading = 0;                  ///< pages that are wanted or being read
  std::uint64_t read_bytes = 0;             ///< of the file
  std::uint64_t bytes = 0, most_bytes = 0;  ///< of memory, now and at most
};

class PageStream {
 public:
  /// `tree` has page 0, which stays. `most_bytes`: of all pages in memory.
  PageStream(LodPages tree, PageSource source, std::uint64_t most_bytes);

  /// The cut with the pages in memory; starts to read pages that it lacks.
  StreamedCut cut(const LodGain& gain, const LodLimit& limit, ThreadPool& pool, float guess = 0);

  /// The cut with all its pages, unless they are damaged or do not fit into memory.
  StreamedCut await_cut(const LodGain& gain, const LodLimit& limit, ThreadPool& pool,
                        float guess = 0);

  float footprint() const { return tree_.footprint; }  ///< LodPages::footprint

  StreamFacts facts() const;

  /// Sentences about what went wrong since the last call, one per cause.
  std::vector<std::string> take_sentences();

  /// Called on a reading thread after every page; it must not call the stream. When this returns,
  /// the function before is not called any more.
  void report_pages_to(std::function<void()> report) {
    const std::lock_guard lock(mutex_);
    report_ = std::move(report);
  }

 private:
  void read_pages(const std::stop_token& stop);
  void store(std::uint32_t page, std::shared_ptr<const LodPage> got, const std::string& problem);
  void halve();
  bool make_room(std::uint64_t bytes);

  const PageSource source_;
  mutable std::mutex mutex_;  // guards everything below
  std::function<void()> report_;
  std::condition_variable_any wanted_changed_, arrived_;
  LodPages tree_;
  Array<LodVisit> kept_;  // of the last cut
  struct Use {
    std::uint64_t cut = 0;  // number of the last cut that used the page
    float gain = 0;         // of that cut
  };
  std::vector<Use> uses_;                // by page
  std::vector<std::uint32_t> wanted_;    // pages, the most urgent last
  std::set<std::uint32_t> in_flight_;    // pages that are being read
  std::uint64_t cuts_ = 0, events_ = 0;  // events: pages that came or died, and halved memory
  StreamFacts facts_;
  std::vector<std::string> sentences_;
  bool stopped_ = false, was_full_ = false;
  std::vector<std::jthread> threads_;  // the last member: they end first
};

}  // namespace qs
