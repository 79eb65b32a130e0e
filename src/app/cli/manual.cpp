// SPDX-License-Identifier: MIT

#include <set>
#include <vector>

#include <fmt/format.h>

#include "app/cli/command.h"
#include "io/scene/reader.h"
#include "io/scene/writer.h"
#include "version.h"

namespace qs {
namespace {

Options declared(const Command& command) {
  Options options(command.name, command.summary);
  command.declare(options);  // the action owns variables that only parsing fills
  return options;
}

// ---- the manual page ----------------------------------------------------------------------------

// Escapes text for roff, so that minus signs can be searched and copied, and no line is a request.
std::string roff(const std::string& text) {
  std::string result = escaped(text, {{'\\', "\\e"}, {'-', "\\-"}});
  if (result.starts_with('.') || result.starts_with('\'')) result.insert(0, "\\&");
  return result;
}

std::string entry(const std::string& term, const std::string& text) {
  return fmt::format(".TP\n.B {}\n{}\n", roff(term), roff(text));
}

std::string options_of(const Options& options, bool common) {
  std::string text;
  for (const Option& option : options.table())
    if (option.common == common) text += entry(option.shown(), option.help);
  return text;
}

constexpr const char* kExitCodes[][2] = {{"0", "success"},
                                         {"1", "wrong command line"},
                                         {"2", "bad input"},
                                         {"3", "no device or memory"},
                                         {"4", "a comparison failed"},
                                         {"130", "interrupted"}};

// ---- the completion -----------------------------------------------------------------------------

constexpr const char* kCompletion =
    R"(# bash completion of quadsplat, printed by quadsplat --bash-completion
_quadsplat() {{
  local cur=${{COMP_WORDS[COMP_CWORD]}} prev=${{COMP_WORDS[COMP_CWORD-1]}} command=view options= first=
  case ${{COMP_WORDS[1]}} in {}) command=${{COMP_WORDS[1]}} ;; esac
  case "$command $prev" in
{}  esac
  case $command in
{}  esac
  ((COMP_CWORD > 1)) || first='{} --help --version --list-gpus --list-formats'
  if [[ $cur == -* ]]; then
    COMPREPLY=($(compgen -W "$options --help $first" -- "$cur"))
  else
    COMPREPLY=($(compgen -W "$first" -- "$cur") $(compgen -f -- "$cur"))
  fi
}}
complete -o filenames -F _quadsplat quadsplat
)";

}  // namespace

std::string man_page() {
  std::string text = fmt::format(
      ".TH QUADSPLAT 1 \"\" \"quadsplat {}\" \"User Commands\"\n.SH NAME\n"
      "quadsplat \\- viewer and laboratory for 3D Gaussian Splatting\n.SH SYNOPSIS\n"
      ".B quadsplat\n[view] SCENE [options]\n.br\n.B quadsplat\nCOMMAND [options]\n"
      ".SH DESCRIPTION\nSCENE is a splat file or the folder of a trained model. Cameras are "
      "searched "
      "beside it.\n.SH COMMANDS\n",
      kVersion);
  std::string examples, common;
  for (const Command& command : commands()) {
    const Options options = declared(command);
    text += fmt::format(".SS quadsplat {} {}\nThis command {}.\n", command.name,
                        roff(options.usage()), roff(command.summary));
    text += options_of(options, false);
    if (common.empty()) common = options_of(options, true);
    for (const Options::Example& example : options.examples())
      examples += entry(example.command_line, example.what);
  }
  text += ".SH SCENE AND RENDERING\nCommands that render have these options too.\n" + common;
  text += ".SH OTHER OPTIONS\n" + entry("COMMAND --help", "options and examples of a command") +
          entry("--list-gpus", "the GPUs that can render, or why none can") +
          entry("--list-formats", "scene formats that are read and written") +
          entry("--version", "version, commit and build");
  text += ".SH EXIT STATUS\n";
  for (const auto& [code, meaning] : kExitCodes) text += entry(code, meaning);
  text += ".SH FILES\n" + entry("~/.config/quadsplat/viewer.json",
                                "settings, recent files and last views of the window");
  return text + ".SH EXAMPLES\n" + examples;
}

std::string bash_completion() {
  std::vector<std::string> names;
  std::string values, options_by_command;
  for (const Command& command : commands()) {
    names.emplace_back(command.name);
    std::vector<std::string> options;
    const Options table = declared(command);
    for (const Option& option : table.table()) {
      if (option.positional()) continue;
      options.push_back(option.name);
      if (!option.choices.empty())
        values +=
            fmt::format("    '{} {}') COMPREPLY=($(compgen -W '{}' -- \"$cur\")); return ;;\n",
                        command.name, option.name, joined(option.choices, " "));
    }
    options_by_command +=
        fmt::format("    {}) options='{}' ;;\n", command.name, joined(options, " "));
  }
  return fmt::format(fmt::runtime(kCompletion), joined(names, "|"), values, options_by_command,
                     joined(names, " "));
}

std::string format_list() {
  std::string text =
      "| read | files | what | axes | SH degrees | limits |\n|---|---|---|---|---|---|\n";
  for (const ReaderRow& row : readers())
    text += fmt::format("| {} | `{}` | {} | {} | {} | {} |\n", row.name, row.extensions,
                        row.summary, row.axes, row.sh_degrees, row.limits);
  text +=
      "\n| written | ending | what | axes | SH degrees | what is lost "
      "|\n|---|---|---|---|---|---|\n";
  for (const WriterRow& row : writers())
    text += fmt::format(
        "| {} | `{}` | {} | {} | {} | {} |\n", row.name, row.extension, row.summary, row.axes,
        row.max_sh_degree == 0 ? "0" : fmt::format("0-{}", row.max_sh_degree), row.losses);
  return text;
}

}  // namespace qs
