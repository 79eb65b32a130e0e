// SPDX-License-Identifier: MIT
#include "app/viewer/state/edit_actions.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "app/viewer/state/actions.h"
#include "app/viewer/state/measure_actions.h"
#include "app/viewer/state/training_actions.h"
#include "base/path_kind.h"
#include "base/text.h"

namespace qs {
namespace {

// A set that the render thread can hold; the old one if it is equal, null if it is empty.
std::shared_ptr<const GaussianSet> shared_set(const std::shared_ptr<const GaussianSet>& old,
                                              GaussianSet set) {
  if (set.empty()) return nullptr;
  return old && *old == set ? old : std::make_shared<const GaussianSet>(std::move(set));
}

// True if the steps can leave Gaussians selected.
bool can_select(const std::vector<EditStep>& steps) {
  const auto last = std::find_if(steps.rbegin(), steps.rend(), [](const EditStep& step) {
    return step.kind == EditKind::select || step.kind == EditKind::hide ||
           step.kind == EditKind::remove || step.kind == EditKind::keep;
  });
  return last != steps.rend() && last->kind == EditKind::select &&
         last->select.tool != SelectTool::none;
}

void take_state(Viewer& v) {
  Editing& editing = v.editing;
  const EditState& state = editing.history.state();
  editing.gone = shared_set(editing.gone, state.rest().complement());
  editing.selected = shared_set(editing.selected, GaussianSet(state.selected));
  editing.pages = nullptr;
  if (v.scene && v.scene->nodes > 0 && editing.history.has_steps()) {
    editing.pages = std::make_shared<const std::vector<EditStep>>(editing.history.steps());
    if (can_select(*editing.pages)) editing.selected = std::make_shared<const GaussianSet>();
  }
  editing.steps = editing.gone || editing.pages ? editing.history.count(takes_away) : 0;
  editing.saved = editing.kept = false;
  editing.changed = v.now;
}

std::string sentence_about(const EditStep& step, const EditState& before, const EditState& after) {
  if (after.removed.size() == 0)
    return fmt::format("{} on all pages of the tree", step.kind == EditKind::select ? "selected"
                                                      : step.kind == EditKind::hide ? "hidden"
                                                      : step.kind == EditKind::show ? "shown again"
                                                                                    : "removed");
  const std::size_t left = after.rest().count(), all = before.rest().count();
  const std::string of = fmt::format(" of {} ", counted(all, "Gaussian"));
  if (step.kind == EditKind::select) {
    const std::size_t count = after.selected.count();
    return count > 0 ? grouped(count) + of + "selected; Delete removes them"
                     : std::string("no Gaussian is selected");
  }
  if (step.kind == EditKind::show)
    return fmt::format("{} shown again", counted(left - all, "Gaussian"));
  return grouped(all - left) + of + (step.kind == EditKind::hide ? "hidden" : "removed");
}

}  // namespace

std::vector<EditStep> steps_of(const Viewer& v) {
  std::vector<EditStep> steps = v.editing.history.steps();
  steps.insert(steps.end(), v.editing.waiting.begin(), v.editing.waiting.end());
  return steps;
}

std::string edits_text(const Viewer& v) {
  if (v.editing.pages) return counted(v.editing.pages->size(), "step") + " on all pages";
  if (!v.editing.gone) return {};
  const EditState& state = v.editing.history.state();
  const std::size_t all = state.removed.size(), gone = v.editing.gone->count();
  const std::size_t hidden = state.hidden.count();
  std::vector<std::string> parts;
  if (gone > hidden) parts.push_back(grouped(gone - hidden) + " removed");
  if (hidden > 0) parts.push_back(grouped(hidden) + " hidden");
  return fmt::format("{} of {} are left: {}", grouped(all - gone), counted(all, "Gaussian"),
                     joined(parts, ", "));
}

std::filesystem::path kept_edits_file(const std::filesystem::path& scene) {
  return scene.string() + ".edits.json";
}

bool edits_are_to_keep(const Viewer& v) {
  return !v.editing.kept && v.editing.keeps && v.keeps_work && !v.is_remote;
}

namespace action {

void edit(Viewer& v, const EditStep& step) {
  if (!v.scene) return;
  if (is_training(v)) return notify(v, "the model is being trained: stop that run before editing");
  v.editing.waiting.push_back(step);
}

void edit_selected(Viewer& v, EditKind kind) {
  if (kind != EditKind::show && !v.editing.selected && v.editing.waiting.empty() && !v.editing.busy)
    return notify(v, "select Gaussians first (Shift+B)");
  edit(v, {.kind = kind});
}

void step_back(Viewer& v, bool back) {
  Editing& editing = v.editing;
  if (back && v.measures.picks && v.measures.points() > 0) return remove_last_point(v);
  const auto& keyframes = back ? v.keyframe_history.earlier : v.keyframe_history.later;
  const bool can = back ? editing.history.can_undo() : editing.history.can_redo();
  if (!can || (!keyframes.empty() && v.keyframe_history.changed > editing.changed))
    return step_keyframes(v, back);
  if (editing.busy || !editing.waiting.empty()) return;  // of a state that is not known yet
  back ? editing.history.undo() : editing.history.redo();
  take_state(v);
  v.crop.wish.boxed = v.crop.wish.cleans = false;
  const std::string text = edits_text(v);
  notify(v, text.empty() ? "the whole scene again" : text);
}

void step_done(Viewer& v, const EditStep& step, const std::shared_ptr<const EditState>& after) {
  Editing& editing = v.editing;
  if (!std::exchange(editing.busy, false) || !v.scene) return;  // another scene was opened
  const EditState& before = editing.history.state().removed.size() == after->removed.size()
                                ? editing.history.state()
                                : EditState(after->removed.size());
  const std::string sentence = sentence_about(step, before, *after);
  const bool knows_all = after->removed.size() > 0;
  if (knows_all && after->rest().empty()) {
    editing.waiting.clear();
    return notify_error(v, sentence + ": the scene would be empty, so nothing is done");
  }
  if (step.kind == EditKind::crop) v.crop.wish.boxed = false;
  if (step.kind == EditKind::floaters) v.crop.wish.cleans = false;
  if (step.kind == EditKind::select && !(knows_all && after->selected.empty()))
    v.panels.crop = true;  // which shows it
  const bool changes = !knows_all || *after != before;
  if (changes) {
    editing.history.take(step, *after);
    take_state(v);
  }
  notify(v, changes || step.kind == EditKind::select ? sentence : std::string("nothing would go"));
}

void step_failed(Viewer& v, const std::string& sentence) {
  v.editing.busy = false;
  v.editing.waiting.clear();
  notify_error(v, sentence);
}

void edits_saved(Viewer& v) { v.editing.saved = true; }

void offer_edits(Viewer& v) {
  if (v.is_remote || !v.keeps_work || v.scene->edits.steps > 0) return;
  const std::filesystem::path file = kept_edits_file(v.scene->path);
  if (!is_there(file)) return;
  notify(v, file.filename().string() +
                " has edits of this scene. Another edit renames this file and begins a new one.");
  constexpr double kOfferSeconds = 60;
  v.toasts.back().offer = ToastOffer::apply_edits;
  v.toasts.back().until = v.now + kOfferSeconds;
}

void edits_opened(Viewer& v, const std::filesystem::path& file, const EditHistory& history) {
  if (!std::exchange(v.editing.busy, false) || !v.scene) return;  // another scene was opened
  if (history.state().removed.size() > 0 && history.state().rest().empty())
    return notify_error(v, file.string() + ": no Gaussian would be left");
  v.editing.history = history;
  take_state(v);
  v.editing.owns_file = file == kept_edits_file(v.scene->path);
  v.editing.kept = v.editing.owns_file;
  v.editing.saved = true;
  const std::string text = edits_text(v);
  notify(v, fmt::format("{}: {}{}", file.filename().string(),
                        counted(history.steps().size(), "step"), text.empty() ? "" : "; " + text));
}

void edits_kept(Viewer& v, const std::string& problem) {
  v.editing.owns_file = v.editing.keeps = problem.empty();
  if (!problem.empty()) notify_error(v, problem + "; Ctrl+S saves the edits elsewhere");
}

}  // namespace action
}  // namespace qs
