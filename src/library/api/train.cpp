// SPDX-License-Identifier: MIT
//
// Training: the program's trainer with the options of its table.
#include <algorithm>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "io/bytes/file_guard.h"
#include "learn/run/train_options.h"
#include "learn/run/trainer.h"
#include "learn/step/training_model.h"
#include "library/check/context.h"
#include "library/check/structs.h"
#include "options/suggestion.h"

using namespace qs::library;

namespace {

const Where kTraining{"qs_train", "training"};

/// "--sh-degree" for "sh_degree" and "--sh-degree".
std::string full_name(std::string_view name) {
  std::string full = name.starts_with("--") ? std::string(name) : "--" + std::string(name);
  std::ranges::replace(full, '_', '-');
  return full;
}

/// Throws Error(usage) if the options of the table do not have this name.
const Option& find_option(const OptionTable& table, const Where& where, const std::string& name) {
  std::vector<std::string> names;
  for (const Option& option : table.table()) {
    if (option.positional() || option.name == train::kModelOption) continue;
    if (option.name == name) return option;
    names.push_back(option.name);
  }
  for (const char* of_context : {"--backend", "--device", "--threads"})
    if (name == of_context) refuse(where, "{} belongs to the context", name);
  refuse(where, "there is no option '{}'{}", name, suggestion(name, names));
}

void accept(const Option& option, const Where& where, const char* value) {
  const std::string given = value == nullptr ? "" : value;
  if (option.most != 0) {
    if (value == nullptr) refuse(where, "{} needs a value", option.name);
    option.accept({given});
  } else if (value == nullptr || given == "on") {
    option.accept({});
  } else if (given != "off") {
    refuse(where, "{}: '{}' is none of on, off", option.name, given);
  }
}

void accept_options(const OptionTable& table, const QsTraining& training) {
  const auto accept_named = [&](const char* name, const char* value) {
    const auto row = std::find_if(table.table().begin(), table.table().end(),
                                  [&](const Option& option) { return option.name == name; });
    row->accept({value});
  };
  accept_named(train::kDataOption, training.data);
  accept_named(train::kModelOption, training.model);
  if (training.option_count > 0) require(training.options, kTraining / "options");
  for (std::uint64_t i = 0; i < training.option_count; ++i) {
    const QsOption& given = training.options[i];
    Where where{"qs_train", "training.options", static_cast<std::int64_t>(i)};
    require_text(given.name, where / "name");
    accept(find_option(table, where, full_name(given.name)), where, given.value);
  }
}

QsTrainingState state_of(const train::RunStatus& status) {
  QsTrainingState state{};
  state.size = sizeof(state);
  state.iteration = status.trainer.iteration();
  state.iterations = status.trainer.last_iteration();
  state.gaussians = status.trainer.gaussians();
  state.loss = status.loss;
  state.seconds = status.log.seconds;
  state.test_psnr = state.test_ssim = state.guard_psnr = std::numeric_limits<double>::quiet_NaN();
  const train::Guard& guard = status.trainer.guard();
  if (!guard.rows().empty()) {
    state.guard_psnr = guard.rows().back().reserved;
    state.guarded = guard.rows().back().iteration;
    state.growth_ended = guard.stopped_after();
  }
  const auto& rows = status.log.rows;
  const auto last = std::find_if(rows.rbegin(), rows.rend(),
                                 [](const train::LogRow& row) { return row.test.has_value(); });
  if (last == rows.rend()) return state;
  state.evaluated = last->iteration;
  state.test_psnr = last->test->psnr;
  state.test_ssim = last->test->ssim;
  return state;
}

/// The sentences go to the caller, if it wants them.
train::RunText text_of(const QsTraining& training) {
  const train::RunText::Say say = [text = training.text,
                                   user = training.user](const std::string& sentence) {
    if (text != nullptr) text(user, sentence.c_str());
  };
  return {say, say, say, false};
}

}  // namespace

int32_t qs_train(QsContext* context, const QsTraining* training, QsTrainingState* state,
                 char* message) {
  return library::call(__func__, message, "context", context, [&](const char* function) {
    const QsTraining given = read_struct(training, kTraining);
    if (given.reserved != 0) refuse(kTraining / "reserved", "is not 0");
    require_text(given.data, kTraining / "data");
    require_text(given.model, kTraining / "model");
    if (state != nullptr) checked_size(state, {function, "state"});
    train::TrainOptions options;
    OptionTable table;
    train::declare_train_options(table, options);
    accept_options(table, given);

    const Use use(*context->context, {function, "context"});
    const FileGuard guard(options.run.overwrite, "--overwrite", GuardScope::thread);
    QsTrainingState last{};
    options.run.text = text_of(given);
    options.run.stop = use.stop();
    options.run.watch = [&](const train::RunStatus& status) {
      last = state_of(status);
      const bool ends = given.progress != nullptr && given.progress(given.user, &last) != 0;
      return ends || use.stop().stop_requested() ? TrainingCommand::stop : TrainingCommand::go_on;
    };
    auto [model, data] = train::prepare(options, context->context->backend(),
                                        context->context->device(), use.pool(), {{}, use.stop()});
    const train::RunEnd end =
        train::run_training(options.settings, data, options.run, std::move(model), use.pool());
    if (state != nullptr) write_struct(last, state, {function, "state"});
    if (end == train::RunEnd::interrupted) throw Cancelled{};
  });
}
