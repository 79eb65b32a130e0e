// SPDX-License-Identifier: MIT
// The frame; beside another one of the same view; or with a map: the map's colours with the frame's
// detail, as pictures of `quadsplat render --heatmap` have it.
#version 330 core
uniform sampler2D picture;   // with mipmaps while a map is shown
uniform sampler2D other;
uniform int split;           // 0: there is no other one; 1 + SplitView
uniform bool flipped;        // the other one is the left one, or the one at a time
uniform float divider;       // share of the width left of it
uniform float amplification; // of the difference
uniform sampler2D heat;      // values, one texel a cell
uniform sampler1D colors;    // colour map
uniform float heat_low;      // the scale's ends; equal: no map
uniform float heat_high;
uniform vec2 heat_cells;     // cells across the picture, parts of a cell counted
in vec2 at;
out vec4 color;

const int kSides = 1, kWhole = 2, kDifference = 3;
const float kDetail = 0.5;    // as with_detail() in picture/colormap.cpp
const float kTileLevel = 4.0; // mipmap level whose texels are 16 x 16 pixels

float gray(vec3 rgb) { return dot(rgb, vec3(0.299, 0.587, 0.114)); }

void main() {
  vec3 rgb = texture(picture, at).rgb;
  vec3 beside = texture(other, at).rgb;
  bool second = split == kSides && at.x >= divider;
  if (split == kDifference) rgb = amplification * abs(rgb - beside);
  if ((split == kSides || split == kWhole) && second != flipped) rgb = beside;
  if (heat_high > heat_low) {
    float value = texelFetch(heat, ivec2(at * heat_cells), 0).r;
    float light = gray(rgb);
    float detail = light - gray(textureLod(picture, at, kTileLevel).rgb);
    float place = clamp((value - heat_low) / (heat_high - heat_low), 0.0, 1.0);
    rgb = (1.0 + kDetail * detail) * texture(colors, place).rgb;
    if (heat_low == 0.0 && value == 0.0) rgb = vec3(0.05 + 0.08 * light);  // heat_of_zero()
  }
  color = vec4(rgb, 1.0);
}
