// SPDX-License-Identifier: MIT
//
// The verdict as text, JSON and a page with pictures.
#pragma once

#include <string>

#include "app/conformance/judge.h"

namespace qs {

/// A line per scene, the totals and the cause.
std::string format_verdict(const KitVerdict& judgement);

/// {"scenes": [{name, result, psnr, largest_difference, causes}, ...], "passed": 27, ...}
std::string verdict_json(const KitVerdict& judgement);

/// An HTML page: for every scene the truth, the picture, their difference with a colour bar from 0
/// to 32, and the picture of the mistakes that explain it. `name` is the renderer's name.
std::string verdict_page(const KitVerdict& judgement, const Submission& submission,
                         const std::string& name);

/// Sentences about the causes: names, descriptions, and the number of scenes that they explain.
std::string cause_text(const KitVerdict& judgement);

/// "a + b or c"; without causes "no known mistake explains it; closest: d, 41.20 dB".
std::string causes_text(const SceneVerdict& verdict);

}  // namespace qs
