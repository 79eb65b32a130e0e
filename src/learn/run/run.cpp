// SPDX-License-Identifier: MIT
#include "learn/run/run.h"

#include <chrono>
#include <exception>
#include <memory>
#include <new>
#include <utility>

#include "base/fail.h"
#include "base/progress_bar.h"
#include "base/quit_signals.h"
#include "base/seconds.h"
#include "base/text.h"
#include "io/bytes/file_guard.h"
#include "io/bytes/replace_file.h"
#include "learn/run/field_model.h"
#include "learn/run/initial.h"
#include "learn/run/model_folder.h"
#include "learn/run/train_log.h"
#include "learn/run/trainer.h"
#include "raster/scene/image_metrics.h"

namespace qs::train {
namespace {

constexpr int kLogInterval = 100;  // iterations per row of train.csv

using Clock = std::chrono::steady_clock;

bool due(int iteration, int every) { return every > 0 && iteration % every == 0; }

Checkpoint start(const TrainSettings& settings, const DataSet& data, const RunOptions& options,
                 ThreadPool& pool) {
  Checkpoint checkpoint{settings, data.fingerprint(), {}, {}};
  if (!options.resume) {
    Parameters initial =
        options.initial ? *options.initial : starting_gaussians(data, settings, pool);
    if (find_strategy(settings.strategy).has_masks) initial = with_masks(std::move(initial));
    checkpoint.model = ModelState::starting_with(std::move(initial));
    if (settings.color_field) checkpoint.model.color_field = starting_field(settings.seed);
    return checkpoint;
  }
  const auto path = checkpoint_path(options.out_dir);
  Checkpoint saved = read_checkpoint(path);
  if (const std::string names = differences_of(settings, saved.settings); !names.empty())
    fail(ErrorKind::usage, "--resume: {}: the run was started with other settings: {}",
         path.string(), names);
  if (saved.data != checkpoint.data)
    fail("{}: the run was started with other photographs, sizes or cameras ({}, now {})",
         path.string(), saved.data, checkpoint.data);
  saved.settings = settings;
  return saved;
}

// A later iteration of an earlier run would be opened in place of the new model.
void remove_earlier_iterations(const TrainSettings& settings, const RunOptions& options) {
  const RunText::Say& tell = options.text.note;
  const auto [removed, foreign] = remove_old_iterations(options.out_dir);
  if (!removed.empty())
    tell(fmt::format("removed {} saved iteration{} of an earlier run: {}", removed.size(),
                     removed.size() == 1 ? "" : "s", fmt::join(removed, ", ")));
  const int last = settings.given_pace().end();
  if (!foreign.empty() && foreign.back() > last)
    tell(fmt::format(
        "{}: iteration {} does not say that quadsplat trained it, so it stays: commands open it "
        "without --iteration {}",
        options.out_dir.string(), foreign.back(), last));
}

class Run {
 public:
  Run(const DataSet& data, const RunOptions& options, Checkpoint checkpoint,
      std::unique_ptr<TrainingModel> model, ThreadPool& pool)
      : data_(data),
        options_(options),
        text_(options.text),
        settings_(checkpoint.settings),
        fingerprint_(checkpoint.data),
        log_(std::move(checkpoint.log)),
        first_(model->iteration()),
        backend_(model->name()),
        trainer_(settings_, data, std::move(model), pool, log_.guard, log_.pace),
        control_(settings_.seconds, log_.seconds, first_),
        pool_(pool),
        keeps_best_(options.keep_best.value_or(keeps_best_by_default(data))),
        eval_every_(options.eval_every > 0 || !keeps_best_ ? options.eval_every
                                                           : evaluation_interval(data, backend_)) {}

