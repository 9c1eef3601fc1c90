// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

namespace swiftlet::sim {

/// Held while a database of results is written or replaced. A lock of the process: workers do not inherit it, and no
/// kill leaves it behind.
class WriterLock {
 public:
  /// Throws InputError when another process holds the lock of this database, std::runtime_error when there can be none.
  explicit WriterLock(const std::filesystem::path& database);
  ~WriterLock();
  WriterLock(const WriterLock&) = delete;
  WriterLock& operator=(const WriterLock&) = delete;

 private:
  int fd_;
};

}  // namespace swiftlet::sim
