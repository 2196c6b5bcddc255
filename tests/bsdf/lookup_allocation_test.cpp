// A program of its own, because it counts every call of operator new in it.
#include <stratus/bsdf/bsdf.h>
#include <stratus/table/lookup.h>
#include <stratus/table/packed_table.h>

#include "small_table.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <new>

namespace {

std::atomic<long> allocations{0};

}  // namespace

// Out of line, for compilers that would else see free() meet memory of operator new.
[[gnu::noinline]] void* operator new(std::size_t size) {
    ++allocations;
    if (void* const memory = std::malloc(size)) return memory;
    throw std::bad_alloc();
}

[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }

namespace stratus {
namespace {

TEST(Lookup, AllocatesNothing) {
    const PhaseFunction every_kind = parse_phase_function(
        "0.1*isotropic + 0.1*rayleigh + 0.1*anisotropic:x=0.5 + 0.2*lambert_sphere + "
        "0.2*henyey_greenstein:g=0.1 + 0.1*tabulated:points=0 1/90 0/180 0.25 + "
        "0.2*moments:chi=1 0.1");
    Table table = plain_table({5, 5, 5, 5, 5}, {0.5, 8, true});
    table.phase_function = every_kind;
    const Table both = mixed(table, table);
    const TableView views[] = {table.view(), both.view().at({0.3})};
    const PackedTable packed(pack(table));
    const std::vector<float> some(20, 0.6f);
    std::vector<float> total(20);

    double sum = 0;
    const long before = allocations;
    for (const TableView& view : views)
        for (const double optical_depth : {0.1, 2.0, 100.0, HUGE_VAL}) {
            sum += reflection(view, 0.7, optical_depth, {0.4, 0.6, 1}).total();
            sum += transmission(view, 0.7, optical_depth, {0.4, 0.6, 1}).total();
        }
    sum += packed.reflection(0.7, 2, {0.4, 0.6, 1}).total();
    packed.transmission({some.data(), some.data(), some.data(), some.data(), some.data(), 20},
                        total.data());
    const long after = allocations;
    EXPECT_EQ(after - before, 0);
    EXPECT_GT(sum, 0);
}

TEST(Bsdf, AllocatesNothing) {
    const Bsdf bsdf(Slice(parse_phase_function("henyey_greenstein:g=0.5"), {{1}, {0.9}}));
    const Vector wi{0.6f, 0, 0.8f};
    const long before = allocations;
    const Bsdf::Sample drawn = bsdf.sample(wi, 0.3f, 0.6f, 0.9f);
    const float sum = drawn.value + bsdf.pdf(wi, drawn.wo) + bsdf.albedo(wi).reflected +
                      bsdf.sample(0.8f, 0.3f, 0.6f, 0.9f).value;
    const long after = allocations;
    EXPECT_EQ(after - before, 0);
    EXPECT_GT(sum, 0);
}

TEST(AllocationCount, SeesAnAllocation) {
    const long before = allocations;
    const std::vector<double> some(1000, 1.0);
    EXPECT_EQ(allocations - before, 1);
    EXPECT_EQ(some[999], 1);
}

}  // namespace
}  // namespace stratus
