// SPDX-License-Identifier: BSD-2-Clause
#include "tests/support/stretches.hpp"

#include <cstdlib>
#include <new>

namespace {

std::size_t made = 0;

}  // namespace

std::size_t mlcca::test::allocations() { return made; }

// NOLINTBEGIN(*-no-malloc,*-owning-memory,misc-new-delete-overloads): this is where it comes from
void* operator new(std::size_t size) {
  ++made;
  if (void* const memory = std::malloc(size == 0 ? 1 : size)) return memory;
  throw std::bad_alloc();
}
// Of std::stable_sort: what replaces one of them replaces all.
void* operator new(std::size_t size, const std::nothrow_t& /*tag*/) noexcept {
  ++made;
  return std::malloc(size == 0 ? 1 : size);
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
// NOLINTEND(*-no-malloc,*-owning-memory,misc-new-delete-overloads)
