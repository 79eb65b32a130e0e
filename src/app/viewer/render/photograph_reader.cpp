// SPDX-License-Identifier: MIT
#include "app/viewer/render/photograph_reader.h"

#include "app/session/photographs.h"
#include "app/viewer/state/actions.h"

namespace qs {

void PhotographReader::read(const std::filesystem::path& path) {
  ++reading_;
  thread_ = std::jthread([this, path] {
    try {
      ThreadPool pool(1);
      ShownPhotograph photograph{
          path, std::make_shared<Image>(read_photograph(path, glm::vec3(0), 1, pool))};
      reports_.report(action::photograph_opened, std::move(photograph));
    } catch (const std::exception& error) {
      reports_.report(action::notify_error, std::string(error.what()));
    }
    --reading_;
  });
}

}  // namespace qs
