// Memory that was freed.
#pragma once

#include <cstddef>
#include <cstdlib>

#ifdef __GLIBC__
#if __GLIBC_PREREQ(2, 33)  // from here on it tells sizes beyond 2 GiB
#define STRATUS_TRIMS_MEMORY
#include <malloc.h>
#endif
#endif

namespace stratus {

/// Hands freed memory back to the system, which the C library (glibc) would keep: a step of a bake then
/// needs no more than its own. A little is kept: it is sooner used again than given back.
inline void trim_memory() {
#ifdef STRATUS_TRIMS_MEMORY
    constexpr std::size_t little = 16 << 20;
    if (mallinfo2().fordblks > little) malloc_trim(0);
#endif
}

}  // namespace stratus
