// SPDX-License-Identifier: BSD-3-Clause
#include "sim/batch/writer_lock.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <stdexcept>

#include "swiftlet/sim/errors/errors.hpp"

namespace swiftlet::sim {

WriterLock::WriterLock(const std::filesystem::path& database) {
  const auto file = database.parent_path() / ("." + database.filename().string() + ".lock");
  fd_ = ::open(file.c_str(), O_RDWR | O_CREAT | O_NOFOLLOW | O_CLOEXEC, 0644);
  if (fd_ < 0 && errno == ELOOP) throw InputError(file.string() + ": expected a lock file or nothing, found a link");
  if (fd_ < 0) throw std::runtime_error(file.string() + ": cannot be written: " + std::strerror(errno));
  struct flock lock {};
  lock.l_type = F_WRLCK;
  lock.l_whence = SEEK_SET;
  if (::fcntl(fd_, F_SETLK, &lock) == 0) return;
  const int problem = errno;
  ::close(fd_);
  if (problem == EACCES || problem == EAGAIN) {
    throw InputError(file.string() + ": expected no other writer, found another `swiftlet batch`");
  }
  throw std::runtime_error(file.string() + ": cannot be locked: " + std::strerror(problem));
}

// The file is kept: after its removal two processes could lock two files of equal name.
WriterLock::~WriterLock() { ::close(fd_); }

}  // namespace swiftlet::sim
