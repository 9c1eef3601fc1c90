// SPDX-License-Identifier: BSD-3-Clause
#include "sim/recorders/selection.hpp"

#include <algorithm>

#include "swiftlet/sim/errors/errors.hpp"

namespace swiftlet::sim {

std::vector<bool> select_vehicles(const std::vector<std::string>& wanted, const std::vector<std::string>& names) {
  for (const std::string& name : wanted) {
    if (std::find(names.begin(), names.end(), name) != names.end()) continue;
    std::string known;
    for (const std::string& vehicle : names) known += (known.empty() ? "" : ", ") + vehicle;
    throw InputError("recorders: vehicles: expected names of vehicles (" + known + "), found \"" + name + "\"");
  }
  std::vector<bool> selected;
  for (const std::string& name : names) selected.push_back(selects(wanted, name));
  return selected;
}

bool selects(const std::vector<std::string>& wanted, const std::string& word) {
  return wanted.empty() || std::find(wanted.begin(), wanted.end(), word) != wanted.end();
}

}  // namespace swiftlet::sim
