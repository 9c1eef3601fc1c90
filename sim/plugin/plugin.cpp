// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/plugin/plugin.hpp"

#include <dlfcn.h>

#include <algorithm>
#include <stdexcept>

namespace swiftlet::sim {
namespace {

namespace fs = std::filesystem;

struct Loaded {
  std::string allowed_version;  // empty: none are allowed
  std::vector<std::string> paths;
};

Loaded& loaded() {
  static Loaded state;
  return state;
}

fs::path path_of(const std::string& file, const fs::path& folder) {
  const fs::path beside = folder / file;
  if (fs::exists(beside)) return fs::absolute(beside).lexically_normal();
  return fs::exists(file) ? fs::absolute(file).lexically_normal() : fs::path(file);
}

std::string in_quotes(const std::string& text) { return "\"" + text + "\""; }

template <class Function>
Function* symbol(void* library, const char* name) {
  return reinterpret_cast<Function*>(dlsym(library, name));
}

}  // namespace

void allow_plugins(std::string version) { loaded().allowed_version = std::move(version); }

const std::vector<std::string>& loaded_plugins() { return loaded().paths; }

std::string load_plugin(const std::string& file, const fs::path& folder) {
  Loaded& state = loaded();
  const fs::path path = path_of(file, folder);
  if (std::ranges::find(state.paths, path.string()) != state.paths.end()) return {};
  if (state.allowed_version.empty())
    return "--allow-plugins on the command line, because " + in_quotes(file) + " runs code of its own";
  void* library = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr) return "a shared library, found " + in_quotes(file) + ": " + dlerror();
  auto* version_of = symbol<const char*()>(library, "swiftlet_plugin_version");
  auto* add_rows = symbol<void(const Registries&)>(library, "swiftlet_plugin_register");
  if (version_of == nullptr || add_rows == nullptr) {
    dlclose(library);
    return "a plugin of Swiftlet, found " + in_quotes(file) + ", which has no SWIFTLET_PLUGIN";
  }
  if (const std::string built_for = version_of(); built_for != state.allowed_version) {
    dlclose(library);
    return "a plugin that was built for swiftlet " + state.allowed_version + ", found " + in_quotes(file) + " for " +
           built_for + "; build it again";
  }
  try {  // stays loaded from here on: tables point into it
    add_rows({agent_registry(), estimator_registry(), detector_registry(), tracker_registry(),
              relative_localizer_registry(), mapper_registry(), guidance_registry(), sensor_registry(),
              world_registry(), recorder_registry(), metric_registry()});
  } catch (const std::exception& problem) {
    return "a plugin whose names are free, found " + in_quotes(file) + ": " + problem.what();
  }
  state.paths.push_back(path.string());
  return {};
}

}  // namespace swiftlet::sim
