// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "swiftlet/core/config.hpp"

namespace swiftlet {

/// What a scenario may choose by name. First come the rows of Swiftlet, in one .cpp of a room above everything that it
/// names. Then come those that a program plugs in. A row is a struct that begins with `ModuleType module` and has a
/// `make`. Rows are added before configurations are read, and not beside other threads.
template <class Row>
class Registry {
 public:
  /// `what` names the kind of module in messages; `rows` is the table that comes with Swiftlet. `added` is told of
  /// every row.
  Registry(const char* what, std::span<const Row> rows, void (*added)(const Row&) = nullptr)
      : what_(what), added_(added) {
    for (const Row& row : rows) add(row);
  }

  /// Throws std::invalid_argument when the name is taken.
  void add(const Row& row) {
    if (find(row.module.name) != nullptr)
      throw std::invalid_argument("there is a " + what_ + " named '" + row.module.name + "' already");
    rows_.push_back(row);
    modules_.push_back(row.module);
    if (added_ != nullptr) added_(row);
  }

  std::span<const Row> rows() const { return rows_; }
  /// The rows as far as configuration is concerned, in their order.
  std::span<const ModuleType> modules() const { return modules_; }

  /// The row of that name. Throws std::invalid_argument: "no <what> is named '<type>'".
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
