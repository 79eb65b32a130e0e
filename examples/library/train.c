/* SPDX-License-Identifier: MIT
 * Trains a model from a data set of photographs, until the loss is small: train_c DATA MODEL */
#include <quadsplat/quadsplat.h>
#include <stdio.h>

/* Ends the run when the loss is small. */
static int32_t progress(void* user, const QsTrainingState* state) {
  (void)user;
  if (state->iteration % 100 == 0) printf("%d: loss %.4f\n", state->iteration, state->loss);
  return state->iteration > 0 && state->loss < 0.01;
}

int main(int argc, char** argv) {
  char message[QS_MESSAGE_BYTES];
  QsContext* context;
  QsOption options[] = {{"iterations", "7000"}, {"strategy", "mcmc"}, {"final-prunes", "on"}};
  QsTraining training = {sizeof(training)};
  int32_t code = QS_USAGE;
  if (argc != 3) return code;
  training.data = argv[1];
  training.model = argv[2];
  training.options = options;
  training.option_count = sizeof(options) / sizeof(*options);
  training.progress = progress;
  if ((code = qs_context_open(QS_BACKEND_AUTO, QS_FIRST_GPU, 0, &context, message)) == QS_OK) {
    code = qs_train(context, &training, NULL, message);
    qs_context_close(context);
  }
  if (code != QS_OK) fprintf(stderr, "%s\n", message);
  return code;
}
