// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/plugin/plugin.hpp"

#include <dlfcn.h>

#include <algorithm>
#include <exception>
#include <fstream>
#include <iterator>
#include <string_view>

namespace swiftlet::sim {
namespace {

namespace fs = std::filesystem;

/// Text in the binary of a plugin, directly before the version for which it was built; as in cmake/Version.cmake.
constexpr std::string_view kMark = "swiftlet plugin mark: ";

struct LoadedPlugins {
  std::string allowed_version;  // empty: plugins are not allowed
  std::vector<std::string> paths;
};

LoadedPlugins& loaded() {
  static LoadedPlugins state;
  return state;
}

/// Path of a plugin: in the folder if it exists there, else relative to the working directory.
fs::path path_of(const std::string& file, const fs::path& folder) {
  const fs::path in_folder = folder / file;
  if (fs::exists(in_folder)) return fs::absolute(in_folder).lexically_normal();
  return fs::exists(file) ? fs::absolute(file).lexically_normal() : fs::path(file);
}

std::string in_quotes(const std::string& text) { return "\"" + text + "\""; }

std::string content_of(const fs::path& path) {
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

/// Version for which a plugin with this content was built, without executing its code; empty if there is none.
std::string version_in(const std::string& content) {
  for (std::size_t at = 0; (at = content.find(kMark, at)) != std::string::npos;) {
    at += kMark.size();
    const std::string version = content.substr(at, content.find('\0', at) - at);
    // Empty after the constant kMark itself, in a plugin that links this file.
    if (!version.empty()) return version;
  }
  return {};
}

template <class Function>
Function* symbol(void* library, const char* name) {
  return reinterpret_cast<Function*>(dlsym(library, name));
}

}  // namespace

void allow_plugins(std::string version) { loaded().allowed_version = std::move(version); }

const std::vector<std::string>& loaded_plugins() { return loaded().paths; }

std::string load_plugin(const std::string& file, const fs::path& folder) {
  LoadedPlugins& state = loaded();
  const fs::path path = path_of(file, folder);
  if (std::ranges::find(state.paths, path.string()) != state.paths.end()) return {};
  if (state.allowed_version.empty())
    return "--allow-plugins on the command line, because the plugin " + in_quotes(file) + " executes native code";
  const std::string no_library = "a shared library, found " + in_quotes(file) + ": ";
  const std::string no_plugin = "a plugin of Swiftlet, found " + in_quotes(file) +
                                ", which has no SWIFTLET_PLUGIN, or that of an older version; build it again";
  const auto other = [&](const std::string& version) {
    return "a plugin that was built for swiftlet " + state.allowed_version + ", found " + in_quotes(file) + " for " +
           version + "; build it again";
  };
  if (fs::is_regular_file(path)) {
    const std::string content = content_of(path);
    if (!content.starts_with("\177ELF")) return no_library + "it is not an ELF file";
    const std::string version = version_in(content);
    if (version.empty()) return no_plugin;
    if (version != state.allowed_version) return other(version);
  }
  void* library = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr) return no_library + dlerror();
  auto* version_of = symbol<const char*()>(library, "swiftlet_plugin_version");
  auto* add_rows = symbol<void(const Registries&)>(library, "swiftlet_plugin_register");
  const char* version = version_of == nullptr ? nullptr : version_of();
  if (version == nullptr || add_rows == nullptr || version != state.allowed_version) {
    const std::string problem = version == nullptr || add_rows == nullptr ? no_plugin : other(version);
    dlclose(library);
    return problem;
  }
  const std::string failed = "a plugin with modules, found " + in_quotes(file) + ": ";
  try {  // the library is never unloaded, because registries refer to its code
    add_rows({agent_registry(), estimator_registry(), detector_registry(), tracker_registry(),
              relative_localizer_registry(), mapper_registry(), guidance_registry(), sensor_registry(),
              world_registry(), recorder_registry(), metric_registry()});
  } catch (const std::exception& problem) {
    return failed + problem.what();
  } catch (...) {
    return failed + "it threw something that is no std::exception";
  }
  state.paths.push_back(path.string());
  return {};
}

}  // namespace swiftlet::sim
