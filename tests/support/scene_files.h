// SPDX-License-Identifier: MIT
//
// read_scene() and write_scene() with a thread pool of their own, for tests in which the number of
// threads does not matter.
#pragma once

#include "io/scene/reader.h"
#include "io/scene/writer.h"

namespace qs::test {

Scene read_scene(const std::filesystem::path& path, const ReadOptions& options = {});
const WriterRow& write_scene(const GaussianCloud& cloud, const std::filesystem::path& path,
                             const Progress& progress = {}, std::string_view format = {});

}  // namespace qs::test
