// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "swiftlet/core/agent/registry.hpp"
#include "swiftlet/core/stage_tables/detectors.hpp"
#include "swiftlet/core/stage_tables/estimators.hpp"
#include "swiftlet/core/stage_tables/guidances.hpp"
#include "swiftlet/core/stage_tables/mappers.hpp"
#include "swiftlet/core/stage_tables/relative_localizers.hpp"
#include "swiftlet/core/stage_tables/trackers.hpp"
#include "swiftlet/sim/metrics/metric.hpp"
#include "swiftlet/sim/registry/recorders.hpp"
#include "swiftlet/sim/registry/sensors.hpp"
#include "swiftlet/sim/registry/worlds.hpp"

/// Modules from a shared library that a scenario names by `plugins: [libmine.so]`. The library contains, once:
///
///   SWIFTLET_PLUGIN(registries) {
///     registries.guidances.add({{"orbit", "circles around a point", make_module_config<OrbitConfig>}, make_orbit});
///   }
namespace swiftlet::sim {

/// The registries of the program that loads a plugin. Functions such as guidance_registry() return different tables in
/// a shared library.
struct Registries {
  Registry<AgentType>& agents;
  Registry<EstimatorType>& estimators;
  Registry<DetectorType>& detectors;
  Registry<TrackerType>& trackers;
  Registry<RelativeLocalizerType>& relative_localizers;
  Registry<MapperType>& mappers;
  Registry<GuidanceType>& guidances;
  Registry<SensorType>& sensors;
  Registry<WorldType>& worlds;
  Registry<RecorderType>& recorders;
  std::vector<MetricType>& metrics;
};

/// Allows this process to load plugins, which must be built for exactly this version. Plugins run arbitrary code, so
/// only the user who starts the program may allow them, never a scenario.
void allow_plugins(std::string version);

/// Loads a plugin unless it is already loaded. A name without a folder that does not exist in `folder` is searched in
/// the system's library paths.
/// @return the expectation that is not met, for the reader's error message; empty on success
std::string load_plugin(const std::string& file, const std::filesystem::path& folder);

/// Paths of the loaded plugins, in loading order.
const std::vector<std::string>& loaded_plugins();

// Defined in sim/run, and in the plugin with the values of its build.
const char* version();
const char* git_revision();

}  // namespace swiftlet::sim

#define SWIFTLET_PLUGIN(registries)                                                             \
  extern "C" const char* swiftlet_plugin_version() {                                            \
    static const std::string version =                                                          \
        std::string(::swiftlet::sim::version()) + " (" + ::swiftlet::sim::git_revision() + ")"; \
    return version.c_str();                                                                     \
  }                                                                                             \
  extern "C" void swiftlet_plugin_register(const ::swiftlet::sim::Registries& registries)
