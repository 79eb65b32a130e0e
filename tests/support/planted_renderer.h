// SPDX-License-Identifier: MIT
//
// A second implementation of 3DGS in single precision, written for tests of the conformance kit. It
// reads the kit's files itself, shares no code with the program, and makes mistakes on request.
// It is separate from app/conformance/mistakes.cpp, because the judge must recognise the mistakes
// of a renderer that knows only the kit's files.
#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "raster/scene/image.h"

namespace qs::test {

/// A scene of the kit as its files describe it.
struct PlantedScene {
  int width = 0, height = 0, sh_degree = 0;
  float fx = 0, fy = 0;
  float rotation[3][3] = {}, translation[3] = {};  ///< view from world
  float background[3] = {};
  bool antialiased = false;
  std::vector<std::vector<float>> rows;        ///< per Gaussian: the values of the .ply
  std::map<std::string, std::size_t> columns;  ///< index of a value by its name
};

/// `entry` is an element of "scenes" in kit.json.
PlantedScene read_planted(const std::filesystem::path& kit, const nlohmann::json& entry);

/// `bugs` are names of mistakes, see docs/conformance.md.
Image draw_planted(const PlantedScene& scene, const std::set<std::string>& bugs);

}  // namespace qs::test
