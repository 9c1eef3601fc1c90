// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/scenario/config_files.hpp"

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <stdexcept>
#include <system_error>

#include "swiftlet/sim/scenario/document.hpp"

namespace swiftlet::sim {
namespace {

namespace fs = std::filesystem;

/// <prefix>/share/swiftlet when the program lies in <prefix>/bin; empty when unknown.
fs::path installed_share() {
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  return error ? fs::path() : program.parent_path().parent_path() / "share" / "swiftlet";
}

std::vector<fs::path> roots(const char* environment, const char* folder) {
  std::vector<fs::path> paths;
  const char* value = environment == nullptr ? nullptr : std::getenv(environment);
  std::string_view rest = value == nullptr ? "" : value;
  while (!rest.empty()) {
    const std::size_t colon = std::min(rest.find(':'), rest.size());
    if (colon > 0) paths.emplace_back(rest.substr(0, colon));
    rest.remove_prefix(std::min(colon + 1, rest.size()));
  }
  if (const fs::path share = installed_share(); !share.empty()) paths.push_back(share / folder);
  paths.push_back(fs::path(SWIFTLET_SOURCE_DIR) / folder);
  paths.push_back(fs::path(SWIFTLET_INSTALLED_SHARE) / folder);
  return paths;
}

class SystemFiles final : public ConfigFiles {
 public:
  bool is_file(const fs::path& path) const override {
    std::error_code error;
    return fs::is_regular_file(path, error);
  }

  std::string read(const fs::path& path) const override {
    std::error_code error;
    const auto size = fs::file_size(path, error);
    if (error) throw std::runtime_error(path.string() + ": cannot be read: " + error.message());
    // One byte above the limit suffices to reject the file.
    std::string text(std::min<std::uintmax_t>(size, kMaxFileBytes + 1), '\0');
    std::ifstream file(path, std::ios::binary);
    file.read(text.data(), static_cast<std::streamsize>(text.size()));
    if (!file) throw std::runtime_error(path.string() + ": cannot be read");
    return text;
  }

  std::vector<std::string> list(const fs::path& folder) const override {
    std::vector<std::string> names;
    std::error_code error;
    for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
      names.push_back(entry->path().filename().string());
    }
    std::sort(names.begin(), names.end());
    return names;
  }

  std::vector<fs::path> asset_roots() const override { return roots("SWIFTLET_ASSETS", "assets"); }
  std::vector<fs::path> scenario_roots() const override { return roots(nullptr, "scenarios"); }
};

}  // namespace

const ConfigFiles& system_files() {
  static const SystemFiles files;
  return files;
}

}  // namespace swiftlet::sim
