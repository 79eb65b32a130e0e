// SPDX-License-Identifier: MIT
// The frame; beside a second frame of the same view; or with a map: the map's colours with the frame's
// detail, as in pictures of `quadsplat render --heatmap`.
#version 330 core
uniform sampler2D picture;   // with mipmaps while a map is shown
uniform sampler2D other;
uniform bool cubic;          // the frame is enlarged by cubic interpolation, else by linear
uniform int split;           // 0: no second frame; 1 + SplitView
uniform bool flipped;        // the second frame is on the left, or shown alone
uniform float divider;       // share of the width left of it
uniform float amplification; // of the difference
uniform sampler2D heat;      // values, one texel a cell
uniform sampler2D other_heat; // the same of the second frame
uniform float opacity;       // of the map over the picture
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

// Catmull-Rom's cubic interpolation of 4 x 4 texels by 5 linear lookups: the two middle rows and
// columns of a lookup's texels are one lookup between them, and the corners, which weigh less than
// 0.5 % each, are left out.
vec3 enlarged(sampler2D image, vec2 place) {
  vec2 size = vec2(textureSize(image, 0));
  vec2 texel = floor(place * size - 0.5) + 0.5;  // centre of the texel left above
  vec2 f = place * size - texel;
  vec2 w0 = f * (f * (1.0 - 0.5 * f) - 0.5);
  vec2 w2 = f * (0.5 + f * (2.0 - 1.5 * f));
  vec2 w3 = f * f * (0.5 * f - 0.5);
  vec2 middle = 1.0 - w0 - w3;
  vec2 before = (texel - 1.0) / size, between = (texel + w2 / middle) / size,
       after = (texel + 2.0) / size;
  vec3 sum = middle.x * middle.y * texture(image, between).rgb +
             w0.x * middle.y * texture(image, vec2(before.x, between.y)).rgb +
             w3.x * middle.y * texture(image, vec2(after.x, between.y)).rgb +
             middle.x * w0.y * texture(image, vec2(between.x, before.y)).rgb +
             middle.x * w3.y * texture(image, vec2(between.x, after.y)).rgb;
  float corners = (w0.x + w3.x) * (w0.y + w3.y);
  return clamp(sum / (1.0 - corners), 0.0, 1.0);
}

vec3 color_of(sampler2D image) {
  return cubic ? enlarged(image, at) : texture(image, at).rgb;
}

void main() {
  vec3 rgb = color_of(picture);
  vec3 beside = split == 0 ? vec3(0.0) : color_of(other);
  bool right = split == kSides && at.x >= divider;
  bool second = (split == kSides || split == kWhole) && right != flipped;
  if (split == kDifference) rgb = amplification * abs(rgb - beside);
  if (second) rgb = beside;
  if (heat_high > heat_low) {
    ivec2 cell = ivec2(at * heat_cells);
    float value = second ? texelFetch(other_heat, cell, 0).r : texelFetch(heat, cell, 0).r;
    float light = gray(rgb);
    vec3 around = second ? textureLod(other, at, kTileLevel).rgb
                         : textureLod(picture, at, kTileLevel).rgb;
    float place = clamp((value - heat_low) / (heat_high - heat_low), 0.0, 1.0);
    vec3 map = (1.0 + kDetail * (light - gray(around))) * texture(colors, place).rgb;
    if (heat_low == 0.0 && value == 0.0) map = vec3(0.05 + 0.08 * light);  // heat_of_zero()
    rgb = mix(rgb, map, opacity);
  }
  color = vec4(rgb, 1.0);
}
