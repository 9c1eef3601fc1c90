// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <system_error>

namespace swiftlet::tools {

/// A temporary folder, removed with the object.
class ScratchFolder {
 public:
  ScratchFolder() {
    std::error_code missing;  // TMPDIR may name a folder that does not exist
    std::filesystem::path parent = std::filesystem::temp_directory_path(missing);
    if (missing) parent = "/tmp";
    path_ = (parent / "swiftlet_XXXXXX").string();
    if (::mkdtemp(path_.data()) != nullptr) return;
    throw std::runtime_error("TMPDIR: expected a writable folder, found " + parent.string() + ": " +
                             std::strerror(errno));
  }
  ~ScratchFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;

  const std::string& path() const { return path_; }
  std::filesystem::path operator/(const std::string& name) const { return std::filesystem::path(path_) / name; }

 private:
  std::string path_;
};

}  // namespace swiftlet::tools
