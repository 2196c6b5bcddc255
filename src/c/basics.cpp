// Errors, versions, and directions as observers give them.
#include <stratus/base/direction.h>

#include "handles.h"

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

using namespace stratus::c;

int stratus_observed_direction(double incidence_deg, double emission_deg, double phase_deg,
                               double* mu_in, double* mu_out, double* azimuth, int* transmitted) {
    const char* const function = __func__;
    return run_guarded([&] {
        require_given(mu_in, function, "mu_in");
        require_given(mu_out, function, "mu_out");
        require_given(azimuth, function, "azimuth");
        require_given(transmitted, function, "transmitted");
        const auto [at, side] =
            stratus::observed_geometry({incidence_deg, emission_deg, phase_deg}, function);
        *mu_in = at.mu_in;
        *mu_out = at.mu_out;
        *azimuth = at.azimuth;
        *transmitted = side == stratus::Side::transmission ? 1 : 0;
    });
}
