// Memory that was freed.
#pragma once

#include <cstdlib>

#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace stratus {

/// Hands freed memory back to the system, which the C library (glibc) would keep: a step of a bake then
/// needs no more than its own.
inline void trim_memory() {
#ifdef __GLIBC__
    malloc_trim(0);
#endif
}

}  // namespace stratus