  RunEnd all_iterations() {
    text_.result(fmt::format("training on {}", backend_));
    ProgressBar bar("training");
    bar.appear(text_.has_bars);
    const Progress progress = bar.progress();
    const Clock::time_point begin = Clock::now();
    bool stopped = !prepared() || !goes_on(0);
    try {
      while (trainer_.iteration() < trainer_.last_iteration() && !stopped && !quits()) {
        const StepResult step = trainer_.step();
        log_.add(step);
        note_guard_and_pace();
        const int iteration = trainer_.iteration();
        bar.relabel(fmt::format("loss {:.4f}, {:.1f} dB, {} Gaussians, {:.1f} it/s",
                                step.loss.total, psnr_of(step.loss.squared_error),
                                grouped(trainer_.gaussians()),
                                (iteration - first_) / seconds_since(begin)));
        progress.update(static_cast<float>(iteration - first_) /
                        static_cast<float>(trainer_.last_iteration() - first_));
        after(iteration, bar);
        stopped = iteration < trainer_.last_iteration() && !goes_on(step.loss.total);
      }
    } catch (const std::bad_alloc&) {
      fail_after_saving("not enough memory");
    } catch (const Error& error) {
      if (error.kind() != ErrorKind::device) throw;
      fail_after_saving(error.what());
    }
    bar.hide();
    const bool finished = trainer_.iteration() >= trainer_.last_iteration();
    if (finished && !is_evaluated()) evaluate();
    if (finished) goes_on(log_.rows.empty() ? 0 : log_.rows.back().loss);
    const auto file = save(finished && !options_.keep_checkpoint);
    if (options_.write_page) {
      const std::string problem = options_.write_page(options_.out_dir, settings_, log_);
      if (!problem.empty()) text_.warning(problem);
    }
    text_.result(fmt::format("wrote {}: {} Gaussians, {} iterations in {:.1f} s", file.string(),
                             grouped(trainer_.existing_gaussians()),
                             grouped(static_cast<std::uint64_t>(trainer_.iteration())),
                             log_.seconds));
    print_best();
    if (finished && !log_.verdict.empty()) text_.result("guard: " + log_.verdict);
    return finished ? RunEnd::finished : RunEnd::interrupted;
  }

 private:
  // Computes the resolution schedule. Returns false if the user stops the run meanwhile.
  bool prepared() try {
    ProgressBar bar("reading frequencies");
    bar.appear(text_.has_bars);
    const Progress shown = bar.progress();
    trainer_.prepare({[&](float fraction) {
                        if (quits() || !goes_on(0)) throw Cancelled{};
                        shown.update(fraction);
                      },
                      {}});
    return true;
  } catch (const Cancelled&) {
    return false;
  }

  bool quits() const { return QuitSignals::arrived() || options_.stop.stop_requested(); }

  // Carries out the watcher's request. Returns false if the run should stop.
  bool goes_on(double loss) {
    if (!options_.watch) return true;
    TrainingCommand command = TrainingCommand::go_on;
    while ((command = options_.watch({trainer_, log_, loss})) == TrainingCommand::save) save();
    return command != TrainingCommand::stop;
  }

  [[noreturn]] void fail_after_saving(const std::string& why) {
    bool saved = true;
    try {
      write_checkpoint(checkpoint(), checkpoint_path(options_.out_dir));
    } catch (const std::exception&) {
      saved = false;  // the first event is reported
    }
    fail(ErrorKind::device,
         "{}, for iteration {} with {} Gaussians{}; a smaller --max-gaussians needs less memory",
         why, trainer_.iteration() + 1, grouped(trainer_.gaussians()),
         saved ? fmt::format("; the run was saved in {} and continues with --resume",
                             options_.out_dir.string())
               : "");
  }

  CheckpointView checkpoint() const { return {settings_, fingerprint_, log_, trainer_.model()}; }

  void after(int iteration, ProgressBar& bar) {
    if (due(iteration, eval_every_)) {
      bar.hide();
      evaluate();
    } else if (due(iteration, kLogInterval) && iteration < trainer_.last_iteration()) {
      log_.close_row(trainer_, {});
    }
    if (due(iteration, options_.save_every) && iteration < trainer_.last_iteration()) save();
  }

