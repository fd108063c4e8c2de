// SPDX-License-Identifier: BSD-2-Clause
// What SQLite's own layer for Unix does, without locks and shared memory.
#include "tests/bench/store/disk_vfs.hpp"

#include <fcntl.h>
#include <sqlite3.h>

#include <cerrno>
#include <cstring>

#include "tests/daemon/store/fake_disk.hpp"

namespace mlcca::bench {
namespace {

struct State {
  store::Disk* disk = nullptr;
  bool gone = false;
};
State state;

struct File {
  sqlite3_file base;  ///< what SQLite sees
  store::Disk* disk;
  int fd;
  bool new_name;  ///< the directory has not been synced since the file was made
};
File& file_of(sqlite3_file* base) { return *reinterpret_cast<File*>(base); }

/// An exception must not pass through SQLite.
template <class Call>
int guarded(const Call& call) {
  if (state.gone) return SQLITE_IOERR;
  try {
    return call();
  } catch (const store::test::PowerLoss&) {
    state.gone = true;
    return SQLITE_IOERR;
  }
}

int sync_directory(store::Disk& disk) {
  const store::OpenFile directory(disk, disk.open("/d", O_RDONLY | O_DIRECTORY));
  return directory && disk.fsync(directory.get()) == 0 ? SQLITE_OK : SQLITE_IOERR_DIR_FSYNC;
}

int close_file(sqlite3_file* base) {
  file_of(base).disk->close(file_of(base).fd);
  return SQLITE_OK;
}

int read_file(sqlite3_file* base, void* to, int bytes, sqlite3_int64 offset) {
  return guarded([&] {
    std::size_t have = 0;
    const auto wanted = static_cast<std::size_t>(bytes);
    while (have < wanted) {
      const ssize_t n =
          file_of(base).disk->pread(file_of(base).fd, static_cast<char*>(to) + have, wanted - have,
                                    static_cast<std::uint64_t>(offset) + have);
      if (n < 0 && errno == EINTR) continue;
      if (n < 0) return SQLITE_IOERR_READ;
      if (n == 0) break;
      have += static_cast<std::size_t>(n);
    }
    std::memset(static_cast<char*>(to) + have, 0, wanted - have);
    return have == wanted ? SQLITE_OK : SQLITE_IOERR_SHORT_READ;
  });
}

int write_file(sqlite3_file* base, const void* from, int bytes, sqlite3_int64 offset) {
  return guarded([&] {
    const char* next = static_cast<const char*>(from);
    auto left = static_cast<std::size_t>(bytes);
    auto at = static_cast<std::uint64_t>(offset);
    while (left > 0) {
      const ssize_t n = file_of(base).disk->pwrite(file_of(base).fd, next, left, at);
      if (n < 0 && errno == EINTR) continue;
      if (n <= 0) return errno == ENOSPC ? SQLITE_FULL : SQLITE_IOERR_WRITE;
      next += n;
      at += static_cast<std::uint64_t>(n);
      left -= static_cast<std::size_t>(n);
    }
    return SQLITE_OK;
  });
}

int truncate_file(sqlite3_file* base, sqlite3_int64 bytes) {
  return guarded([&] {
    return file_of(base).disk->truncate(file_of(base).fd, static_cast<std::uint64_t>(bytes)) == 0
               ? SQLITE_OK
               : SQLITE_IOERR_TRUNCATE;
  });
}

int sync_file(sqlite3_file* base, int /*flags*/) {
  return guarded([&]() -> int {
    File& file = file_of(base);
    if (file_of(base).disk->fdatasync(file.fd) < 0) return SQLITE_IOERR_FSYNC;
    if (!file.new_name) return SQLITE_OK;
    file.new_name = false;
    return sync_directory(*file.disk);
  });
}

int size_of_file(sqlite3_file* base, sqlite3_int64* size) {
  return guarded([&] {
    *size = file_of(base).disk->size(file_of(base).fd);
    return *size < 0 ? SQLITE_IOERR_FSTAT : SQLITE_OK;
  });
}

int is_reserved(sqlite3_file* /*base*/, int* reserved) {
  *reserved = 0;
  return SQLITE_OK;
}

sqlite3_io_methods methods() {
  sqlite3_io_methods m{};
  m.iVersion = 1;
  m.xClose = close_file;
  m.xRead = read_file;
  m.xWrite = write_file;
  m.xTruncate = truncate_file;
  m.xSync = sync_file;
  m.xFileSize = size_of_file;
  m.xLock = +[](sqlite3_file*, int) { return SQLITE_OK; };
  m.xUnlock = +[](sqlite3_file*, int) { return SQLITE_OK; };
  m.xCheckReservedLock = is_reserved;
  m.xFileControl = +[](sqlite3_file*, int, void*) { return SQLITE_NOTFOUND; };
  m.xSectorSize = +[](sqlite3_file*) { return 4096; };
  m.xDeviceCharacteristics = +[](sqlite3_file*) { return SQLITE_IOCAP_POWERSAFE_OVERWRITE; };
  return m;
}

bool exists(const char* path) {
  return static_cast<bool>(store::OpenFile(*state.disk, state.disk->open(path, O_RDONLY)));
}

int open_file(sqlite3_vfs* /*vfs*/, const char* name, sqlite3_file* base, int flags, int* out) {
  static const sqlite3_io_methods kMethods = methods();
  base->pMethods = nullptr;
  return guarded([&] {
    if (name == nullptr) return SQLITE_CANTOPEN;
    const bool is_new = (flags & SQLITE_OPEN_CREATE) != 0 && !exists(name);
    const int fd = state.disk->open(name, O_RDWR | (is_new ? O_CREAT : 0));
    if (fd < 0) return SQLITE_CANTOPEN;
    File& file = file_of(base);
    file.disk = state.disk;
    file.fd = fd;
    file.new_name = is_new && (flags & (SQLITE_OPEN_WAL | SQLITE_OPEN_MAIN_JOURNAL)) != 0;
    file.base.pMethods = &kMethods;
    if (out != nullptr) *out = flags;
    return SQLITE_OK;
  });
}

int delete_file(sqlite3_vfs* /*vfs*/, const char* name, int sync) {
  return guarded([&]() -> int {
    if (state.disk->unlink(name) < 0)
      return errno == ENOENT ? SQLITE_IOERR_DELETE_NOENT : SQLITE_IOERR_DELETE;
    return sync != 0 ? sync_directory(*state.disk) : SQLITE_OK;
  });
}

int is_there(sqlite3_vfs* /*vfs*/, const char* name, int /*flags*/, int* there) {
  return guarded([&] {
    *there = exists(name) ? 1 : 0;
    return SQLITE_OK;
  });
}

int full_name(sqlite3_vfs* /*vfs*/, const char* name, int bytes, char* to) {
  sqlite3_snprintf(bytes, to, "%s", name);
  return SQLITE_OK;
}

}  // namespace

void use_disk(store::Disk& disk) {
  state = {&disk, false};
  static const bool registered = [] {
    static sqlite3_vfs vfs = *sqlite3_vfs_find(nullptr);
    vfs.szOsFile = sizeof(File);
    vfs.pNext = nullptr;
    vfs.zName = kDiskVfs;
    vfs.xOpen = open_file;
    vfs.xDelete = delete_file;
    vfs.xAccess = is_there;
    vfs.xFullPathname = full_name;
    return sqlite3_vfs_register(&vfs, 0) == SQLITE_OK;
  }();
  static_cast<void>(registered);
}

bool power_is_gone() { return state.gone; }

}  // namespace mlcca::bench
