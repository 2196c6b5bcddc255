#include <stratus/runtime/argument.h>

#include <gtest/gtest.h>

namespace stratus {
namespace {

TEST(Require, AcceptsAConditionThatHolds) {
    EXPECT_NO_THROW(require(true, "doubling", "albedo", "in [0, 1]", 0.5));
}

TEST(Require, NamesFunctionArgumentRangeAndValue) {
    try {
        require(false, "doubling", "albedo", "in [0, 1]", 1.25);
        FAIL() << "nothing was thrown";
    } catch (const std::invalid_argument& error) {
        EXPECT_STREQ(error.what(), "doubling: albedo must be in [0, 1], got 1.25");
    }
}

TEST(NearestName, IsTheOneWithTheFewestEdits) {
    const std::vector<std::string> known = {"isotropic", "rayleigh", "moments"};
    EXPECT_EQ(nearest_name("raleigh", known), "rayleigh");      // a letter is missing
    EXPECT_EQ(nearest_name("isotropiic", known), "isotropic");  // one is added
    EXPECT_EQ(nearest_name("nomemts", known), "moments");       // two are changed
}

TEST(NearestName, IsTheFirstOfEquallyNearOnes) { EXPECT_EQ(nearest_name("b", {"a", "c"}), "a"); }

TEST(NearestName, IsEmptyWithoutKnownNames) { EXPECT_EQ(nearest_name("x", {}), ""); }

}  // namespace
}  // namespace stratus
