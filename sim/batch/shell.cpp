// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/batch/shell.hpp"

#include <algorithm>
#include <string_view>

namespace swiftlet::sim {

std::string in_shell_quotes(const std::string& text) {
  const bool plain = !text.empty() && std::all_of(text.begin(), text.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
           std::string_view("_./-=+:,@%").find(c) != std::string_view::npos;
  });
  if (plain) return text;
  std::string quoted = "'";
  for (const char c : text) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

}  // namespace swiftlet::sim
