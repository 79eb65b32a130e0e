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

// True if the step has a list of its result; the list of a list tool is none.
bool has_list(const EditStep& step) {
  return step.select.members && step.select.tool != SelectTool::list;
}
std::size_t bytes_of_list(const EditStep& step) {
  return step.select.members->size() * sizeof(GaussianRun);
}
EditStep without_result(EditStep step) {
  step.select.members.reset();
  step.select.count.reset();
  step.select.crc.clear();
  return step;
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
  const auto memory_of = [](const Taken& taken) {
    return taken.changes->memory() + (has_list(*taken.step) ? bytes_of_list(*taken.step) : 0);
  };
  for (; taken_.size() > done_; taken_.pop_back()) memory_ -= memory_of(taken_.back());
  auto changes = std::make_shared<const Changes>(Changes{{state_->selected, after.selected},
                                                         {state_->hidden, after.hidden},
                                                         {state_->removed, after.removed}});
  taken_.push_back({std::make_shared<const EditStep>(std::move(step)), std::move(changes)});
  memory_ += memory_of(taken_[done_++]);
  state_ = std::make_shared<const EditState>(std::move(after));
  for (; memory_ > most_bytes_; ++without_way_back_) {
    Taken& oldest = taken_[without_way_back_];
    memory_ -= memory_of(oldest);
    oldest.changes = nullptr;
    if (has_list(*oldest.step))
      oldest.step = std::make_shared<const EditStep>(without_result(*oldest.step));
  }
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
