// SPDX-License-Identifier: MIT
#include "app/viewer/state/train_form.h"

#include <iomanip>
#include <sstream>

#include <fmt/format.h>

#include "learn/run/settings.h"
#include "learn/run/strategy.h"

namespace qs {

std::string usual_model(const std::string& data) {
  const std::filesystem::path path = std::filesystem::path(data).lexically_normal();
  return (path.has_filename() ? path : path.parent_path()).string() + "_model";
}

std::vector<std::string> words_of(const std::string& line) {
  std::vector<std::string> words;
  std::istringstream text(line);
  while (!(text >> std::ws).eof()) {
    std::string word;
    text >> std::quoted(word);  // a quote without end lasts to the end of the line
    words.push_back(std::move(word));
  }
  return words;
}

TrainingRequest request_of(const TrainForm& form) {
  TrainingRequest request{form.data, form.model.empty() ? usual_model(form.data) : form.model, {}};
  std::vector<std::string>& options = request.options;
  const auto add = [&](const char* name, const char* value) {
    if (value != nullptr) options.insert(options.end(), {name, value});
  };
  if (form.iterations != kTrainIterations)
    options.insert(options.end(), {"--iterations", fmt::format("{}", form.iterations)});
  add("--resolution-scale", kTrainSizes[form.size].value);
  const char* const strategy = train::strategies()[form.strategy].name;
  add("--strategy", strategy == train::TrainSettings{}.strategy ? nullptr : strategy);
  for (std::string& word : words_of(form.more)) options.push_back(std::move(word));
  return request;
}

}  // namespace qs
