// SPDX-License-Identifier: MIT
//
// The pages of a tree in memory: threads read the pages that cuts lack, the pages with the largest
// gain first, and pages that no last cut used leave if memory is short. Several views, such as the
// visitors of a server, share the pages: each makes its own cuts, keeps the pages of the last cut
// in an equal share of the memory, and takes turns with the others when pages are read. A cut that
// is awaited has all the memory.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "raster/pages/cut.h"

namespace qs {

/// The file of a tree. Several threads call its functions.
struct PageSource {
  std::string name;  ///< for sentences
  /// Reads a page, or throws an exception if it is damaged.
  std::function<std::shared_ptr<const LodPage>(std::size_t page)> read;
  /// False if another program changed the file after it was opened.
  std::function<bool()> is_unchanged = [] { return true; };
  std::vector<std::uint64_t> stored_bytes = {};  ///< by page, in the file
};

/// A cut and the tree that it was made of.
struct StreamedCut {
  LodPages tree;
  LodCut cut;
};

/// Changes nodes, opacities, LodPage::selected and follows_leaves of a page. A node without opacity
/// and children is gone.
using PageEdit = std::function<void(LodPage& page)>;

struct StreamFacts {
  std::uint64_t nodes = 0;                  ///< of the file
  std::size_t pages = 0, resident = 0;      ///< of the file, and in memory
  std::size_t read = 0;                     ///< pages that were read since the file was opened
  std::size_t reading = 0;                  ///< pages that are wanted or being read for the view
  std::uint64_t read_bytes = 0;             ///< of the file
  std::uint64_t bytes = 0, most_bytes = 0;  ///< of memory, now and at most
};

class PageStream {
 public:
  /// `tree` has page 0, which stays. `most_bytes`: of all pages in memory.
  PageStream(LodPages tree, PageSource source, std::uint64_t most_bytes);

  /// Edits each page: the pages in memory now, the others after they are read. An edit replaces the
  /// edit before; null: pages are as they were read. A node whose children are in memory and gone,
  /// in whichever pages, is gone too. If edits chose single leaves, a node of which a part is gone
  /// is opened first. Throws Error(usage) if the tree has instances,
  /// which share their pages.
  void edit_pages(const PageEdit& edit, ThreadPool& pool);
  std::uint64_t edition() const;  ///< grows when edits change pages in memory

  /// The number of another view. `report` is called when another cut is due: after every page while
  /// the last cut lacks pages, after a cut during which pages came, and when another view comes. It
  /// must not call the stream.
  int add_view(std::function<void()> report);
  /// The view makes no more cuts. When this returns, its function is not called any more.
  void remove_view(int view);

  /// The cut with the pages in memory; starts to read pages that it lacks. `view`: a number of
  /// add_view(), or 0 for a view without.
  StreamedCut cut(const LodGain& gain, const LodLimit& limit, ThreadPool& pool, float guess = 0,
                  int view = 0);

  /// The cut with all its pages, unless they are damaged or do not fit into memory. Only one thread
  /// may await cuts.
  StreamedCut await_cut(const LodGain& gain, const LodLimit& limit, ThreadPool& pool,
                        float guess = 0);

  /// The tree with all its pages. Throws Error if one is damaged, or if they do not fit into
  /// memory.
  LodPages whole_tree(ThreadPool& pool);

  float footprint() const { return tree_.footprint; }  ///< LodPages::footprint

  StreamFacts facts(int view = 0) const;

  /// Sentences about what went wrong since the last call, one per cause.
  std::vector<std::string> take_sentences();

 private:
  struct View {
    std::function<void()> report = {};
    bool lacks_pages = false;                // its last cut
    std::vector<bool> kept = {};             // pages of its last cut, by page
    std::vector<std::uint32_t> wanted = {};  // pages, the most urgent last
  };

  View* next_reader();  // null: no page is wanted
  void stop_reading();
  void read_pages(const std::stop_token& stop);
  void store(std::uint32_t page, std::shared_ptr<const LodPage> got, const std::string& problem);
  void follow_leaves(const std::vector<std::size_t>& pages);
  void halve();
  bool make_room(std::uint64_t bytes);

  PageSource source_;
  mutable std::mutex mutex_;  // guards everything below
  std::condition_variable_any wanted_changed_, arrived_;
  LodPages tree_;
  Array<LodVisit> kept_;  // of the last cut
  struct Use {
    std::uint64_t cut = 0;  // number of the last cut that used the page
    float gain = 0;         // of that cut
  };
  std::vector<Use> uses_;                   // by page
  std::vector<std::size_t> owners_;         // pages in memory, by LodPages::content()
  std::map<int, View> views_;               // by number; 0: the view that awaits cuts, if any
  int last_view_ = 0, last_served_ = 0;     // numbers: of the newest view, and of a page's reader
  std::map<std::uint32_t, int> in_flight_;  // pages that are being read, and for whom
  PageEdit edit_;
  std::uint64_t edition_ = 0;
  std::uint64_t cuts_ = 0, events_ = 0;  // events: pages that came or died, and halved memory
  StreamFacts facts_;
  std::vector<std::string> sentences_;
  bool stopped_ = false, was_full_ = false;
  std::vector<std::jthread> threads_;  // the last member: they end first
};

}  // namespace qs
