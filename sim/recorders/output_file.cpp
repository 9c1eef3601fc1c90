// SPDX-License-Identifier: BSD-3-Clause
#include "sim/recorders/output_file.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <stdexcept>
#include <string>
#include <utility>

namespace swiftlet::sim {
namespace {

[[noreturn]] void fail(const std::filesystem::path& path, int error) {
  throw std::runtime_error("cannot write " + path.string() + ": " + std::strerror(error));
}

std::filesystem::path part_of(const std::filesystem::path& path) { return path.string() + ".part"; }

}  // namespace

OutputFile::OutputFile(std::filesystem::path path, std::size_t buffer_bytes)
    : path_(std::move(path)), capacity_(buffer_bytes) {
  if (path_.has_parent_path()) {
    std::error_code error;
    std::filesystem::create_directories(path_.parent_path(), error);
    if (error) fail(path_, error.value());
  }
  descriptor_ = ::open(part_of(path_).c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0666);
  if (descriptor_ < 0) fail(path_, errno);
  try {
    claim();
  } catch (...) {
    ::close(std::exchange(descriptor_, -1));
    throw;
  }
  buffer_.reserve(capacity_);
}

void OutputFile::claim() {
  // Two recorders of the same files would write over each other; a file left by a killed run has no owner any more.
  if (::flock(descriptor_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
    throw std::runtime_error("cannot write " + path_.string() + ": another recorder is writing it");
  }
  struct stat status {};
  if (::fstat(descriptor_, &status) != 0) fail(path_, errno);
  if (S_ISREG(status.st_mode) && ::ftruncate(descriptor_, 0) != 0) fail(path_, errno);
}

OutputFile::~OutputFile() { abandon(); }

OutputFile::OutputFile(OutputFile&& other) noexcept { *this = std::move(other); }

OutputFile& OutputFile::operator=(OutputFile&& other) noexcept {
  if (this == &other) return *this;
  abandon();
  path_ = std::move(other.path_);
  descriptor_ = std::exchange(other.descriptor_, -1);
  written_ = other.written_;
  capacity_ = other.capacity_;
  buffer_ = std::move(other.buffer_);
  return *this;
}

void OutputFile::append(std::span<const std::byte> bytes) {
  if (bytes.size() > capacity_ - buffer_.size()) flush();
  if (bytes.size() >= capacity_) {
    write_all(bytes);  // large blocks need no copy
  } else {
    buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
  }
}

void OutputFile::overwrite(std::uint64_t offset, std::span<const std::byte> bytes) {
  flush();
  while (!bytes.empty()) {
    const ssize_t count = ::pwrite(descriptor_, bytes.data(), bytes.size(), static_cast<off_t>(offset));
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) fail(path_, count < 0 ? errno : ENOSPC);
    offset += static_cast<std::uint64_t>(count);
    bytes = bytes.subspan(static_cast<std::size_t>(count));
  }
}

void OutputFile::finish() {
  flush();
  // Some file systems report a full disk only when the file is closed.
  if (::close(std::exchange(descriptor_, -1)) != 0) {
    const int error = errno;
    ::unlink(part_of(path_).c_str());
    fail(path_, error);
  }
  if (std::rename(part_of(path_).c_str(), path_.c_str()) != 0) fail(path_, errno);
}

void OutputFile::flush() {
  write_all(buffer_);
  buffer_.clear();
}

void OutputFile::write_all(std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t count = ::write(descriptor_, bytes.data(), bytes.size());
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) fail(path_, count < 0 ? errno : ENOSPC);
    written_ += static_cast<std::uint64_t>(count);
    bytes = bytes.subspan(static_cast<std::size_t>(count));
  }
}

void OutputFile::abandon() noexcept {
  if (descriptor_ < 0) return;
  ::close(std::exchange(descriptor_, -1));
  ::unlink(part_of(path_).c_str());
}

}  // namespace swiftlet::sim
