// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace CLI {
class App;
}

/// A thin face of the command-line library. The library is all templates in headers, ten seconds of compilation for
/// each file that includes it: only command_line.cpp and main.cpp do.
namespace swiftlet::tools {

/// What an option may say of itself. A name without dashes is a positional argument.
struct OptionTraits {
  const char* value_name = "";  ///< in the help: "DIR"
  bool required = false;
  std::optional<double> min = {};  ///< of a number
  std::optional<double> max = {};
  bool repeated = false;  ///< lists: one value each time the option is named, instead of all that follow
};

class Subcommand {
 public:
  Subcommand(CLI::App& app, const std::string& name, const std::string& doc);

  void flag(const std::string& name, bool& value, const std::string& doc);
  void option(const std::string& name, std::string& value, const std::string& doc, const OptionTraits& traits = {});
  void option(const std::string& name, int& value, const std::string& doc, const OptionTraits& traits = {});
  void option(const std::string& name, double& value, const std::string& doc, const OptionTraits& traits = {});
  void option(const std::string& name, std::optional<int>& value, const std::string& doc,
              const OptionTraits& traits = {});
  void option(const std::string& name, std::optional<double>& value, const std::string& doc,
              const OptionTraits& traits = {});
  void option(const std::string& name, std::optional<std::uint64_t>& value, const std::string& doc,
              const OptionTraits& traits = {});
  void option(const std::string& name, std::vector<std::string>& value, const std::string& doc,
              const OptionTraits& traits = {});
  void option(const std::string& name, std::vector<double>& value, const std::string& doc,
              const OptionTraits& traits = {});

  /// A subcommand of this subcommand ("dataset verify"); without one, this one's own action runs.
  Subcommand subcommand(const std::string& name, const std::string& doc);
  /// Called after parsing, when this subcommand was chosen.
  void action(std::function<void()> run);

 private:
  explicit Subcommand(CLI::App& command) : command_(&command) {}
  CLI::App* command_;
};

/// A command as its help tells it: for manual pages and completion in shells.
struct CommandShape {
  struct Option {
    std::vector<std::string> names;  ///< with their dashes; none: a positional argument
    std::string value_name;          ///< empty: a flag
    std::string doc;
  };
  std::string name, doc;
  std::vector<Option> options;
  std::vector<CommandShape> commands;
};
CommandShape shape_of(const CLI::App& app);

}  // namespace swiftlet::tools
