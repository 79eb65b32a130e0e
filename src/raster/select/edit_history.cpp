// SPDX-License-Identifier: MIT
#include "raster/select/edit_history.h"

#include <bit>
#include <cstddef>
#include <utility>

namespace qs {
namespace {

// The number of runs, without making them.
std::size_t count_runs(const GaussianSet& set) {
  std::size_t count = 0;
  unsigned last = 0;  // the bit before the byte
  for (const std::byte byte : set.bytes()) {
    const auto bits = std::to_integer<unsigned>(byte);
    count += static_cast<std::size_t>(std::popcount(bits & ~(bits << 1 | last)));
    last = bits >> 7;
  }
  return count;
}

}  // namespace

SetChange::SetChange(const GaussianSet& from, const GaussianSet& to) : bits_(from) {
  bits_ ^= to;
  if (count_runs(bits_) * sizeof(GaussianRun) >= bits_.memory()) return;
  runs_ = bits_.runs();
  runs_.shrink_to_fit();
  bits_ = GaussianSet();
}

void SetChange::apply(GaussianSet& set) const {
  if (bits_.size() > 0) set ^= bits_;
  for (const GaussianRun& run : runs_)
    for (std::uint64_t i = 0; i < run.count; ++i)
      set.toggle(static_cast<std::size_t>(run.first + i));
}

EditHistory::EditHistory(std::size_t gaussians, std::size_t most_bytes)
    : state_(std::make_shared<const EditState>(gaussians)), most_bytes_(most_bytes) {}

std::vector<EditStep> EditHistory::steps() const {
  std::vector<EditStep> steps;
  for (std::size_t i = 0; i < done_; ++i) steps.push_back(*taken_[i].step);
  return steps;
}

int EditHistory::count(bool (*is_one)(EditKind)) const {
  int count = 0;
  for (std::size_t i = 0; i < done_; ++i) count += is_one(taken_[i].step->kind);
  return count;
}

void EditHistory::take(EditStep step, EditState after) {
  if (after.removed.size() != state_->removed.size())
    *this = EditHistory(after.removed.size(), most_bytes_);
  for (std::size_t i = done_; i < taken_.size(); ++i) memory_ -= taken_[i].changes->memory();
  taken_.resize(done_);
  auto changes = std::make_shared<const Changes>(Changes{{state_->selected, after.selected},
                                                         {state_->hidden, after.hidden},
                                                         {state_->removed, after.removed}});
  memory_ += changes->memory();
  taken_.push_back({std::make_shared<const EditStep>(std::move(step)), std::move(changes)});
  ++done_;
  state_ = std::make_shared<const EditState>(std::move(after));
  for (; memory_ > most_bytes_; ++without_way_back_)
    memory_ -= std::exchange(taken_[without_way_back_].changes, nullptr)->memory();
}

void EditHistory::change_state(const Changes& changes) {
  EditState state = *state_;
  changes.selected.apply(state.selected);
  changes.hidden.apply(state.hidden);
  changes.removed.apply(state.removed);
  state_ = std::make_shared<const EditState>(std::move(state));
}

void EditHistory::undo() {
  if (can_undo()) change_state(*taken_[--done_].changes);
}

void EditHistory::redo() {
  if (can_redo()) change_state(*taken_[done_++].changes);
}

}  // namespace qs
