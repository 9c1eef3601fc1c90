// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <unistd.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <span>
#include <string>
#include <string_view>

/// Shared by the fuzz targets of files.
namespace swiftlet::fuzz {

using Input = std::span<const std::uint8_t>;

inline std::string_view text_of(Input input) { return {reinterpret_cast<const char*>(input.data()), input.size()}; }

/// A folder in memory that ends with the process.
class Folder {
 public:
  Folder() : path_("/dev/shm/swiftlet_fuzz_" + std::to_string(getpid())) { std::filesystem::create_directories(path_); }
  ~Folder() { std::filesystem::remove_all(path_); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path write(const std::string& name, std::string_view content) const {
    const std::filesystem::path file = path_ / name;
    std::filesystem::create_directories(file.parent_path());
    std::ofstream(file, std::ios::binary | std::ios::trunc)
        .write(content.data(), static_cast<std::streamsize>(content.size()));
    return file;
  }

 private:
  std::filesystem::path path_;
};

/// Aborts on an empty error message, or one of the standard library.
inline void require_message(const std::exception& problem) {
  const std::string message = problem.what();
  const bool raw = message.empty() || message.starts_with("sto") || message.starts_with("vector::") ||
                   message.starts_with("basic_string") || message.starts_with("std::");
  if (!raw) return;
  std::fprintf(stderr, "message that says nothing: '%s'\n", message.c_str());
  std::abort();
}

}  // namespace swiftlet::fuzz
