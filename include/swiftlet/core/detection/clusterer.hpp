// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace swiftlet {

/// Joins points by their mutual distance [Vrba 2025, eqs. 13-15]. Two points are in the same cluster exactly if a chain
/// of points joins them in steps of at most the tolerance.
///
/// Clusters are in the order of their first points, members in the order of the points, so results do not depend on the
/// implementation. Any frame, the same for all arguments.
class Clusterer {
 public:
  virtual ~Clusterer() = default;
  virtual void compute(std::span<const Eigen::Vector3f> points_m, double tolerance_m) = 0;

  int size() const { return static_cast<int>(starts_.size()) - 1; }
  /// Indices of the points of a cluster.
  std::span<const std::uint32_t> members(int cluster) const {
    return std::span(members_).subspan(starts_[cluster], starts_[cluster + 1] - starts_[cluster]);
  }

 protected:
  std::vector<std::uint32_t> starts_ = {0}, members_;
};

using MakeClusterer = std::unique_ptr<Clusterer> (*)();

/// Clusterer by name: "swiftlet", or one plugged in by an optional room. Throws std::invalid_argument.
std::unique_ptr<Clusterer> make_clusterer(const std::string& name);
bool has_clusterer(std::string_view name);
/// Plugs in the clusterer of an optional room, replacing one of the same name. Must be called before configurations are
/// read, and not concurrently with other threads.
void plug_in_clusterer(const std::string& name, MakeClusterer make);

}  // namespace swiftlet
