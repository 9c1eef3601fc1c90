// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <exception>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "swiftlet/core/base/config.hpp"

namespace swiftlet {

/// Modules that a scenario may select by name. First come the rows of Swiftlet, then those plugged in by a program. The
/// table of Swiftlet is in one .cpp of a room above all modules in it. A row is a struct that begins with `ModuleType
/// module` and has a `make`. Rows must be added before configurations are read, and not concurrently with other
/// threads.
template <class Row>
class Registry {
 public:
  /// `what` names the kind of module in messages; `rows` is the table that comes with Swiftlet. `added` is called with
  /// every row.
  Registry(const char* what, std::span<const Row> rows, void (*added)(const Row&) = nullptr)
      : what_(what), added_(added) {
    for (const Row& row : rows) add(row);
  }

  /// Throws std::invalid_argument when the name is taken, or when name, description or a maker is null.
  void add(const Row& row) {
    if (row.module.name == nullptr) throw std::invalid_argument("a " + what_ + " has no name");
    const std::string place = "the " + what_ + " '" + row.module.name + "' has no ";
    if (row.module.doc == nullptr) throw std::invalid_argument(place + "description");
    if (row.module.make_config == nullptr || row.make == nullptr) throw std::invalid_argument(place + "maker");
    if (find(row.module.name) != nullptr)
      throw std::invalid_argument("there is a " + what_ + " named '" + row.module.name + "' already");
    rows_.push_back(row);
    modules_.push_back(row.module);
    if (added_ != nullptr) added_(row);
  }

  /// Makes the chosen module. Throws std::runtime_error, which names the module, when the maker returns null or throws
  /// an object that is not a std::exception.
  template <class... Arguments>
  auto make(const Module& chosen, Arguments&&... arguments) const {
    const Row& row = named(chosen.type);
    try {
      auto made = row.make(*chosen.config, std::forward<Arguments>(arguments)...);
      if constexpr (requires { made == nullptr; }) {
        if (made == nullptr && chosen.type != "none")  // a stage that is left out
          throw std::runtime_error("the maker of the " + what_ + " '" + chosen.type + "' returned nothing");
      }
      return made;
    } catch (const std::exception&) {
      throw;
    } catch (...) {
      throw std::runtime_error("the maker of the " + what_ + " '" + chosen.type +
                               "' threw something that is no std::exception");
    }
  }

  std::span<const Row> rows() const { return rows_; }
  /// The configuration parts of the rows, in their order.
  std::span<const ModuleType> modules() const { return modules_; }

  /// Row with the given name. Throws std::invalid_argument: "no <what> is named '<type>'".
  const Row& named(std::string_view type) const {
    if (const Row* row = find(type)) return *row;
    throw std::invalid_argument("no " + what_ + " is named '" + std::string(type) + "'");
  }

 private:
  const Row* find(std::string_view type) const {
    for (const Row& row : rows_) {
      if (type == row.module.name) return &row;
    }
    return nullptr;
  }

  std::string what_;
  void (*added_)(const Row&);
  std::vector<Row> rows_;
  std::vector<ModuleType> modules_;
};

}  // namespace swiftlet
