// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>

#include "sim/scenario/config_errors.hpp"
#include "swiftlet/core/base/config.hpp"

namespace swiftlet::sim {

/// Conversion of nodes to values of a configuration. An invalid node adds an error and leaves the value as it is.
/// `path` names the node in messages, and the unit of numbers is that of `key`.
class NodeValues {
 public:
  explicit NodeValues(ConfigErrors& errors) : errors_(errors) {}

  void read(const Node& node, const std::string& path, bool& value);
  void read(const Node& node, const std::string& path, std::uint64_t& value);
  bool read(const Node& node, const std::string& path, std::string& value);
  void read(const Node& node, const std::string& path, const char* key, int& value, const Range& range);
  void read(const Node& node, const std::string& path, const char* key, double& value, const Range& range);
  /// Vectors of 2 or 3 numbers.
  template <class Vector>
  void read(const Node& node, const std::string& path, const char* key, Vector& value, const Range& range) {
    if (!node.is_list() || static_cast<Eigen::Index>(node.items.size()) != value.size())
      return errors_.add_value(node, path, "a list of " + std::to_string(value.size()) + " numbers");
    for (Eigen::Index i = 0; i < value.size(); ++i) {
      const std::string element = path + "[" + std::to_string(i) + "]";
      read(node.items[static_cast<std::size_t>(i)], element, key, value[i], range);
    }
  }

 private:
  std::optional<double> read_number(const Node& node, const std::string& path, const char* key,
                                    const std::string& expected);

  ConfigErrors& errors_;
};

}  // namespace swiftlet::sim
