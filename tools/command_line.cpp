// SPDX-License-Identifier: BSD-3-Clause
#include "command_line.hpp"

#include <CLI/CLI.hpp>
#include <limits>
#include <utility>

namespace swiftlet::tools {
namespace {

template <class T>
void add(CLI::App& command, const std::string& name, T& value, const std::string& doc, const OptionTraits& traits) {
  CLI::Option* option = command.add_option(name, value, doc);
  if (*traits.value_name != '\0') option->type_name(traits.value_name);
  if (traits.required) option->required();
  if (traits.min || traits.max) {
    option->check(CLI::Range(traits.min.value_or(std::numeric_limits<double>::lowest()),
                             traits.max.value_or(std::numeric_limits<double>::max())));
  }
  if (traits.repeated) option->allow_extra_args(false);
}

}  // namespace

Subcommand::Subcommand(CLI::App& app, const std::string& name, const std::string& doc)
    : command_(app.add_subcommand(name, doc)) {}

void Subcommand::flag(const std::string& name, bool& value, const std::string& doc) {
  command_->add_flag(name, value, doc);
}

void Subcommand::option(const std::string& name, std::string& value, const std::string& doc,
                        const OptionTraits& traits) {
  add(*command_, name, value, doc, traits);
}
void Subcommand::option(const std::string& name, int& value, const std::string& doc, const OptionTraits& traits) {
  add(*command_, name, value, doc, traits);
}
void Subcommand::option(const std::string& name, double& value, const std::string& doc, const OptionTraits& traits) {
  add(*command_, name, value, doc, traits);
}
void Subcommand::option(const std::string& name, std::optional<int>& value, const std::string& doc,
                        const OptionTraits& traits) {
  add(*command_, name, value, doc, traits);
}
void Subcommand::option(const std::string& name, std::optional<double>& value, const std::string& doc,
                        const OptionTraits& traits) {
  add(*command_, name, value, doc, traits);
}
void Subcommand::option(const std::string& name, std::optional<std::uint64_t>& value, const std::string& doc,
                        const OptionTraits& traits) {
  add(*command_, name, value, doc, traits);
}
void Subcommand::option(const std::string& name, std::vector<std::string>& value, const std::string& doc,
                        const OptionTraits& traits) {
  add(*command_, name, value, doc, traits);
}
void Subcommand::option(const std::string& name, std::vector<double>& value, const std::string& doc,
                        const OptionTraits& traits) {
  add(*command_, name, value, doc, traits);
}

Subcommand Subcommand::subcommand(const std::string& name, const std::string& doc) {
  command_->require_subcommand(0, 1);
  return {*command_, name, doc};
}

void Subcommand::action(std::function<void()> run) {
  command_->callback([command = command_, run = std::move(run)] {
    if (command->get_subcommands().empty()) run();
  });
}

}  // namespace swiftlet::tools