  void note_guard_and_pace() {
    if (trainer_.guard().rows().size() != log_.guard.size()) {
      log_.guard = trainer_.guard().rows();
      log_.verdict = trainer_.guard().verdict();
    }
    if (settings_.seconds == 0) return;
    trainer_.correct_pace(log_.seconds, control_);
    if (trainer_.pace().rows().size() != log_.pace.size()) log_.pace = trainer_.pace().rows();
  }

  bool is_evaluated() const {
    return !log_.rows.empty() && log_.rows.back().iteration == trainer_.iteration() &&
           (log_.rows.back().test || data_.test.empty());
  }

  void evaluate() {
    ProgressBar bar("evaluating");
    bar.appear(text_.has_bars);
    const Clock::time_point begin = Clock::now();
    std::optional<Quality> quality;
    try {
      quality = trainer_.test_quality({bar.progress().report, options_.stop});
    } catch (const Cancelled&) {
      return;  // the run ends, and the next one may evaluate
    }
    log_.evaluation_seconds += seconds_since(begin);
    bar.hide();
    log_.close_row(trainer_, quality);
    if (!quality) return;
    text_.result(fmt::format(
        "iteration {}: PSNR {} dB, SSIM {:.4f} on {} test views, {} Gaussians, {:.1f} s",
        grouped(static_cast<std::uint64_t>(trainer_.iteration())), decibels(quality->psnr),
        quality->ssim, data_.test.size(), grouped(trainer_.gaussians()), log_.seconds));
    if (keeps_best_ && best_row(log_) == &log_.rows.back())
      write_gaussians(options_.out_dir, settings_, trainer_.model(), data_.origin, pool_);
  }

  void print_best() const {
    const LogRow* const best = best_row(log_);
    // Without --keep-best, an evaluation at the end that is the best needs no line.
    if (best != nullptr && keeps_best_ &&
        options_.keep_best.value_or(best->iteration != trainer_.iteration())) {
      text_.result(fmt::format("best on the test views: iteration {}, {} dB",
                               grouped(static_cast<std::uint64_t>(best->iteration)),
                               decibels(best->test->psnr)));
    }
    const std::string sentence = overfitting_sentence(log_, options_.out_dir);
    if (!sentence.empty()) text_.result(sentence);
  }

  // `last`: no run continues from here.
  std::filesystem::path save(bool last = false) const {
    return write_model_state(options_.out_dir, checkpoint(), data_, backend_, pool_, last);
  }

  const DataSet& data_;
  const RunOptions& options_;
  const RunText& text_;
  const TrainSettings settings_;
  const std::string fingerprint_;
  TrainLog log_;
  const int first_;  // iterations of earlier runs
  const std::string backend_;
  Trainer trainer_;
  PaceControl control_;
  ThreadPool& pool_;
  const bool keeps_best_;
  const int eval_every_;
};

}  // namespace

RunEnd run_training(const TrainSettings& settings, const DataSet& data, const RunOptions& options,
                    std::unique_ptr<TrainingModel> model, ThreadPool& pool) {
  make_folder(options.out_dir);
  const FolderLock lock = lock_model_folder(options.out_dir);
  if (!lock.held())
    options.text.warning(
        fmt::format("{}: its file system has no locks, so do not train into it twice at a time",
                    options.out_dir.string()));
  Checkpoint checkpoint = start(settings, data, options, pool);
  std::optional<QuitSignals> signals;
  if (!options.watch) signals.emplace();
  if (options.resume) {
    note_own(options.out_dir);
  } else if (options.overwrite) {
    remove_earlier_iterations(settings, options);
    remove_checkpoint(checkpoint_path(options.out_dir));
  }
  write_model_start(options.out_dir, settings, data);
  model->set_state(std::move(checkpoint.model));
  return Run(data, options, std::move(checkpoint), std::move(model), pool).all_iterations();
}

}  // namespace qs::train
