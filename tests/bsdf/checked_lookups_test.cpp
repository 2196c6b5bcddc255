// What lookups refuse in a build with STRATUS_CHECKED; any other build tests the refusal by itself.
#include <stratus/bsdf/bsdf.h>
#include <stratus/bsdf/slice.h>
#include <stratus/table/lookup.h>
#include <stratus/table/packed_table.h>

#include "small_table.h"
#include "table/lookup_arguments.h"

#include <gtest/gtest.h>

#include <cmath>

namespace stratus {
namespace {

TEST(CheckedLookups, NameTheArgumentItsRangeAndTheValue) {
    EXPECT_DEATH(refuse_outside("mu_in", 0, 1, -0.5), "mu_in must be in \\[0, 1\\], got -0.5");
    EXPECT_DEATH(refuse_outside("mu_in", 0, 1, double{NAN}), "mu_in .* got -?nan");
    refuse_outside("mu_in", 0, 1, 0);
    refuse_outside("optical_depth", 0, infinity, infinity);
}

TEST(CheckedLookups, EndAtWhatIsOutOfRange) {
    if (!lookups_are_checked) GTEST_SKIP() << "a build without STRATUS_CHECKED";
    const Table table = smooth_table(true);
    const Geometry level{0.5, 0.5, 0};
    const PackedTable packed(pack(table));
    const Bsdf bsdf(bind(table.view(), 0.7, 0.9));
    const Slice& slice = bsdf.slice();
    const Vector up{0, 0, 1}, longer{3, 0, 4};
    const float one = 1, low = -0.5f, nan = NAN;
    float value;
    EXPECT_DEATH(reflection(table.view(), -1, 1, level), "albedo must be in \\[0, 1\\], got -1");
    EXPECT_DEATH(packed.transmission(0.5, -1, level), "optical_depth .* got -1");
    EXPECT_DEATH(packed.reflection({&one, &one, &one, &low, &one, 1}, &value),
                 "mu_out .* got -0.5");
    EXPECT_DEATH(slice.reflection(1, low, 0), "mu_out .* got -0.5");
    EXPECT_DEATH(slice.transmission(1, &one, &one, &nan, &value), "azimuth .* got -?nan");
    EXPECT_DEATH(slice.eval(longer, up), "length of wi must be in .* got 5");
    EXPECT_DEATH(bsdf.pdf(up, longer), "length of wo must be in .* got 5");
    EXPECT_DEATH(bsdf.sample(up, 0, 2, 0), "u2 must be in \\[0, 1\\], got 2");
    EXPECT_DEATH(slice.direct(2), "mu must be in \\[0, 1\\], got 2");
}

}  // namespace
}  // namespace stratus
