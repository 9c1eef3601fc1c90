// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>

namespace swiftlet {

/// Number of events since the start of a run that exceeded a setting, with the key of that setting.
struct Counter {
  std::string what;  ///< such as "returns outside the detector's map"
  std::uint64_t count = 0;
  std::uint64_t of = 0;  ///< total number of events; 0: not counted
  std::string setting;   ///< key to change, relative to the module that reports the counter: "map.size_m"
};

}  // namespace swiftlet
