// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/io/output_file.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <utility>

namespace swiftlet::sim {
namespace {

namespace fs = std::filesystem;

/// True if another process holds the lock of the file. False where the file system has no locks.
bool is_held_by_another(int descriptor) { return ::flock(descriptor, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK; }

/// Removes an existing file with the partial name: of a killed run, or a link from an unpacked archive.
void remove_leftover(const fs::path& partial, const fs::path& path) {
  const int leftover = ::open(partial.c_str(), O_RDWR | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
  if (leftover < 0 && errno != ELOOP && errno != ENOENT) fail_to_write(path, errno);
  const bool held = leftover >= 0 && is_held_by_another(leftover);
  const int error = !held && ::unlink(partial.c_str()) != 0 ? errno : 0;  // before the lock is released
  if (leftover >= 0) ::close(leftover);
  if (held) fail_to_write(path, "another recorder is writing it");
  if (error != 0 && error != ENOENT) fail_to_write(path, error);
}

/// Creates a new file, so that no link is followed and no existing file is truncated.
int create(const fs::path& partial, const fs::path& path) {
  for (bool again = true;; again = false) {
    const int descriptor = ::open(partial.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (descriptor >= 0) return descriptor;
    if (errno != EEXIST || !again) fail_to_write(path, errno);
    remove_leftover(partial, path);
  }
}

}  // namespace

OutputFile::OutputFile(fs::path path, std::size_t buffer_bytes, MissingFolders missing) : capacity_(buffer_bytes) {
  if (missing == MissingFolders::kMade && path.has_parent_path()) {
    std::error_code error;
    fs::create_directories(path.parent_path(), error);
    if (error) fail_to_write(path, error.message());
  }
  const fs::path partial = path.string() + ".part";
  descriptor_ = create(partial, path);
  try {
    claim(path);
  } catch (...) {
    ::close(std::exchange(descriptor_, -1));
    throw;
  }
  file_ = PartialFile(std::move(path), partial);
  buffer_.reserve(capacity_);
}

// Locks the file, since two recorders of one file would overwrite each other's output. When two begin at the same time,
// one may find the other's file before it is locked, and remove it.
void OutputFile::claim(const fs::path& path) {
  const bool held = is_held_by_another(descriptor_);
  struct stat status {};
  if (::fstat(descriptor_, &status) != 0) fail_to_write(path, errno);
  if (held || status.st_nlink == 0) fail_to_write(path, "another recorder is writing it");
}

OutputFile::~OutputFile() { abandon(); }

OutputFile::OutputFile(OutputFile&& other) noexcept { *this = std::move(other); }

OutputFile& OutputFile::operator=(OutputFile&& other) noexcept {
  if (this == &other) return *this;
  abandon();
  file_ = std::move(other.file_);
  descriptor_ = std::exchange(other.descriptor_, -1);
  written_ = other.written_;
  capacity_ = other.capacity_;
  buffer_ = std::move(other.buffer_);
  return *this;
}

void OutputFile::append(std::span<const std::byte> bytes) {
  if (bytes.size() > capacity_ - buffer_.size()) flush();
  if (bytes.size() >= capacity_) {
    write_all(bytes);  // large blocks bypass the buffer
  } else {
    buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
  }
}

void OutputFile::overwrite(std::uint64_t offset, std::span<const std::byte> bytes) {
  flush();
  while (!bytes.empty()) {
    const ssize_t count = ::pwrite(descriptor_, bytes.data(), bytes.size(), static_cast<off_t>(offset));
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) fail_to_write(path(), count < 0 ? errno : ENOSPC);
    offset += static_cast<std::uint64_t>(count);
    bytes = bytes.subspan(static_cast<std::size_t>(count));
  }
}

void OutputFile::finish() {
  flush();
  // Some file systems report a full disk only when the file is closed.
  if (::close(std::exchange(descriptor_, -1)) != 0) {
    const int error = errno;
    file_.abandon();
    fail_to_write(path(), error);
  }
  file_.commit();
}

void OutputFile::flush() {
  write_all(buffer_);
  buffer_.clear();
}

void OutputFile::write_all(std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t count = ::write(descriptor_, bytes.data(), bytes.size());
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) fail_to_write(path(), count < 0 ? errno : ENOSPC);
    written_ += static_cast<std::uint64_t>(count);
    bytes = bytes.subspan(static_cast<std::size_t>(count));
  }
}

void OutputFile::abandon() noexcept {
  if (descriptor_ < 0) return;
  ::close(std::exchange(descriptor_, -1));
  file_.abandon();
}

}  // namespace swiftlet::sim
