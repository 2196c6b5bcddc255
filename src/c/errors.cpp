#include "errors.h"

#include <cstdio>

namespace {

thread_local char last_error[1000] = "";

}  // namespace

int stratus::c::failed(int status, const char* what) noexcept {
    std::snprintf(last_error, sizeof last_error, "%s", what);
    return status;
}

const char* stratus_last_error(void) { return last_error; }

const char* stratus_version(void) { return STRATUS_VERSION; }

int stratus_abi_version(void) { return STRATUS_ABI_VERSION; }
