// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "swiftlet/core/base/frames.hpp"
#include "swiftlet/core/base/time.hpp"

namespace swiftlet {

/// Follows clusters from scan to scan, and distinguishes those that have moved from those that stand where they were
/// first seen. A cluster that appears in air known to be free has moved as well. Linear in the number of remembered
/// clusters, which is bounded.
class MovedThings {
 public:
  /// Motion of a cluster so far.
  struct Motion {
    bool has_moved = false;
    TimeNs seen_for = 0;  ///< [ns] time since the first sighting
  };

  MovedThings();
  /// Adds a sighting. @param in_free_air  most of its points are in air that was known to be free before this scan
  Motion see(TimeNs t, const Vector3& center_local_m, bool in_free_air);

 private:
  struct Thing {
    Eigen::Vector3f first_local_m, last_local_m;
    TimeNs first = 0, last = 0;
    bool has_moved = false;
  };

  Thing& thing_at(TimeNs t, const Eigen::Vector3f& center_local_m, bool in_free_air);

  std::vector<Thing> things_;
};

}  // namespace swiftlet
