// SPDX-License-Identifier: BSD-3-Clause
#include "sim/world/input_file.hpp"

#include <algorithm>
#include <cctype>

#include "swiftlet/sim/errors.hpp"

namespace swiftlet::sim {

namespace fs = std::filesystem;

void reject_file(const fs::path& file, const std::string& reason) { throw InputError(file.string() + ": " + reason); }

std::string extension_of(const fs::path& file) {
  std::string extension = file.extension().string();
  if (!extension.empty()) extension.erase(0, 1);
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  return extension;
}

}  // namespace swiftlet::sim
