// SPDX-License-Identifier: MIT
#include "app/cli/format_list.h"

#include <fmt/format.h>

#include "io/scene/reader.h"
#include "io/scene/writer.h"

namespace qs {

std::string format_list() {
  std::string text =
      "| read | files | what | axes | SH degrees | limits |\n|---|---|---|---|---|---|\n";
  for (const ReaderRow& row : readers()) {
    text += fmt::format("| {} | `{}` | {} | {} | {} | {} |\n", row.name, row.extensions,
                        row.summary, row.axes, row.sh_degrees, row.limits);
  }
  text +=
      "\n| written | ending | what | axes | SH degrees | what is lost "
      "|\n|---|---|---|---|---|---|\n";
  for (const WriterRow& row : writers()) {
    text += fmt::format(
        "| {} | `{}` | {} | {} | {} | {} |\n", row.name, row.extension, row.summary, row.axes,
        row.max_sh_degree == 0 ? "0" : fmt::format("0-{}", row.max_sh_degree), row.losses);
  }
  return text;
}

}  // namespace qs
