// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

#include "swiftlet/sim/io/files.hpp"

namespace swiftlet::sim {

/// A file that appears under its name only when it is complete: written as "NAME.part", renamed by finish(). A link at
/// either name is replaced, not followed. Buffered, append only. Throws std::runtime_error "cannot write PATH: REASON"
/// on any failure.
class OutputFile {
 public:
  OutputFile() = default;
  explicit OutputFile(std::filesystem::path path, std::size_t buffer_bytes = 1 << 16,
                      MissingFolders missing = MissingFolders::kMade);
  ~OutputFile();  ///< removes an unfinished file
  OutputFile(OutputFile&& other) noexcept;
  OutputFile& operator=(OutputFile&& other) noexcept;

  bool is_open() const { return descriptor_ >= 0; }
  void append(std::span<const std::byte> bytes);
  void append(std::string_view text) { append(std::as_bytes(std::span(text))); }
  /// Overwrites bytes at an earlier offset (for headers that are known only at the end).
  void overwrite(std::uint64_t offset, std::span<const std::byte> bytes);
  std::uint64_t size() const { return written_ + buffer_.size(); }  ///< bytes appended so far
  const std::filesystem::path& path() const { return file_.destination(); }
  void finish();

 private:
  void claim(const std::filesystem::path& path);
  void flush();
  void write_all(std::span<const std::byte> bytes);
  void abandon() noexcept;

  PartialFile file_;
  int descriptor_ = -1;
  std::uint64_t written_ = 0;
  std::size_t capacity_ = 0;
  std::vector<std::byte> buffer_;
};

}  // namespace swiftlet::sim
