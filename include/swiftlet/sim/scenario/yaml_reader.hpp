// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "swiftlet/core/base/config.hpp"
#include "swiftlet/sim/errors/errors.hpp"
#include "swiftlet/sim/scenario/config_files.hpp"

/// The strict reader: fills any configuration through its `visit`. Any fault in the input throws an InputError. Its
/// message has at most 20 lines, in the order of the text, of this form:
///   file:line:column: key.path[0].x: expected <what>, found <what>; did you mean "<what>"?
namespace swiftlet::sim {

/// A visitor that reads a text and provides the location of the value of `key`, for faults found later:
/// "forest.yaml:12:7: vehicles[0].start.position_m: ". Call it after reading the field.
class PlaceProvider {
 public:
  virtual ~PlaceProvider() = default;
  virtual std::string place_of(const char* key) const = 0;
};

using ConfigVisit = std::function<void(ConfigVisitor&)>;
/// ("vehicles[0].start.yaw_deg", "90"): key path and YAML value, applied to the file in this order.
using Overrides = ConfigChanges;

/// Reads `file` with its `base:` chain and the overrides. The struct behind `visit` holds the defaults.
void read_config(const std::filesystem::path& file, const ConfigVisit& visit, const Overrides& overrides = {},
                 const ConfigFiles& files = system_files());

/// As read_config() for a text. `name` is its name in messages; its folder is the base of relative paths.
void read_config_text(const std::string& text, const std::filesystem::path& name, const ConfigVisit& visit,
                      const Overrides& overrides = {}, const ConfigFiles& files = system_files());

}  // namespace swiftlet::sim
