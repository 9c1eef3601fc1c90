// SPDX-License-Identifier: BSD-3-Clause
// Shell completion and manual page, generated from the help.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <string>
#include <vector>

#include "commands.hpp"
#include "swiftlet/sim/run/version.hpp"

namespace swiftlet::tools {
namespace {

/// Escapes text for a manual page: a backslash and a leading dot or quote would be commands.
std::string roff(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '\\') {
      out += "\\e";
    } else if (c == '-') {
      out += "\\-";
    } else {
      if (out.empty() && (c == '.' || c == '\'')) out += "\\&";
      out += c;
    }
  }
  return out;
}

std::string roff_options(const CommandShape& command) {
  std::string text;
  for (const CommandShape::Option& option : command.options) {
    std::string head;
    for (const std::string& name : option.names) head += (head.empty() ? "" : ", ") + ("\\fB" + roff(name) + "\\fR");
    if (!option.value_name.empty()) head += (head.empty() ? "\\fI" : " \\fI") + roff(option.value_name) + "\\fR";
    text += ".TP\n" + head + "\n" + roff(option.doc) + "\n";
  }
  return text;
}

std::string roff_command(const CommandShape& command, const std::string& before) {
  const std::string name = before + " " + command.name;
  std::string text = ".SS " + roff(name) + "\n" + roff(command.doc) + ".\n" + roff_options(command);
  for (const CommandShape& below : command.commands) text += roff_command(below, name);
  return text;
}

std::string manual_page(const CommandShape& program) {
  std::string text = fmt::format(".TH SWIFTLET 1 \"\" \"Swiftlet {}\" \"User Commands\"\n", sim::version());
  text += ".SH NAME\nswiftlet \\- " + roff(program.doc.substr(program.doc.find(':') + 2)) + "\n";
  text += ".SH SYNOPSIS\n.B swiftlet\n\\fICOMMAND\\fR [\\fIOPTION\\fR]...\n.SH COMMANDS\n";
  for (const CommandShape& command : program.commands) text += roff_command(command, program.name);
  text += ".SH EXIT STATUS\n.TP\n0\nSuccess.\n.TP\n1\nAn error other than of the input, such as a full disk.\n";
  text += ".TP\n2\nThe input is invalid: one message names file, line and key, and nothing was written.\n";
  text += ".TP\n130, 143\nIt was interrupted or terminated.\n";
  text += ".TP\n141\nThe reader of the output ended first.\n";
  return text;
}

/// Lines of a `case` in bash: command, its options, and the sources of completions for its first words.
std::string bash_cases(const CommandShape& program) {
  std::string text;
  for (const CommandShape& command : program.commands) {
    std::vector<std::string> words;
    for (const CommandShape& below : command.commands) words.push_back(below.name);
    for (const CommandShape::Option& option : command.options) {
      words.insert(words.end(), option.names.begin(), option.names.end());
    }
    text += fmt::format("    {}) words='{}' ;;\n", command.name, fmt::join(words, " "));
  }
  return text;
}

std::string bash_completion(const CommandShape& program) {
  std::vector<std::string> commands;
  for (const CommandShape& command : program.commands) commands.push_back(command.name);
  return fmt::format(R"(# Completion of swiftlet for bash: source it, or put it into /etc/bash_completion.d
_swiftlet() {{
  local word=${{COMP_WORDS[COMP_CWORD]}} words=
  if [ "$COMP_CWORD" -eq 1 ]; then
    COMPREPLY=($(compgen -W '{} --help --version' -- "$word"))
    return
  fi
  case ${{COMP_WORDS[1]}} in
{}  esac
  if [[ $word != -* ]]; then
    case ${{COMP_WORDS[1]}} in
      run | check | world) words=$("${{COMP_WORDS[0]}}" list scenarios 2>/dev/null | awk '/^  /{{print $1}}') ;;
      list) words=$("${{COMP_WORDS[0]}}" list 2>/dev/null | awk '/^[a-z]/{{print $1}}') ;;
    esac
  fi
  COMPREPLY=($(compgen -W "$words" -- "$word") $(compgen -f -- "$word"))
}}
complete -o filenames -F _swiftlet swiftlet
)",
                     fmt::join(commands, " "), bash_cases(program));
}

}  // namespace

void add_manual(CLI::App& app) {
  Subcommand man(app, "man", "Print the manual page: swiftlet man | man -l -");
  man.action([&app] { fmt::print("{}", manual_page(shape_of(app))); });
  Subcommand completion(app, "completion", "Print a script that completes commands, options and names in bash");
  completion.action([&app] { fmt::print("{}", bash_completion(shape_of(app))); });
}

}  // namespace swiftlet::tools
