// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "swiftlet/core/base/registry.hpp"
#include "swiftlet/sim/recording/recorder.hpp"

namespace swiftlet::sim {

/// Recorder type that a scenario can choose; the list is in sim/registry/recorders.cpp.
struct RecorderType {
  ModuleType module;
  std::unique_ptr<Recorder> (*make)(const ModuleConfig& config);
};

Registry<RecorderType>& recorder_registry();
inline std::span<const ModuleType> recorder_module_types() { return recorder_registry().modules(); }
std::unique_ptr<Recorder> make_recorder(const Module& config);

}  // namespace swiftlet::sim
