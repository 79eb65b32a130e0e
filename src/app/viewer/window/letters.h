// SPDX-License-Identifier: MIT
//
// Letters of names that the window's font may lack, as Chinese ones, and a font of the system that
// has them. Dear ImGui before 1.92 draws only letters that were put into its texture before.
#pragma once

#include <filesystem>
#include <optional>
#include <set>
#include <string>

#include <imgui.h>

#include "app/viewer/panels/file_chooser.h"
#include "app/viewer/state/viewer.h"

namespace qs {

using Letters = std::set<ImWchar>;

/// Adds the letters of a UTF-8 text that are not Latin. True if `letters` lacked one.
bool add_letters(Letters& letters, const std::string& text);

/// Adds the letters of all names that the window may show: of files and cameras, in messages.
bool add_shown_letters(Letters& letters, const Viewer& viewer, const FileChooser& chooser);

/// For ImFontAtlas: Latin-1, dashes, the ellipsis, the minus sign, and these letters.
ImVector<ImWchar> glyph_ranges(const Letters& letters);

struct SystemFont {
  std::filesystem::path file;
  int index = 0;  ///< in a collection
};

/// The font that fontconfig's program fc-match names for these letters. Empty without it.
std::optional<SystemFont> system_font(const Letters& letters);

}  // namespace qs
