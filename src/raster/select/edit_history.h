// SPDX-License-Identifier: MIT
//
// The steps of editing one scene and the way back: each step keeps the differences of the sets. The
// oldest differences and lists of results go once they take too much memory.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "raster/select/editing.h"

namespace qs {

/// The Gaussians in which two sets of one size differ, as runs or as bits, whichever takes less
/// memory.
class SetChange {
 public:
  SetChange(const GaussianSet& from, const GaussianSet& to);
  /// Changes either set into the other set.
  void apply(GaussianSet& set) const;
  std::size_t memory() const { return runs_.capacity() * sizeof(GaussianRun) + bits_.memory(); }

 private:
  std::vector<GaussianRun> runs_;
  GaussianSet bits_;  // used if it is not empty
};

/// Copies share the steps.
class EditHistory {
 public:
  static constexpr std::size_t kMostBytes = std::size_t{256} << 20;

  explicit EditHistory(std::size_t gaussians = 0, std::size_t most_bytes = kMostBytes);

  const EditState& state() const { return *state_; }
  std::shared_ptr<const EditState> shared_state() const { return state_; }

  /// The steps that led to the state, without the steps that were taken back.
  std::vector<EditStep> steps() const;
  /// The number of these steps whose kind is one of some kinds.
  int count(bool (*is_one)(EditKind)) const;
  bool has_steps() const { return done_ > 0; }

  /// Adds a step that leads to this state, whose sets have one size. Steps that were taken back are
  /// forgotten. Sets of another size begin a new history.
  void take(EditStep step, EditState after);

  bool can_undo() const { return done_ > without_way_back_; }
  bool can_redo() const { return done_ < taken_.size(); }
  /// No effect if it cannot.
  void undo();
  void redo();

  /// Of the differences and lists of results, bytes; at most `most_bytes`.
  std::size_t memory() const { return memory_; }

 private:
  struct Changes {
    SetChange selected, hidden, removed;
    std::size_t memory() const { return selected.memory() + hidden.memory() + removed.memory(); }
  };
  struct Taken {
    std::shared_ptr<const EditStep> step;
    std::shared_ptr<const Changes> changes;  // null: forgotten
  };
  void change_state(const Changes& changes);

  std::shared_ptr<const EditState> state_;
  std::vector<Taken> taken_;  // the first `done_` led to the state
  std::size_t done_ = 0, without_way_back_ = 0, memory_ = 0, most_bytes_;
};

}  // namespace qs
