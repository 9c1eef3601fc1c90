// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>

namespace swiftlet {

/// How often the world did not fit a setting since the start of a run, and which setting that is.
struct Counter {
  std::string what;  ///< such as "returns outside the detector's map"
  std::uint64_t count = 0;
  std::uint64_t of = 0;  ///< how many there were in all; 0: not counted
  std::string setting;   ///< key to change, from the module that tells it: "map.size_m"
};

}  // namespace swiftlet
