// SPDX-License-Identifier: BSD-3-Clause
#include "command_line.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <charconv>
#include <cmath>
#include <limits>
#include <type_traits>
#include <utility>

namespace swiftlet::tools {
namespace {

constexpr double kUnlimited = std::numeric_limits<double>::infinity();

/// Expected value for messages: "a whole number in [0, 1024]", "a number >= 0".
template <class T>
std::string expected(double min, double max) {
  if constexpr (std::is_integral_v<T>) {
    using Limits = std::numeric_limits<T>;
    const T least = min > static_cast<double>(Limits::min()) ? static_cast<T>(min) : Limits::min();
    const T most = max < static_cast<double>(Limits::max()) ? static_cast<T>(max) : Limits::max();
    return fmt::format("a whole number in [{}, {}]", least, most);
  }
  if (min > -kUnlimited && max < kUnlimited) return fmt::format("a number in [{:g}, {:g}]", min, max);
  if (min > -kUnlimited) return fmt::format("a number >= {:g}", min);
  return max < kUnlimited ? fmt::format("a number <= {:g}", max) : "a number";
}

/// Parses the whole text as a number; the library accepts -1 for unsigned numbers and truncates large ones.
template <class T>
bool parse(const std::string& text, T& value) {
  const auto [end, problem] = std::from_chars(text.data(), text.data() + text.size(), value);
  return problem == std::errc() && end == text.data() + text.size();
}

/// Error message for the text of an option's number; empty: valid.
template <class T>
std::string complaint(const std::string& text, double min, double max) {
  T value{};
  bool ok = parse(text, value) && static_cast<double>(value) >= min && static_cast<double>(value) <= max;
  if constexpr (std::is_floating_point_v<T>) ok = ok && std::isfinite(value);
  if (ok) return {};
  std::string shown = text;
  for (char& c : shown) c = static_cast<unsigned char>(c) < 0x20 ? '?' : c;
  return "expected " + expected<T>(min, max) + ", found \"" + shown + "\"";
}

template <class T>
struct Number {
  using Type = T;
};
template <class T>
struct Number<std::optional<T>> {
  using Type = T;
};
template <class T>
struct Number<std::vector<T>> {
  using Type = T;
};

template <class T>
void add(CLI::App& command, const std::string& name, T& value, const std::string& doc, const OptionTraits& traits) {
  CLI::Option* option = command.add_option(name, value, doc);
  if (*traits.value_name != '\0') option->type_name(traits.value_name);
  if (traits.required) option->required();
  using Value = typename Number<T>::Type;
  if constexpr (std::is_arithmetic_v<Value>) {
    option->check([min = traits.min.value_or(-kUnlimited), max = traits.max.value_or(kUnlimited)](
                      const std::string& text) { return complaint<Value>(text, min, max); });
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

CommandShape shape_of(const CLI::App& app) {
  CommandShape shape{app.get_name(), app.get_description(), {}, {}};
  for (const CLI::Option* option : app.get_options({})) {
    CommandShape::Option one;
    for (const std::string& name : option->get_snames()) one.names.push_back("-" + name);
    for (const std::string& name : option->get_lnames()) one.names.push_back("--" + name);
    one.value_name = option->get_items_expected_max() == 0 ? "" : option->get_type_name();
    one.doc = option->get_description();
    shape.options.push_back(std::move(one));
  }
  for (const CLI::App* command : app.get_subcommands({})) shape.commands.push_back(shape_of(*command));
  return shape;
}

}  // namespace swiftlet::tools
