// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

namespace swiftlet::sim {

/// Lock held while a database of results is written or replaced. It belongs to the process: workers do not inherit it,
/// and it ends with a killed process.
class WriterLock {
 public:
  /// Throws InputError when another process holds the lock of this database, std::runtime_error when locking is
  /// impossible.
  explicit WriterLock(const std::filesystem::path& database);
  ~WriterLock();
  WriterLock(const WriterLock&) = delete;
  WriterLock& operator=(const WriterLock&) = delete;

 private:
  int fd_;
};

}  // namespace swiftlet::sim
