// SPDX-License-Identifier: BSD-2-Clause
// A user database that never answers, as a directory service behind a network that is down:
// "passwd: hang" or "group: hang" in nsswitch.conf.
#include <grp.h>
#include <nss.h>
#include <pwd.h>
#include <stddef.h>
#include <unistd.h>

static enum nss_status hang(void) {
  while (pause() != 0) {
  }
  return NSS_STATUS_UNAVAIL;
}

enum nss_status _nss_hang_getpwnam_r(const char* name, struct passwd* entry, char* buffer,
                                     size_t size, int* error) {
  (void)name, (void)entry, (void)buffer, (void)size, (void)error;
  return hang();
}

enum nss_status _nss_hang_getgrnam_r(const char* name, struct group* entry, char* buffer,
                                     size_t size, int* error) {
  (void)name, (void)entry, (void)buffer, (void)size, (void)error;
  return hang();
}
