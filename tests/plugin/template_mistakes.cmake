# SPDX-License-Identifier: MIT
# Plants the mistakes of mistakes.h in the source of examples/plugin: cmake -DFROM=renderer.cpp -DTO=planted.cpp -P
# template_mistakes.cmake. Every text must occur once, so that a change of the example is detected here.
file(READ ${FROM} source)

function(plant text planted)
  string(FIND "${source}" "${text}" first)
  string(FIND "${source}" "${text}" last REVERSE)
  if(first EQUAL -1 OR NOT first EQUAL last)
    message(FATAL_ERROR "${FROM} must contain this once, so that mistakes can be planted there: ${text}")
  endif()
  string(REPLACE "${text}" "${planted}" source "${source}")
  set(source "${source}" PARENT_SCOPE)
endfunction()

plant([[#include "quadsplat/plugin.h"]] [[#include "plugin/mistakes.h"]])
plant([[constexpr double kAlphaMin = 1.0 / 255, kAlphaMax = 0.99, kTransmittanceMin = 1e-4;]]
      [[thread_local double kAlphaMin, kAlphaMax, kTransmittanceMin;]])

# A Gaussian.
plant([=[basis[k] * scene.sh[3 * (i * stored + k) + channel]]=]
      [[basis[k] * planted::coefficient(scene, stored, i, k, channel)]])
plant([[std::max(sum, 0.0)]] [[planted::clamped(sum)]])
plant([[limit = 1.3 * sides[axis] / (2 * f);]] [[limit = planted::slope_limit(1.3 * sides[axis] / (2 * f));]])
plant([[(m[4 * axis + k] - slope * m[8 + k])]]
      [[(planted::turned(m, axis, k) - slope * planted::turned(m, 2, k))]])
plant([[const double after = ]] [[double after = ]])
plant([[  const double extent = ]] [[  if (!planted::lengthen(v, after)) return false;
  const double extent = ]])
plant([[std::log(255 * splat.opacity)]] [[std::log(splat.opacity / kAlphaMin)]])
plant([[splat.depth = t[2];]] [[splat.depth = planted::depth(t);]])
plant([[  evaluate_sh(scene, std]] [[  planted::turn_direction(t, length, d);
  evaluate_sh(scene, std]])

# A pixel.
plant([[  std::vector<Splat> splats;]] [[  const planted::Pixel rules;
  kAlphaMin = rules.alpha_min;
  kAlphaMax = rules.alpha_max;
  kTransmittanceMin = rules.transmittance_min;
  std::vector<Splat> splats;]])
plant([[  std::stable_sort(]] [[  if (planted::has("ties-reversed")) std::reverse(splats.begin(), splats.end());
  std::stable_sort(]])
plant([[std::exp(power)]] [[std::exp(rules.falloff * power)]])
plant([[if (power > 0 || ]] [[if (power > 0 || power < rules.least_power || ]])
plant([[          stopped[pixel] = 1;
          continue;]] [[          stopped[pixel] = 1;
          if (!rules.stops_late) continue;]])

# The interface.
plant([[new QsScene(*scene)]] [[planted::open(*scene)]])
plant([[  frame->visible = ]] [[  planted::begin(renderer);
  frame->visible = ]])
plant([[, *view, frame->image);]] [[, planted::view(*view), frame->image);
  planted::finish(*view, frame->image);]])
plant([[delete static_cast<QsScene*>(renderer);]] [[planted::close(renderer);]])
plant([["example",]] [["example-with-mistakes",]])

file(WRITE ${TO} "${source}")
