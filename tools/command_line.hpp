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

/// A thin interface to the command-line library, which consists of templates in headers and adds ten seconds of
/// compilation to each file that includes it; only command_line.cpp and main.cpp do.
namespace swiftlet::tools {

/// Properties of an option. A name without dashes is a positional argument.
struct OptionTraits {
  const char* value_name = "";  ///< in the help: "DIR"
  bool required = false;
  std::optional<double> min = {};  ///< least valid number
  std::optional<double> max = {};
  bool repeated = false;  ///< lists: one value per occurrence of the option, instead of all values that follow
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

  /// A nested subcommand ("dataset verify"); without it, this subcommand's own action runs.
  Subcommand subcommand(const std::string& name, const std::string& doc);
  /// Called after parsing if this subcommand was chosen.
  void action(std::function<void()> run);

 private:
  explicit Subcommand(CLI::App& command) : command_(&command) {}
  CLI::App* command_;
};

/// Structure of a command's help, for manual pages and shell completion.
struct CommandShape {
  struct Option {
    std::vector<std::string> names;  ///< with their dashes; empty: a positional argument
    std::string value_name;          ///< empty: a flag
    std::string doc;
  };
  std::string name, doc;
  std::vector<Option> options;
  std::vector<CommandShape> commands;
};
CommandShape shape_of(const CLI::App& app);

}  // namespace swiftlet::tools
