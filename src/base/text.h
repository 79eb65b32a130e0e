// SPDX-License-Identifier: MIT
//
// Converts words of the command line to values, and values to text. Every error message quotes the
// word; numbers are plain decimals in every locale.
#pragma once

#include <cstdint>
#include <initializer_list>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

namespace qs {

/// These throw Error(usage) "WHAT: 'TEXT' is not ..."; `what` is the option's name.
int parse_integer(std::string_view what, std::string_view text, int low, int high);
double parse_real(std::string_view what, std::string_view text, double low, double high);
/// A number of bytes. K, M, G and T, or KB, MB, GB and TB, are powers of 1,000; KiB, MiB, GiB and
/// TiB are powers of 1,024.
std::uint64_t parse_bytes(std::string_view what, std::string_view text);
/// Two numbers with an x between them; a message calls them `shape`.
glm::ivec2 parse_size(std::string_view what, std::string_view text,
                      std::string_view shape = "WIDTHxHEIGHT");
glm::vec3 parse_color(std::string_view what, std::string_view text);  ///< R,G,B, each 0..1
/// A unit vector: an axis (x, -x, y, -y, z, -z) or X,Y,Z.
glm::dvec3 parse_direction(std::string_view what, std::string_view text);

/// Appends the word unless the list has it.
void add_new(std::vector<std::string>& list, const std::string& word);

/// "a", "b" -> "a, b".
std::string joined(std::span<const std::string> words, std::string_view separator);

/// "a,b" -> "a", "b". An empty text gives one empty word.
std::vector<std::string> separated(std::string_view text, char separator = ',');

/// A character and the text that replaces it.
using Escape = std::pair<char, std::string_view>;
/// The text with these characters replaced.
std::string escaped(std::string_view text, std::initializer_list<Escape> escapes);

/// A cell of a CSV file, quoted if it contains a comma, a quote or a line break.
std::string csv_field(const std::string& text);

/// The text in a line or a table's cell of Markdown: a bar, a backslash and < are escaped, and a
/// line break is a space.
std::string markdown_text(const std::string& text);

/// The text as code in a table's cell of Markdown: in backticks, with bars escaped. Backticks in it
/// become '.
std::string markdown_code(const std::string& text);

/// A word for a POSIX shell, in single quotes unless the shell reads it unchanged.
std::string shell_word(const std::string& word);

/// 1796342 -> "1,796,342".
std::string grouped(std::uint64_t number);

/// "1 Gaussian", "34,321 Gaussians".
std::string counted(std::uint64_t number, std::string_view thing);

/// 18039653 -> "18.0 MB".
std::string bytes_text(std::uint64_t bytes);

/// dB with two decimals; "inf" for infinity, the PSNR of equal pictures.
std::string decibels(double psnr);

/// Escapes <, >, & and double quotes, for HTML and SVG.
std::string html_escaped(const std::string& text);

}  // namespace qs
