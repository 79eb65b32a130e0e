// SPDX-License-Identifier: MIT
//
// The fields of the dialog Train, and the training run that they describe.
#pragma once

#include <iterator>
#include <string>
#include <vector>

#include "app/viewer/state/training.h"

namespace qs {

/// A choice of TrainForm: its words in the dialog, and the value of the option; null: none is
/// given.
struct TrainChoice {
  const char *words, *value;
};

/// --resolution-scale.
inline constexpr TrainChoice kTrainSizes[] = {{"at most 1600 pixels wide", nullptr},
                                              {"full size", "1"},
                                              {"1/2", "2"},
                                              {"1/4", "4"},
                                              {"1/8", "8"}};

inline constexpr int kTrainIterations = 30000;  ///< the default of `train`

struct TrainForm {
  std::string data, model;  ///< folders; an empty `model`: usual_model()
  int iterations = kTrainIterations;
  std::size_t size = 0, strategy = 0;  ///< indices into kTrainSizes and train::strategies()
  std::string more;                    ///< further options, as on the command line
  bool operator==(const TrainForm&) const = default;
};

/// "garden/" -> "garden_model"
std::string usual_model(const std::string& data);

/// The words of a command line: blanks separate them, except in double quotes. In quotes \\ keeps
/// the next character.
std::vector<std::string> words_of(const std::string& line);

/// Options are given only where a field is not the default of `train`.
TrainingRequest request_of(const TrainForm& form);

}  // namespace qs
