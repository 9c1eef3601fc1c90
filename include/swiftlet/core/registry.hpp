// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <iterator>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>

#include "swiftlet/core/config.hpp"

/// What every registry does with its table. A row is a struct that begins with `ModuleType module` and has a `make`;
/// the table is a constant array of rows in one .cpp, in a room above everything that it names.
namespace swiftlet {

/// The rows as far as configuration is concerned, in their order.
template <const auto& kRows>
std::span<const ModuleType> module_types_of() {
  static const auto modules = [] {
    std::array<ModuleType, std::size(kRows)> out{};
    for (std::size_t i = 0; i < out.size(); ++i) out[i] = kRows[i].module;
    return out;
  }();
  return modules;
}

/// The row of that name. Throws std::invalid_argument: "no <what> is named '<type>'".
template <class Rows>
const auto& row_named(const Rows& rows, std::string_view type, const char* what) {
  for (const auto& row : rows) {
    if (type == row.module.name) return row;
  }
  throw std::invalid_argument("no " + std::string(what) + " is named '" + std::string(type) + "'");
}

}  // namespace swiftlet
